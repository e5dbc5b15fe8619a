# SPDX-License-Identifier: GPL-3.0-or-later
"""The bake: transport of the chosen meshes, the world's light and the shading, in one go."""

from dataclasses import replace
from typing import Any

import bpy
from bpy.props import BoolProperty

from ..prt_addon.core.bake.shards import PieceFolder
from ..prt_addon.core.problem import BakeSettings, TraceKey
from ..prt_addon.scene.bake import choose, freshness
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

    def _objects(self, context: bpy.types.Context, _settings: BakeSettings) -> list[bpy.types.Object]:
        """What is to be baked; empty if there is nothing to do, which is said then."""
        return choose.objects_to_bake(context)

    def _pieces(self, context: bpy.types.Context, key: TraceKey) -> PieceFolder | None:
        """Where what the rays find is kept."""
        folder = checkpoints(context.scene, self)
        return PieceFolder(folder, key) if folder else None

    def _begin(self, context: bpy.types.Context) -> Job[Any] | None:
        scene = context.scene
        settings = bake_settings(scene, self)
        objects = self._objects(context, settings)
        if not objects:
            return None
        self._bake = whole = WholeBake(
            context,
            settings,
            windowing(scene, self) if self.update_light else None,
            self.update_shading,
            objects,
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


class PRT_OT_bake_stale(WholeBakeOperator, RunProperties, bpy.types.Operator):
    """Check all bakes of the scene, selected or not, and bake those again that are stale"""

    bl_idname = "prt.bake_stale"
    bl_label = "Bake Stale"
    bl_options = {"UNDO"}

    def _objects(self, context: bpy.types.Context, settings: BakeSettings) -> list[bpy.types.Object]:
        stale = freshness.stale_objects(context, settings)
        hidden = [f"'{one.name}'" for one in stale.values() if "HIDDEN" in one.causes]
        if hidden:
            self.report({"INFO"}, f"Left as it is, because it does not render any more: {', '.join(hidden)}.")
        objects = [ob for ob, one in stale.items() if "HIDDEN" not in one.causes]
        if not objects:
            self.report({"INFO"}, "No bake that renders is stale: there is nothing to do.")
        return objects


CLASSES = (PRT_OT_bake, PRT_OT_bake_stale)
