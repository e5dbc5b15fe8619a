# SPDX-License-Identifier: GPL-3.0-or-later
"""Defines the PRT tab of the 3D View's sidebar, which every panel here belongs to."""

from __future__ import annotations

import textwrap

import blf
import bpy

_FONT = 0  # Blender's own
_MARGINS = 82.0  # of a label with an icon in a sub-panel, and the tabs beside it; in pixels at scale 1
_FEWEST = 12  # letters in a line, however narrow the sidebar


class Tab:
    """What all panels of the tab share."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "PRT"


def wrapped(context: bpy.types.Context, text: str) -> list[str]:
    """A sentence as lines that fit beside an icon into the sidebar as wide as it is: labels do not wrap by themselves."""
    if not text.strip():
        return [text]
    scale = context.preferences.system.ui_scale
    blf.size(_FONT, context.preferences.ui_styles[0].widget.points * scale)
    room = context.region.width - _MARGINS * scale
    letters = int(room * len(text) / blf.dimensions(_FONT, text)[0])  # as many as fit on average, and then as do
    for count in range(letters, _FEWEST, -1):
        lines = textwrap.wrap(text, count)
        if all(blf.dimensions(_FONT, line)[0] <= room for line in lines):
            return lines
    return textwrap.wrap(text, _FEWEST)


def draw_text(context: bpy.types.Context, column: bpy.types.UILayout, text: str, icon: str) -> None:
    """A sentence, wrapped beside its icon."""
    for line in wrapped(context, text):
        column.label(text=line, icon=icon)
        icon = "BLANK1"
