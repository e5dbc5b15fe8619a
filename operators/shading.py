# SPDX-License-Identifier: GPL-3.0-or-later
"""Hooks the EEVEE shading into materials, or restores them."""

from __future__ import annotations

import bpy

from ..prt_addon.core.notices import counted
from ..prt_addon.scene.bake import choose
from ..prt_addon.scene.shading import shading
from .job import WhenIdle
from .reporting import reports_errors


class PRT_OT_add_shading(WhenIdle, bpy.types.Operator):
    """Relight the selected meshes' materials in EEVEE, beside their own nodes, which Cycles keeps rendering"""

    bl_idname = "prt.add_shading"
    bl_label = "Add Shading"
    bl_options = {"REGISTER", "UNDO"}

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        objects, left_out = choose.sorted_out(choose.objects_to_bake(context))
        notices = left_out + shading.add_shading(objects)
        relit = shading.relit_materials(objects)
        if not relit:
            raise choose.nothing_chosen(context, notices, "shaded")
        for one in counted(notices):
            self.report({one.kind.level}, one.sentence)
        self.report({"INFO"}, f"Added shading to {len(relit)} material{'s' * (len(relit) > 1)}.")
        return {"FINISHED"}


class PRT_OT_remove_shading(WhenIdle, bpy.types.Operator):
    """Restore the selected meshes' materials to what they were; the baked transport stays"""

    bl_idname = "prt.remove_shading"
    bl_label = "Remove Shading"
    bl_options = {"REGISTER", "UNDO"}

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        objects = choose.objects_to_bake(context)
        shading.check_relit_materials(objects)
        removed = shading.remove_shading(objects)
        self.report(
            {"INFO"},
            f"Restored {removed} material{'s' * (removed > 1)}." if removed else "There was no shading to remove.",
        )
        return {"FINISHED"}


CLASSES = (PRT_OT_add_shading, PRT_OT_remove_shading)
