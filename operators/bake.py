# SPDX-License-Identifier: GPL-3.0-or-later
"""The bake: transport of the chosen meshes, the world's light and the shading, in one go."""

from dataclasses import replace
from typing import Any

import bpy
from bpy.props import BoolProperty

from ..prt_addon.core.bake.shards import PieceFolder
from ..prt_addon.core.problem import TraceKey
from ..prt_addon.scene.bake.whole_bake import WholeBake
from ..prt_addon.scene.preferences import engine_patience
from ..prt_addon.scene.settings import (
    BakeProperties,
    LightProperties,
    RunProperties,
    bake_settings,
    checkpoints,
    run_settings,
    windowing,
)
from ..prt_addon.worker.job import Job, bake_job
from .job import JobOperator


class WholeBakeOperator(JobOperator, BakeProperties, LightProperties):
    """Mixin of operators that bake and write the result."""

    update_light: BoolProperty(  # type: ignore[valid-type]
        name="Project World", description="Also project the world's sky into the SH light", default=True
    )
    update_shading: BoolProperty(  # type: ignore[valid-type]
        name="Add Shading", description="Also relight the materials in EEVEE", default=True
    )

    def _pieces(self, context: bpy.types.Context, key: TraceKey) -> PieceFolder | None:
        """Where what the rays find is kept."""
        raise NotImplementedError

    def _begin(self, context: bpy.types.Context) -> Job[Any]:
        scene = context.scene
        settings = bake_settings(scene, self)
        self._bake = whole = WholeBake(
            context,
            settings,
            windowing(scene, self) if self.update_light else None,
            self.update_shading,
        )
        problem = whole.plan.problem
        run = replace(run_settings(scene, self), pieces=self._pieces(context, problem.trace_key))
        return bake_job(problem, run, scene.render.threads, engine_patience(context))

    def _end(self, context: bpy.types.Context, result: Any) -> None:
        assert self._job
        notices, notes = self._bake.write(context, result)
        self._say(context, self._bake.notices(result) + notices)
        for note in notes:
            self.report({"INFO"}, note)
        self._conclude(f"Baked {self._bake.summary}, {self._job.work.rays:,} rays.")


class PRT_OT_bake(WholeBakeOperator, RunProperties, bpy.types.Operator):
    """Bake how light travels over the selected meshes (all render-visible ones if none is selected), so that any sky can relight them"""

    bl_idname = "prt.bake"
    bl_label = "Bake PRT"
    bl_options = {"UNDO"}

    def _pieces(self, context: bpy.types.Context, key: TraceKey) -> PieceFolder | None:
        folder = checkpoints(context.scene, self)
        return PieceFolder(folder, key) if folder else None


CLASSES = (PRT_OT_bake,)
