# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws the big button, its progress, and the settings of the bake, the rare ones folded away."""

from __future__ import annotations

from itertools import islice

import bpy

from ..prt_addon.core.transport import raycast
from ..prt_addon.scene.bake import choose
from ..prt_addon.scene.settings import scene_settings
from ..prt_addon.session import session
from ..prt_addon.worker.job import running_job
from .presets import PRT_PT_bake_presets
from .tab import Tab, draw_text


class PRT_PT_bake(Tab, bpy.types.Panel):
    """The bake and its progress"""

    bl_idname = "PRT_PT_bake"
    bl_label = "Radiance Transfer"

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        job = running_job()
        if job:
            column = layout.column(align=True)
            column.progress(factor=job.progress, text=job.text)
            if session.before:
                column.operator("prt.keep_preview", icon="CHECKMARK")
            column.operator("prt.cancel", text="Cancel", icon="X")
            draw_text(context, layout.column(align=True), "Settings are locked until the bake ends.", "INFO")
        else:
            button = layout.column()
            button.scale_y = 1.6
            button.operator("prt.bake", icon="RENDER_STILL")
            layout.label(text=what_is_baked(context), icon="OUTLINER_OB_MESH")
        if not raycast.is_available():
            box = layout.box().column(align=True)
            draw_text(context, box, "The ray caster is missing.", "ERROR")
            draw_text(context, box, "Unshadowed transport, light and shading work.", "BLANK1")
            draw_text(context, box, "For shadows, install your platform's zip.", "BLANK1")


class PRT_PT_settings(Tab, bpy.types.Panel):
    """What is baked, and how well"""

    bl_idname = "PRT_PT_settings"
    bl_parent_id = "PRT_PT_bake"
    bl_label = "Bake"

    def draw_header_preset(self, _context: bpy.types.Context) -> None:
        PRT_PT_bake_presets.draw_panel_header(self.layout)

    def draw(self, context: bpy.types.Context) -> None:
        column = draw_settings(self.layout, context)
        ob = context.active_object
        if ob and ob.type == "MESH":
            column.separator()
            column.label(text=ob.name, icon="OBJECT_DATA")
            column.prop(ob.prt, "space")
            column.prop(ob.prt, "sides")


class PRT_PT_advanced(Tab, bpy.types.Panel):
    """Settings that are seldom needed"""

    bl_idname = "PRT_PT_advanced"
    bl_parent_id = "PRT_PT_settings"
    bl_label = "Advanced"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        settings = context.scene.prt
        column, used = settings_column(self.layout), scene_settings(context.scene).used
        for name in ("tolerance", "seed"):
            if name in used:
                column.prop(settings, name)


class PRT_PT_long_bakes(Tab, bpy.types.Panel):
    """What matters to bakes that take long or need much memory"""

    bl_idname = "PRT_PT_long_bakes"
    bl_parent_id = "PRT_PT_settings"
    bl_label = "Long Bakes"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        column = settings_column(self.layout)
        column.prop(context.scene.prt, "checkpoint_dir")
        column.prop(context.scene.prt, "memory")


_COUNTED = 100
"""Selected meshes, at most, while a panel is drawn: it takes as long in every file."""


def what_is_baked(context: bpy.types.Context) -> str:
    """What the button is going to bake, in few words."""
    count = sum(1 for _ in islice(filter(choose.is_subject, context.selected_objects), _COUNTED + 1))
    if count > _COUNTED:
        return f"More than {_COUNTED} selected meshes"
    return f"{count} selected mesh{'es' * (count > 1)}" if count else "All meshes that render"


def draw_settings(layout: bpy.types.UILayout, context: bpy.types.Context) -> bpy.types.UILayout:
    """The settings that are seldom left alone, in a column that is returned for more of them."""
    settings = context.scene.prt
    column, used = settings_column(layout), scene_settings(context.scene).used
    column.prop(settings, "mode")
    if "samples" in used:
        column.prop(settings, "samples")
    if "tolerance" in used:
        bounces = column.column()
        bounces.enabled = "bounces" in used
        bounces.prop(settings, "bounces")
    return column


def settings_column(layout: bpy.types.UILayout) -> bpy.types.UILayout:
    """Where settings go; they are locked while a bake runs."""
    column = layout.column()
    column.use_property_split = True
    column.use_property_decorate = False
    column.enabled = running_job() is None
    return column


CLASSES = (PRT_PT_bake, PRT_PT_settings, PRT_PT_advanced, PRT_PT_long_bakes)
