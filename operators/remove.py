# SPDX-License-Identifier: GPL-3.0-or-later
"""Removing all that the extension put on objects, and from the world once nothing needs it."""

from __future__ import annotations

import bpy

from ..prt_addon.scene import compare, gather, heat_map, light, probe, report, shading, transport_layers
from ..prt_addon.scene.modes import object_mode
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
            transport_layers.check_removable(ob)
        shading.check_relit_materials(objects)
        with object_mode(context):
            for ob in objects:
                transport_layers.remove(ob.data)
                heat_map.remove(ob.data)
        shading.remove_shading(objects)
        if not any(
            mesh.users and transport_layers.is_baked(mesh) and not probe.is_probe(mesh) for mesh in bpy.data.meshes
        ):
            probe.remove_probes()
            light.remove_lights()
            report.forget_all()
            compare.remove_difference()
        self.report({"INFO"}, f"Removed PRT from {len(objects)} object(s).")
        return {"FINISHED"}


CLASSES = (PRT_OT_remove,)
