# SPDX-License-Identifier: GPL-3.0-or-later
"""The SH light of the world, and the nodes that turn it."""

from __future__ import annotations

import bpy

from ..prt_addon.scene import light
from ..prt_addon.scene.light_state import light_state
from .tab import Tab, draw_text


class PRT_PT_light(Tab, bpy.types.Panel):
    """The SH light, and the nodes that turn it"""

    bl_idname = "PRT_PT_light"
    bl_parent_id = "PRT_PT_bake"
    bl_label = "Light"

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        world, settings = context.scene.world, context.scene.prt
        state = light_state(world)
        draw_text(context, layout.column(align=True), state.text, "ERROR" if state.stale else "WORLD")
        layout.operator("prt.project_light", icon="WORLD")
        layout.prop(settings, "auto_light")
        layout.prop(settings, "window")
        if settings.window in {"HANN", "LANCZOS"}:
            layout.prop(settings, "cutoff")
        if light.has_light(world):
            followed = light.followed(world)
            for socket, name in ((followed.rotation, "Rotation"), (followed.strength, "Strength")):
                if socket:
                    layout.prop(socket, "default_value", text=name)
        layout.operator("prt.keyframe_light", icon="KEYTYPE_KEYFRAME_VEC")


CLASSES = (PRT_PT_light,)
