# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws whether materials are relit, and whether what is baked still holds."""

from __future__ import annotations

import bpy

from ..prt_addon.scene.bake import freshness
from ..prt_addon.scene.shading import reflections
from .tab import Tab, draw_text

_WITHOUT_LIGHT = {"WIREFRAME", "SOLID"}


class PRT_PT_shading(Tab, bpy.types.Panel):
    """Hooking the relit surface into materials, and removing it; EEVEE's reflections"""

    bl_idname = "PRT_PT_shading"
    bl_parent_id = "PRT_PT_bake"
    bl_label = "Shading"

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        ob = context.active_object
        shading = getattr(getattr(context, "space_data", None), "shading", None)
        if shading and shading.type in _WITHOUT_LIGHT:
            draw_text(context, layout.column(align=True), "This view shows no baked light. Switch it:", "INFO")
            layout.prop(shading, "type", text="")
        if ob and ob.type == "MESH":
            draw_freshness(context, layout.column(align=True), freshness.glance(context, ob))
        column = layout.column(align=True)
        column.operator("prt.add_shading", icon="ADD")
        column.operator("prt.remove_shading", icon="REMOVE")
        which, icon = ("remove", "X") if reflections.are_on(context.scene) else ("add", "MOD_MIRROR")
        layout.operator(f"prt.{which}_reflections", icon=icon)
        layout.operator("prt.remove", icon="TRASH")


_ICONS = {
    "FRESH": "CHECKMARK",
    "UNCHECKED": "CHECKMARK",
    "STALE": "ERROR",
    "UNKNOWN": "QUESTION",
    "NEVER": "DOT",
    "NEWER": "ERROR",
}


def draw_freshness(context: bpy.types.Context, column: bpy.types.UILayout, found: freshness.Freshness) -> None:
    """What is known of a bake, and why."""
    headline, *details = found.lines
    if found.state == "FRESH":
        headline = "fresh when last checked"
    draw_text(context, column, f"{found.name}: {headline}", _ICONS[found.state])
    for sentence in details:
        draw_text(context, column, sentence, "BLANK1")
    column.operator("prt.check", icon="VIEWZOOM")


CLASSES = (PRT_PT_shading,)
