# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads the world's node graph: what of it drivers follow, its picture, its identity, its projection."""
