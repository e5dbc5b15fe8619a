# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws panels in Render, World and Object properties: what belongs there of the tab, where Blender's users look for
it.
"""

from __future__ import annotations

import bpy

from ..prt_addon.scene.bake import freshness
from .bake import draw_settings, settings_column
from .light import draw_light
from .shading import draw_freshness


class Section:
    """What all panels in the Properties editor share."""

    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_label = "PRT Relight"
    bl_options = {"DEFAULT_CLOSED"}


class PRT_PT_render(Section, bpy.types.Panel):
    """How radiance transfer is baked in this scene"""

    bl_idname = "PRT_PT_render"
    bl_context = "render"

    def draw(self, context: bpy.types.Context) -> None:
        draw_settings(self.layout, context)
        self.layout.operator("prt.bake", icon="RENDER_STILL")


class PRT_PT_world(Section, bpy.types.Panel):
    """The SH light of the scene's world: its sky as nine coefficients of spherical harmonics"""

    bl_idname = "PRT_PT_world"
    bl_context = "world"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Another world may be pinned there, which the light is not made of."""
        return context.world is not None and context.world == context.scene.world

    def draw(self, context: bpy.types.Context) -> None:
        draw_light(self.layout, context)


class PRT_PT_object(Section, bpy.types.Panel):
    """What this object is baked for, and whether its bake still holds"""

    bl_idname = "PRT_PT_object"
    bl_context = "object"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.object is not None and context.object.type == "MESH"

    def draw(self, context: bpy.types.Context) -> None:
        column = settings_column(self.layout)
        column.prop(context.object.prt, "space")
        column.prop(context.object.prt, "sides")
        draw_freshness(context, self.layout.column(align=True), freshness.glance(context, context.object))


CLASSES = (PRT_PT_render, PRT_PT_world, PRT_PT_object)
