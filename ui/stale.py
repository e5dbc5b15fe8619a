# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws the list of bakes that the last check found stale, above the button that bakes them again."""

from __future__ import annotations

import bpy

from ..prt_addon.scene.bake import freshness
from .tab import Tab, draw_text

_MOST = 8
"""Lines; the others are counted."""


class PRT_PT_stale(Tab, bpy.types.Panel):
    """The bakes of this scene that were stale when they were last checked"""

    bl_idname = "PRT_PT_stale"
    bl_parent_id = "PRT_PT_bake"
    bl_label = "Stale Bakes"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return bool(freshness.listed_stale(context.scene))

    def draw(self, context: bpy.types.Context) -> None:
        column = self.layout.column(align=True)
        listed = freshness.listed_stale(context.scene)
        for one in listed[:_MOST]:
            draw_text(context, column, f"{one.name}: {', '.join(one.causes.values())}", "ERROR")
        if len(listed) > _MOST:
            column.label(text=f"and {len(listed) - _MOST} more", icon="BLANK1")
        self.layout.operator("prt.bake_stale", icon="FILE_REFRESH")


CLASSES = (PRT_PT_stale,)
