# SPDX-License-Identifier: GPL-3.0-or-later
"""The big button, its progress, and the settings of the bake."""

from __future__ import annotations

import bpy

from ..operators.bake import progress_text
from ..prt_addon.bake_job import running_job
from ..prt_addon.core import raycast
from .tab import Tab


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
            for line in (
                "Unshadowed transport, light",
                "and shading work. For shadows,",
                "install your platform's zip.",
            ):
                box.label(text=line)


class PRT_PT_meshes(Tab, bpy.types.Panel):
    """What a bake may do to meshes that cannot hold its result"""

    bl_idname = "PRT_PT_meshes"
    bl_parent_id = "PRT_PT_bake"
    bl_label = "Meshes"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        self.layout.prop(context.scene.prt, "make_single_user")
        self.layout.prop(context.scene.prt, "apply_modifiers")


CLASSES = (PRT_PT_bake, PRT_PT_meshes)
