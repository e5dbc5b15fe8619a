# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes from arrays to arrays: previews, traces and their cache, shards, bounces."""
