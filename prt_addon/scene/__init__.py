# SPDX-License-Identifier: GPL-3.0-or-later
"""Carries bpy's data in and out: meshes to arrays, worlds to light, arrays to attributes and node groups. No operators."""
