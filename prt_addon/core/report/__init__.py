# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures how true a bake is: its error at random points of the surface, split into parts that one can act on."""
