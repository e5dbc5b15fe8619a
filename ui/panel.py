# SPDX-License-Identifier: GPL-3.0-or-later
"""The PRT tab: the big button, the settings of the bake, the light, the shading."""

from __future__ import annotations

import bpy

from ..operators.bake import progress_text
from ..prt_addon.bake_job import running_job
from ..prt_addon.core import raycast
from ..prt_addon.scene import freshness, light


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
        column.enabled = job is None
        column.prop(settings, "mode")
        traced = column.column()
        traced.active = settings.mode != "UNSHADOWED"
        traced.prop(settings, "samples")
        if settings.mode == "INTERREFLECTED":
            traced.prop(settings, "bounces")
            traced.prop(settings, "tolerance")
        traced.prop(settings, "seed")
        if context.active_object and context.active_object.type == "MESH":
            column.prop(context.active_object.prt, "space")
        if not raycast.is_available():
            box = layout.box().column()
            box.label(text="The ray caster is missing.", icon="ERROR")
            box.label(text="Unshadowed still works.")


class PRT_PT_meshes(Tab, bpy.types.Panel):
    """What a bake may do to meshes that cannot hold its result"""

    bl_idname = "PRT_PT_meshes"
    bl_parent_id = "PRT_PT_bake"
    bl_label = "Meshes"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        self.layout.prop(context.scene.prt, "make_single_user")
        self.layout.prop(context.scene.prt, "apply_modifiers")


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
            _draw_freshness(layout.column(align=True), freshness.glance(context, ob))
        row = layout.row(align=True)
        row.operator("prt.add_shading", text="Add", icon="ADD")
        row.operator("prt.remove_shading", text="Remove", icon="REMOVE")
        layout.operator("prt.remove", text="Remove Everything", icon="TRASH")


class PRT_PT_interchange(Tab, bpy.types.Panel):
    """Files of other programs"""

    bl_idname = "PRT_PT_interchange"
    bl_parent_id = "PRT_PT_bake"
    bl_label = "Files"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, _context: bpy.types.Context) -> None:
        column = self.layout.column(align=True)
        column.operator("prt.import_games202", icon="IMPORT")
        column.operator("prt.export_games202", icon="EXPORT")


_ICONS = {"FRESH": "CHECKMARK", "UNCHECKED": "CHECKMARK", "STALE": "ERROR", "UNKNOWN": "QUESTION", "NEVER": "DOT"}


def _draw_freshness(column: bpy.types.UILayout, found: freshness.Freshness) -> None:
    """What is known of a bake, a line per cause: the sidebar is narrow."""
    headline, *details = found.lines
    if found.state == "FRESH":
        headline = "fresh when last checked"
    column.label(text=f"{found.name}: {headline}", icon=_ICONS[found.state])
    for line in details:
        column.label(text=line, icon="BLANK1")
    column.operator("prt.check", text="Check", icon="VIEWZOOM")


CLASSES = (PRT_PT_bake, PRT_PT_meshes, PRT_PT_light, PRT_PT_shading, PRT_PT_interchange)
