# SPDX-License-Identifier: GPL-3.0-or-later
"""bpy's data in and out: meshes to arrays, worlds to light, arrays to attributes and node groups. No operators."""
