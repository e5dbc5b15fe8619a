# SPDX-License-Identifier: GPL-3.0-or-later
"""Subdivides meshes that are too coarse for their shadows, by a modifier."""

from __future__ import annotations

import bpy

from ..prt_addon.scene.bake import choose, coarse
from ..prt_addon.scene.bake.read import read_bake
from ..prt_addon.scene.blender.modes import object_mode
from ..prt_addon.scene.mesh.carrier import carrier_of
from .job import WhenIdle
from .reporting import reports_errors

_MODIFIER = "PRT Subdivision"


class PRT_OT_refine(WhenIdle, bpy.types.Operator):
    """Subdivide the selected meshes (all render-visible ones if none is selected) where their faces are larger than what shades them, by a modifier: then bake again"""

    bl_idname = "prt.refine"
    bl_label = "Subdivide for Shadows"
    bl_options = {"REGISTER", "UNDO"}

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        with object_mode(context):
            plan = read_bake(context, choose.objects_to_bake(context))
        found = coarse.levels(plan)
        for name, level in found.items():
            _subdivide(bpy.data.objects[name], level)
        if found:
            self.report({"INFO"}, f"Subdivided {len(found)} object{'s' * (len(found) > 1)}: bake again.")
        else:
            self.report({"INFO"}, "No face is larger than what shades it.")
        return {"FINISHED"}


def _subdivide(ob: bpy.types.Object, level: int) -> None:
    """Cut each face into four, so often; once more where it was done before."""
    modifier = ob.modifiers.get(_MODIFIER)
    if modifier is None:
        modifier = ob.modifiers.new(_MODIFIER, "SUBSURF")
        modifier.subdivision_type, modifier.levels, modifier.render_levels = "SIMPLE", 0, 0
        if carrier_of(ob):
            ob.modifiers.move(len(ob.modifiers) - 1, len(ob.modifiers) - 2)
    modifier.levels += level
    modifier.render_levels += level


CLASSES = (PRT_OT_refine,)
