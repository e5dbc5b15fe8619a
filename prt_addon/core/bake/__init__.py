# SPDX-License-Identifier: GPL-3.0-or-later
"""One bake from arrays to arrays: previewed, traced, cached, cut into shards, bounced."""
