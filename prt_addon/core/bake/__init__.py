# SPDX-License-Identifier: GPL-3.0-or-later
"""One bake from arrays to arrays: traced, cached, cut into shards, bounced."""
