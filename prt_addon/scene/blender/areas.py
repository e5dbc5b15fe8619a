# SPDX-License-Identifier: GPL-3.0-or-later
"""Redraws the regions of Blender's windows where panels of the extension stand."""

from __future__ import annotations

import bpy

PANELS = {"VIEW_3D": "UI", "PROPERTIES": "WINDOW"}
"""Types of areas, and of their regions, whose panels show what may change without an edit."""


def redraw_panels() -> None:
    """Redraw panels alone: a view of a million faces takes long to draw."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            for region in area.regions:
                if region.type == PANELS.get(area.type):
                    region.tag_redraw()
