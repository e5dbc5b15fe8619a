# SPDX-License-Identifier: GPL-3.0-or-later
"""Removes all that the extension put on objects, and from the world once nothing needs it."""

from __future__ import annotations

from collections import Counter

import bpy

from ..prt_addon.scene.bake import choose, removal
from ..prt_addon.scene.blender.libraries import is_local
from ..prt_addon.scene.blender.modes import object_mode
from ..prt_addon.scene.light import light
from ..prt_addon.scene.light.receivers import follow_receivers
from ..prt_addon.scene.mesh import carrier, layers, temporary_layer
from ..prt_addon.scene.report import compare, report
from ..prt_addon.scene.shading import probe, reflections, shading
from .job import WhenIdle
from .reporting import reports_errors


class PRT_OT_remove(WhenIdle, bpy.types.Operator):
    """Remove transport and shading from the selected meshes (all of the scene if none is selected), and with the last of them the SH light, reflections, probes and reports"""

    bl_idname = "prt.remove"
    bl_label = "Remove PRT"
    bl_options = {"REGISTER", "UNDO"}

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        follow_receivers()  # lets deleted objects go
        objects = choose.selected_meshes(context) or list(filter(choose.is_subject, context.scene.objects))
        for ob in objects:
            removal.check_removable(ob)
        shading.check_relit_materials(objects)
        with object_mode(context):
            removed = [ob for ob in objects if removal.remove_transport(ob) | temporary_layer.take_back(ob.data)]
            carrier.sweep()
        restored = shading.remove_shading(objects)
        if not any(layers.is_baked(mesh) and not probe.is_probe(mesh) for mesh in _meshes_in_use()):
            restored += shading.remove_all_shading()
            probe.remove_probes()
            light.remove_lights()
            for scene in filter(is_local, bpy.data.scenes):
                reflections.switch_off(scene)
            report.forget_all()
            compare.remove_difference()
        self.report({"INFO"}, _said(len(removed), restored))
        return {"FINISHED"}


def _meshes_in_use() -> list[bpy.types.Mesh]:
    """All meshes, save those that deleted objects alone still show: Blender keeps these until it saves."""
    deleted = Counter(ob.data for ob in bpy.data.objects if ob.type == "MESH" and not ob.users)
    return [mesh for mesh in bpy.data.meshes if mesh.users > deleted[mesh]]


def _said(removed: int, restored: int) -> str:
    """What was removed, in words."""
    if not removed and not restored:
        return "There was nothing to remove."
    parts = []
    if removed:
        parts.append(f"the transport of {removed} object{'s' * (removed > 1)}")
    if restored:
        parts.append(f"the shading of {restored} material{'s' * (restored > 1)}")
    return f"Removed {' and '.join(parts)}."


CLASSES = (PRT_OT_remove,)
