# SPDX-License-Identifier: GPL-3.0-or-later
"""Copies one block of text about this Blender, this file and the last bake, to paste where help is given."""

from __future__ import annotations

import bpy

from ..prt_addon.scene.info import info
from .reporting import reports_errors


class PRT_OT_copy_info(bpy.types.Operator):
    """Copy versions, settings and what the last bake said, to paste them where you ask for help; in background they are printed"""

    bl_idname = "prt.copy_info"
    bl_label = "Copy Info"

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        text = info(context)
        if bpy.app.background:
            print(text)
        else:
            context.window_manager.clipboard = text
            self.report({"INFO"}, f"Copied {len(text.splitlines())} lines.")
        return {"FINISHED"}


CLASSES = (PRT_OT_copy_info,)
