# SPDX-License-Identifier: GPL-3.0-or-later
"""Functions on the sphere: spherical harmonics, their rotation and windows, directions, pictures of all directions."""
