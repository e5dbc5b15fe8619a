# SPDX-License-Identifier: GPL-3.0-or-later
"""Computes with functions on the sphere: spherical harmonics, their rotation and windows, directions, panoramas."""
