# SPDX-License-Identifier: GPL-3.0-or-later
"""Handles Blender's data with no PRT in it: node trees, pictures, Cycles, libraries, versions, modes."""
