# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws the SH light as a small picture, and what it kept of the sky."""

from __future__ import annotations

import bpy

from ..prt_addon.glances import light_glance
from ..prt_addon.scene.light import light
from .tab import Tab


class PRT_PT_light_preview(Tab, bpy.types.Panel):
    """What the SH light, the sky as nine coefficients of spherical harmonics, shows, and the share of energy in each band"""

    bl_idname = "PRT_PT_light_preview"
    bl_parent_id = "PRT_PT_light"
    bl_label = "Preview"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return light.has_light(context.scene.world)

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        glance = light_glance(context.scene.world)
        layout.template_icon(icon_value=glance.icon, scale=7.0)
        if glance.energy:
            column = layout.column(align=True)
            column.label(text="Energy of the sky kept" if glance.energy.of_sky else "Energy by band")
            for band, share in enumerate(glance.energy.bands):
                column.label(text=f"Band {band}: {share:.1%}", icon="BLANK1")
        row = layout.row(align=True)
        row.operator("prt.show_light", text="Picture", icon="IMAGE_DATA").kind = "PICTURE"
        row.operator("prt.show_light", text="Probe", icon="SHADING_RENDERED").kind = "PROBE"


CLASSES = (PRT_PT_light_preview,)
