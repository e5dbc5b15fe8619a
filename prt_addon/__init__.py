# SPDX-License-Identifier: GPL-3.0-or-later
"""Precomputed radiance transfer: `core` computes, `scene` carries bpy's data in and out of it."""
