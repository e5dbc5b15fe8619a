# SPDX-License-Identifier: GPL-3.0-or-later
"""Removing all that the extension put on objects, and from the world once nothing needs it."""

from __future__ import annotations

import bpy

from ..prt_addon.scene import gather, heat_map, light, report, shading, transport_layers
from ..prt_addon.scene.modes import object_mode
from .reporting import reports_errors


class PRT_OT_remove(bpy.types.Operator):
    """Remove transport and shading from the selected meshes (all if none is selected), and the SH light with the last of them"""

    bl_idname = "prt.remove"
    bl_label = "Remove PRT"
    bl_options = {"REGISTER", "UNDO"}

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        objects = gather.objects_to_bake(context)
        with object_mode(context):
            for ob in objects:
                transport_layers.remove(ob.data)
                heat_map.remove(ob.data)
        shading.remove_shading(objects)
        if not any(transport_layers.is_baked(mesh) for mesh in bpy.data.meshes):
            report.forget(context.scene)
            if context.scene.world:
                light.remove_light(context.scene.world)
        self.report({"INFO"}, f"Removed PRT from {len(objects)} object(s).")
        return {"FINISHED"}


CLASSES = (PRT_OT_remove,)
