# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws what is written of bakes, in the sidebar of File > Export > glTF."""

from __future__ import annotations

import bpy


class FILE_PT_prt_gltf(bpy.types.Panel):
    """What the export holds of baked transport"""

    bl_space_type = "FILE_BROWSER"
    bl_region_type = "TOOL_PROPS"
    bl_parent_id = "FILE_PT_operator"
    bl_label = "PRT Relight"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        operator = context.space_data.active_operator
        return operator is not None and operator.bl_idname == "EXPORT_SCENE_OT_gltf"

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        chosen = context.scene.prt.gltf
        layout.prop(chosen, "transport")
        column = layout.column()
        column.active = chosen.transport
        column.prop(chosen, "precision")
        if chosen.precision == "SHORT":
            column.label(text="Off by 0.0015% of a layer's largest number at most")
        layout.prop(chosen, "light")


CLASSES = (FILE_PT_prt_gltf,)
