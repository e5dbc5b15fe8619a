# SPDX-License-Identifier: GPL-3.0-or-later
"""Removing all that the extension put on objects, and from the world once nothing needs it."""

from __future__ import annotations

import bpy

from ..prt_addon.scene.bake import gather
from ..prt_addon.scene.blender.modes import object_mode
from ..prt_addon.scene.light import light
from ..prt_addon.scene.mesh import heat_map, layers
from ..prt_addon.scene.report import compare, report
from ..prt_addon.scene.shading import probe, shading
from .reporting import reports_errors


class PRT_OT_remove(bpy.types.Operator):
    """Remove transport and shading from the selected meshes (all of the scene if none is selected), and with the last of them the SH light, probes and reports"""

    bl_idname = "prt.remove"
    bl_label = "Remove PRT"
    bl_options = {"REGISTER", "UNDO"}

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        objects = gather.selected_meshes(context) or list(filter(gather.is_subject, context.scene.objects))
        for ob in objects:
            layers.check_removable(ob)
        shading.check_relit_materials(objects)
        with object_mode(context):
            for ob in objects:
                layers.remove(ob.data)
                heat_map.remove(ob.data)
        shading.remove_shading(objects)
        if not any(mesh.users and layers.is_baked(mesh) and not probe.is_probe(mesh) for mesh in bpy.data.meshes):
            probe.remove_probes()
            light.remove_lights()
            report.forget_all()
            compare.remove_difference()
        self.report({"INFO"}, f"Removed PRT from {len(objects)} object(s).")
        return {"FINISHED"}


CLASSES = (PRT_OT_remove,)
