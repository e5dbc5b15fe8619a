# SPDX-License-Identifier: GPL-3.0-or-later
"""Computes in `core`, carries bpy's data in and out of it in `scene`, and runs the engine in `worker`."""
