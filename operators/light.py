# SPDX-License-Identifier: GPL-3.0-or-later
"""Projects the world to its SH light, now or over a range of frames."""

import bpy
from bpy.props import IntProperty

from ..prt_addon.scene.light import keyframes, light
from ..prt_addon.scene.settings import LightProperties, light_settings
from ..prt_addon.scene.sky import projection, sky
from .reporting import reports_errors
from .stepwise import Steps, StepwiseOperator


class PRT_OT_project_light(LightProperties, bpy.types.Operator):
    """Project the world's sky into the SH light, which lights what is baked: nine coefficients of spherical harmonics. Nothing is baked"""

    bl_idname = "prt.project_light"
    bl_label = "Project World"
    bl_options = {"UNDO"}

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        here = sky.read_sky(context.scene)
        light.check_world(here.holder)
        projected = projection.project(here, light_settings(context.scene, self))
        light.write_light(here, projected)
        for sentence in projected.sentences:
            self.report({"INFO"}, sentence)
        return {"FINISHED"}


class PRT_OT_keyframe_light(StepwiseOperator, LightProperties, bpy.types.Operator):
    """Project the world frame by frame and keyframe the light, for skies whose change cannot be followed, such as a moving sun"""

    bl_idname = "prt.keyframe_light"
    bl_label = "Keyframe Light"
    bl_options = {"UNDO"}

    _activity, _unit = "Keyframing the light", "frame"

    frame_start: IntProperty(  # type: ignore[valid-type]
        name="Start", description="First frame to keyframe; the scene's, if it is not given"
    )
    frame_end: IntProperty(  # type: ignore[valid-type]
        name="End", description="Last frame to keyframe; the scene's, if it is not given"
    )
    step: IntProperty(  # type: ignore[valid-type]
        name="Step", description="Frames from one keyframe to the next; between them the light blends", default=1, min=1
    )

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        """Open the dialog, beginning with the scene's frames unless others are given."""
        self.frame_start, self.frame_end = self._range(context.scene)
        return self._open_dialog(context)

    def _begin(self, context: bpy.types.Context) -> Steps:
        scene = context.scene
        frames = keyframes.keyframes(*self._range(scene), self.step)
        return Steps(keyframes.keyframe(scene, frames, light_settings(scene, self)), len(frames))

    def _range(self, scene: bpy.types.Scene) -> tuple[int, int]:
        given = self.properties.is_property_set
        first = self.frame_start if given("frame_start") else scene.frame_start
        return first, self.frame_end if given("frame_end") else scene.frame_end

    def _end(self, context: bpy.types.Context) -> None:
        world = context.scene.world.name
        self.report({"INFO"}, f"Keyframed the light of world '{world}' at {self._steps.count} frame(s).")


CLASSES = (PRT_OT_project_light, PRT_OT_keyframe_light)
