# SPDX-License-Identifier: GPL-3.0-or-later
"""The PRT tab: the big button, the settings of the bake, the light, the shading."""

from __future__ import annotations

import bpy

from ..operators.bake import progress_text
from ..prt_addon.bake_job import running_job
from ..prt_addon.core import raycast
from ..prt_addon.scene import light, transport_layers


class Tab:
    """What all panels of the tab share."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "PRT"


class PRT_PT_bake(Tab, bpy.types.Panel):
    """Bake button, progress and settings"""

    bl_idname = "PRT_PT_bake"
    bl_label = "Radiance Transfer"

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        settings = context.scene.prt
        job = running_job()
        if job:
            row = layout.row(align=True)
            row.progress(factor=job.progress, text=progress_text(job))
            row.operator("prt.cancel", text="", icon="X")
        else:
            button = layout.column()
            button.scale_y = 1.6
            button.operator("prt.bake", icon="RENDER_STILL")
        column = layout.column()
        column.prop(settings, "mode")
        traced = column.column()
        traced.active = settings.mode != "UNSHADOWED"
        traced.prop(settings, "samples")
        if settings.mode == "INTERREFLECTED":
            traced.prop(settings, "bounces")
            traced.prop(settings, "tolerance")
        traced.prop(settings, "seed")
        if not raycast.is_available():
            box = layout.box().column()
            box.label(text="The ray caster is missing.", icon="ERROR")
            box.label(text="Unshadowed still works.")


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


class PRT_PT_shading(Tab, bpy.types.Panel):
    """Hooking the relit surface into materials, and removing it"""

    bl_idname = "PRT_PT_shading"
    bl_parent_id = "PRT_PT_bake"
    bl_label = "Shading"

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        ob = context.active_object
        if ob and ob.type == "MESH":
            baked = transport_layers.is_baked(ob.data)
            layout.label(text=f"{ob.name}: {'baked' if baked else 'not baked'}", icon="CHECKMARK" if baked else "DOT")
        row = layout.row(align=True)
        row.operator("prt.add_shading", text="Add", icon="ADD")
        row.operator("prt.remove_shading", text="Remove", icon="REMOVE")
        layout.operator("prt.remove", text="Remove Everything", icon="TRASH")


CLASSES = (PRT_PT_bake, PRT_PT_light, PRT_PT_shading)
