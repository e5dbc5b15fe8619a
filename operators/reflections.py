# SPDX-License-Identifier: GPL-3.0-or-later
"""Turns on EEVEE's ray tracing over relit surfaces, and turns it back."""

from __future__ import annotations

import bpy

from ..prt_addon.core.errors import PRTError
from ..prt_addon.scene.blender.libraries import check_local
from ..prt_addon.scene.light import light
from ..prt_addon.scene.shading import reflections
from .reporting import reports_errors


class PRT_OT_add_reflections(bpy.types.Operator):
    """Set EEVEE's ray tracing so that gloss mirrors the relit surfaces that are on the screen, and these keep the light that was baked"""

    bl_idname = "prt.add_reflections"
    bl_label = "Add Reflections"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if not light.has_light(context.scene.world):
            cls.poll_message_set("Nothing is relit in this scene: press Bake PRT first")
            return False
        return True

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        scene = context.scene
        check_local(scene, f"Scene '{scene.name}'", "add reflections", PRTError)
        if reflections.switch_on(scene):
            self.report(
                {"INFO"}, "EEVEE traces reflections on the screen, and leaves the light of relit surfaces alone."
            )
        else:
            self.report({"INFO"}, "EEVEE's ray tracing was set like that already.")
        return {"FINISHED"}


class PRT_OT_remove_reflections(bpy.types.Operator):
    """Set EEVEE's ray tracing back to what it was before Add Reflections"""

    bl_idname = "prt.remove_reflections"
    bl_label = "Remove Reflections"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if not reflections.are_on(context.scene):
            cls.poll_message_set("Add Reflections has changed nothing in this scene")
            return False
        return True

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        scene = context.scene
        check_local(scene, f"Scene '{scene.name}'", "remove reflections", PRTError)
        reflections.switch_off(scene)
        self.report({"INFO"}, "EEVEE's ray tracing is set as it was before.")
        return {"FINISHED"}


CLASSES = (PRT_OT_add_reflections, PRT_OT_remove_reflections)
