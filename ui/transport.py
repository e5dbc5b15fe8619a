# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws the buttons that show the transport itself."""

from __future__ import annotations

import bpy

from .tab import Tab, draw_text


class PRT_PT_transport(Tab, bpy.types.Panel):
    """What was baked, as colours on the meshes"""

    bl_idname = "PRT_PT_transport"
    bl_parent_id = "PRT_PT_bake"
    bl_label = "Transport"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        shading = getattr(getattr(context, "space_data", None), "shading", None)
        if shading and (shading.type != "SOLID" or shading.color_type != "VERTEX"):
            column = layout.column(align=True)
            draw_text(context, column, "Solid shading with the colour Attribute shows it:", "INFO")
            column.prop(shading, "type", text="")
            if shading.type == "SOLID":
                column.prop(shading, "color_type", text="")
        column = layout.column(align=True)
        column.operator_menu_enum("prt.show_transport", "part", icon="SHADING_SOLID")
        column.operator("prt.hide_transport", icon="HIDE_ON")


CLASSES = (PRT_PT_transport,)
