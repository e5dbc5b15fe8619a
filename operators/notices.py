# SPDX-License-Identifier: GPL-3.0-or-later
"""Selects the objects that a message of the last bake is about."""

from __future__ import annotations

import bpy
from bpy.props import IntProperty

from ..prt_addon.session import session


class PRT_OT_select_noticed(bpy.types.Operator):
    """Select the objects that this sentence is about"""

    bl_idname = "prt.select_noticed"
    bl_label = "Select"
    bl_options = {"UNDO", "INTERNAL"}

    index: IntProperty(name="Sentence", description="Which of the sentences, counted from 0", default=0, min=0)  # type: ignore[valid-type]

    def execute(self, context: bpy.types.Context) -> set[str]:
        notices = session.notices.get(context.scene.session_uid, [])
        names = set(notices[self.index].names) if self.index < len(notices) else set()
        found = [
            ob
            for ob in context.view_layer.objects
            if ob.name in names or names & {slot.material.name for slot in ob.material_slots if slot.material}
        ]
        if not found:
            self.report({"INFO"}, "None of them is in this view layer.")
            return {"CANCELLED"}
        for ob in context.view_layer.objects:
            ob.select_set(ob in found)
        context.view_layer.objects.active = found[0]
        return {"FINISHED"}


CLASSES = (PRT_OT_select_noticed,)
