# SPDX-License-Identifier: GPL-3.0-or-later
"""The world's graph: what is followed of it, its picture, its identity, its projection."""
