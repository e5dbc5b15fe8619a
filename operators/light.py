# SPDX-License-Identifier: GPL-3.0-or-later
"""The SH light alone: project the world, or take the light off it."""

from __future__ import annotations

import bpy

from ..prt_addon.scene import light, sky
from .reporting import reports_errors


class PRT_OT_project_light(bpy.types.Operator):
    """Project the world's HDRI into the SH light, without baking. Turning the world or changing its strength needs no new projection"""

    bl_idname = "prt.project_light"
    bl_label = "Project World"
    bl_options = {"REGISTER", "UNDO"}

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        environment = sky.read_sky(context.scene)
        light.write_light(environment, light.picture_light(environment))
        self.report(
            {"INFO"}, f"Projected '{environment.image.name}' into the light of world '{environment.world.name}'."
        )
        return {"FINISHED"}


CLASSES = (PRT_OT_project_light,)
