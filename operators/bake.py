# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes: the transport of the chosen meshes, the world's light and the shading, in one go."""

import time
from dataclasses import replace
from math import inf
from typing import TYPE_CHECKING, Any

import bpy
from bpy.props import BoolProperty

from ..prt_addon.core.bake.bake import BakeResult
from ..prt_addon.core.bake.previews import Preview, is_worth
from ..prt_addon.core.bake.shards import PieceFolder
from ..prt_addon.core.problem import BakeProblem, BakeSettings, TraceKey
from ..prt_addon.scene.bake import choose, freshness
from ..prt_addon.scene.bake.before import take_back
from ..prt_addon.scene.bake.whole_bake import WholeBake
from ..prt_addon.scene.preferences import engine_patience
from ..prt_addon.scene.settings import (
    BakeProperties,
    LightProperties,
    RunProperties,
    bake_settings,
    checkpoints,
    light_settings,
    run_settings,
)
from ..prt_addon.session import session
from ..prt_addon.worker.job import Job, bake_job, running_job
from .job import JobOperator, redraw_views

_MOMENT = 0.01  # seconds for each turn of writing a preview, between which the window redraws
_LIVE = 0.05  # seconds between two turns, beyond which redrawing it more often would but hold the picture up


class WholeBakeOperator(JobOperator, BakeProperties, LightProperties):
    """Mixin of operators that bake and write the result."""

    update_light: BoolProperty(  # type: ignore[valid-type]
        name="Project World", description="Also project the world's sky into the SH light", default=True
    )
    update_shading: BoolProperty(  # type: ignore[valid-type]
        name="Add Shading", description="Also relight the materials in EEVEE", default=True
    )

    _preview: Preview | None = None
    """The latest that the engine has shown, and"""
    _is_shown = False
    """whether all of it was written."""
    _looked = 0.0
    """When that was last seen to."""

    def _objects(self, context: bpy.types.Context, _settings: BakeSettings) -> list[bpy.types.Object]:
        """What is to be baked; empty if there is nothing to do, which is said then."""
        return choose.objects_to_bake(context)

    def _pieces(self, context: bpy.types.Context, key: TraceKey) -> PieceFolder | None:
        """Where what the rays find is kept."""
        folder = checkpoints(context.scene, self)
        return PieceFolder(folder, key) if folder else None

    def _wants_previews(self, _problem: BakeProblem) -> bool:
        """Whether previews are shown before the end."""
        return False

    def _begin(self, context: bpy.types.Context) -> Job[Any] | None:
        scene = context.scene
        settings = bake_settings(scene, self)
        objects = self._objects(context, settings)
        if not objects:
            return None
        self._bake = whole = WholeBake(
            context,
            settings,
            light_settings(scene, self) if self.update_light else None,
            self.update_shading,
            objects,
        )
        problem = whole.plan.problem
        run = replace(run_settings(scene, self), pieces=self._pieces(context, problem.trace_key))
        wants = self._wants_previews(problem)
        job = bake_job(problem, run, scene.render.threads, engine_patience(context), wants)
        if wants and (first := whole.first_preview()):
            job.show(first)
        self._looked = time.monotonic()
        return job

    def _look(self, context: bpy.types.Context) -> None:
        assert self._job
        self._bake.look()
        if shown := self._job.take_shown():
            self._preview, self._is_shown = shown, False
        if self._preview and not self._is_shown and self._bake.can_show(context):
            self._show_more(context, self._preview)
        self._looked = time.monotonic()

    def _show_more(self, context: bpy.types.Context, preview: Preview) -> None:
        """Write a preview for a moment; all of it at once where the window is slow by itself."""
        assert self._job
        is_live = time.monotonic() - self._looked < _LIVE
        if self._bake.show(context, preview, _MOMENT if is_live else inf):
            self._is_shown = True
            self._job.shows = f"preview, {preview.text}"
            redraw_views(context)

    def _abandon(self) -> None:
        super()._abandon()
        self._warn(f"'{name}' was edited: its earlier transport is gone." for name in take_back())

    def _end(self, context: bpy.types.Context, result: Any) -> None:
        assert self._job
        if isinstance(result, Preview):
            self._write(context, result.result, result)
            self._conclude(f"Kept the preview of {self._bake.summary}, {result.text}.")
        else:
            self._write(context, result)
            self._conclude(f"Baked {self._bake.summary}, {self._job.work.rays:,} rays.")

    def _write(self, context: bpy.types.Context, result: BakeResult, preview: Preview | None = None) -> None:
        notices, notes = self._bake.write(context, result, preview)
        self._say(context, self._bake.notices(result) + notices)
        for note in notes:
            self.report({"INFO"}, note)


class _PreviewedBake(WholeBakeOperator, RunProperties):
    """Mixin of bakes that show something before their end, if they are watched."""

    previews: BoolProperty(  # type: ignore[valid-type]
        name="Previews",
        description="Show what comes before all rays are cast. On by default for the button, off for scripts",
        default=False,
        options={"SKIP_SAVE"},
    )
    if TYPE_CHECKING:  # what every operator has
        properties: Any

    def _wants_previews(self, problem: BakeProblem) -> bool:
        if self.properties.is_property_set("previews"):
            return bool(self.previews)
        return self._is_watched and is_worth(problem)


class PRT_OT_bake(_PreviewedBake, bpy.types.Operator):
    """Bake how light travels over the selected meshes (all render-visible ones if none is selected), so that any sky can relight them"""

    bl_idname = "prt.bake"
    bl_label = "Bake PRT"
    bl_options = {"UNDO"}


class PRT_OT_bake_stale(_PreviewedBake, bpy.types.Operator):
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


class PRT_OT_keep_preview(bpy.types.Operator):
    """Stop the bake, and keep the preview that is shown"""

    bl_idname = "prt.keep_preview"
    bl_label = "Keep Preview"
    bl_options = {"INTERNAL"}

    @classmethod
    def poll(cls, _context: bpy.types.Context) -> bool:
        if running_job() and session.before:
            return True
        cls.poll_message_set("No preview is shown")
        return False

    def execute(self, _context: bpy.types.Context) -> set[str]:
        job = running_job()
        if job:
            job.keep()
        return {"FINISHED"}


CLASSES = (PRT_OT_bake, PRT_OT_bake_stale, PRT_OT_keep_preview)
