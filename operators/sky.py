# SPDX-License-Identifier: GPL-3.0-or-later
"""Lights worlds that have no sky by one of the HDRIs that Blender ships."""

from __future__ import annotations

import bpy
from bpy.props import EnumProperty

from ..prt_addon.scene.light import light
from ..prt_addon.scene.settings import LightProperties, light_settings
from ..prt_addon.scene.sky import projection, sky
from ..prt_addon.scene.sky.studio import studio_skies, use_studio_sky
from .reporting import reports_errors

_SKIES = [
    (name, name.title(), f"Blender's own picture of that name: {path.name}") for name, path in studio_skies().items()
]


class PRT_OT_use_sky(LightProperties, bpy.types.Operator):
    """Light the world with one of the HDRIs that Blender ships, and project it into the SH light"""

    bl_idname = "prt.use_sky"
    bl_label = "Choose a Sky"
    bl_options = {"UNDO"}

    sky: EnumProperty(name="Sky", description="Which picture", items=_SKIES)  # type: ignore[valid-type]

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        if context.scene.world:
            light.check_world(context.scene.world)
        use_studio_sky(context.scene, self.sky)
        here = sky.read_sky(context.scene)
        projected = projection.project(here, light_settings(context.scene, self))
        light.write_light(here, projected)
        for sentence in projected.sentences:
            self.report({"INFO"}, sentence)
        return {"FINISHED"}


CLASSES = (PRT_OT_use_sky,)
