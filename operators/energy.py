# SPDX-License-Identifier: GPL-3.0-or-later
"""Adds the node group that gives rough metal back the light it loses, and removes it."""

from __future__ import annotations

import bpy

from ..prt_addon.scene.bake import choose
from ..prt_addon.scene.blender.libraries import is_local
from ..prt_addon.scene.shading import energy_group
from ..prt_addon.scene.shading.shown_materials import materials_of
from .job import WhenIdle
from .reporting import reports_errors


class PRT_OT_add_energy_compensation(WhenIdle, bpy.types.Operator):
    """Put PRT Energy Compensation before each Glossy BSDF of type GGX in the selected meshes' materials: rough metal returns the light that it loses, in EEVEE and in Cycles"""

    bl_idname = "prt.add_energy_compensation"
    bl_label = "Add Energy Compensation"
    bl_options = {"REGISTER", "UNDO"}

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        count = energy_group.compensate(_own_materials(context))
        if not count:
            self.report(
                {"INFO"},
                "There is no Glossy BSDF of type GGX to compensate: Multiscatter GGX and Principled BSDF lose no light.",
            )
            return {"CANCELLED"}
        self.report({"INFO"}, f"Compensated {count} Glossy BSDF{'s' * (count > 1)}.")
        return {"FINISHED"}


class PRT_OT_remove_energy_compensation(WhenIdle, bpy.types.Operator):
    """Take PRT Energy Compensation out of the selected meshes' materials again"""

    bl_idname = "prt.remove_energy_compensation"
    bl_label = "Remove Energy Compensation"
    bl_options = {"REGISTER", "UNDO"}

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        count = energy_group.take_out(_own_materials(context))
        self.report({"INFO"}, f"Took the compensation off {count} Glossy BSDF{'s' * (count != 1)}.")
        return {"FINISHED"} if count else {"CANCELLED"}


def _own_materials(context: bpy.types.Context) -> list[bpy.types.Material]:
    """Of the selected meshes, or of all that render if none is selected."""
    return [material for material in materials_of(choose.objects_to_bake(context)) if is_local(material)]


CLASSES = (PRT_OT_add_energy_compensation, PRT_OT_remove_energy_compensation)
