# SPDX-License-Identifier: GPL-3.0-or-later
"""The SH light of the world, and the nodes that turn it."""

from __future__ import annotations

import bpy

from ..prt_addon.scene import light
from .tab import Tab


class PRT_PT_light(Tab, bpy.types.Panel):
    """The SH light, and the nodes that turn it"""

    bl_idname = "PRT_PT_light"
    bl_parent_id = "PRT_PT_bake"
    bl_label = "Light"

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        world = context.scene.world
        if not light.has_light(world):
            layout.label(text="No SH light on the world yet", icon="WORLD")
        layout.operator("prt.project_light", icon="WORLD")
        nodes = light.followed_nodes(world) if light.has_light(world) else None
        if nodes:
            mapping, background = nodes
            layout.prop(mapping.inputs["Rotation"], "default_value", text="Rotation")
            layout.prop(background.inputs["Strength"], "default_value", text="Strength")


CLASSES = (PRT_PT_light,)
