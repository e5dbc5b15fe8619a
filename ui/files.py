# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws the buttons for files of other programs."""

from __future__ import annotations

import bpy

from .tab import Tab


class PRT_PT_files(Tab, bpy.types.Panel):
    """Files of other programs"""

    bl_idname = "PRT_PT_files"
    bl_parent_id = "PRT_PT_bake"
    bl_label = "Files"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, _context: bpy.types.Context) -> None:
        column = self.layout.column(align=True)
        column.operator("prt.import_cubemap", icon="IMPORT")
        column.operator("prt.import_games202", icon="IMPORT")
        column.operator("prt.export_games202", icon="EXPORT")
        column.operator("prt.export_web_page", icon="WORLD")
        column.operator("prt.freeze", icon="FREEZE")


CLASSES = (PRT_PT_files,)
