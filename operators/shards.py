# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes on several machines: each casts a share of the rays into a common folder, one of them merges the shares."""

import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import bpy
from bpy.props import BoolProperty, IntProperty

from ..prt_addon.core.bake.estimate import PROBE, ShardEstimate
from ..prt_addon.core.bake.run import DEFAULT_RUN
from ..prt_addon.core.bake.shards import PieceFolder, Shard
from ..prt_addon.core.errors import ShardError
from ..prt_addon.core.monitor import Work
from ..prt_addon.core.problem import CASTING, BakeProblem, TraceKey
from ..prt_addon.scene.bake import choose
from ..prt_addon.scene.bake.freshness import preview_notices
from ..prt_addon.scene.bake.whole_bake import WholeBake
from ..prt_addon.scene.preferences import engine_patience
from ..prt_addon.scene.settings import BakeProperties, MemoryProperties, bake_settings, run_settings
from ..prt_addon.worker import tasks
from ..prt_addon.worker.job import Job, spoken
from .bake import WholeBakeOperator
from .folder import FolderBrowser, folder_property
from .job import JobOperator


class ShardOperator(FolderBrowser, JobOperator):
    """Mixin of operators that work on the folder where the shards of one bake lie: a menu entry opens the file browser first."""

    directory: folder_property("Folder of the shards of this bake, which all machines see")  # type: ignore[valid-type]

    _asked = False
    _choices: tuple[str, ...] = ()
    """Properties that the file browser shows; all others are the scene's."""
    if TYPE_CHECKING:  # what every operator has
        properties: Any
        layout: Any

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Open the file browser, unless the folder is given."""
        self._asked = not (bpy.app.background or self.properties.is_property_set("directory"))
        return (FolderBrowser if self._asked else JobOperator).invoke(self, context, event)

    def execute(self, context: bpy.types.Context) -> set[str]:
        """For scripts, and for the file browser: its window is live, too."""
        return JobOperator.invoke(self, context, None) if self._asked else JobOperator.execute(self, context)

    def draw(self, _context: bpy.types.Context) -> None:
        """What there is to choose beside the folder."""
        for name in self._choices:
            self.layout.prop(self, name)


class PRT_OT_bake_shard(ShardOperator, BakeProperties, bpy.types.Operator):
    """Cast one share of the rays of a bake and write what they find into a folder; the file stays as it is"""

    bl_idname = "prt.bake_shard"
    bl_label = "Bake Shard"

    index: IntProperty(name="Shard", description="Which of the shards, counted from 0", default=0, soft_min=0)  # type: ignore[valid-type]
    count: IntProperty(  # type: ignore[valid-type]
        name="Shards", description="How many shards the bake is split into, the same for all", default=1, soft_min=1
    )
    estimate: BoolProperty(  # type: ignore[valid-type]
        name="Estimate",
        description="Write nothing: say how long the shards will take on this machine, and how much memory and disk",
        default=False,
        options={"SKIP_SAVE"},
    )
    _choices = ("index", "count")

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """An estimate needs no folder."""
        return (JobOperator if self.estimate else ShardOperator).invoke(self, context, event)

    def _begin(self, context: bpy.types.Context) -> Job[Any]:
        begun = time.monotonic()
        shard = Shard(self.index, self.count)
        folder = None if self.estimate else self._folder()
        settings = bake_settings(context.scene, self)
        if not settings.casts_rays:
            raise ShardError(
                "Unshadowed transport needs no rays, so there is nothing to share: use Bake PRT (prt.bake)."
            )
        whole = WholeBake(context, settings)
        self._say(context, [*whole.plan.notices, *preview_notices(choose.objects_to_bake(context))])
        problem = whole.plan.problem
        self._reading = time.monotonic() - begun
        return (
            self._estimate_job(context, problem) if folder is None else self._shard_job(context, problem, shard, folder)
        )

    def _estimate_job(self, context: bpy.types.Context, problem: BakeProblem) -> Job[Any]:
        return Job(
            tasks.estimate,
            problem,
            self.count,
            work=Work(rays=min(PROBE, problem.work.rays)),
            run=run_settings(context.scene),
            threads=context.scene.render.threads,
            patience=engine_patience(context),
        )

    def _shard_job(self, context: bpy.types.Context, problem: BakeProblem, shard: Shard, folder: Path) -> Job[Any]:
        span = shard.span(problem.receivers)
        return Job(
            tasks.shard,
            problem,
            shard,
            work=Work(rays=problem.settings.samples * (span.stop - span.start)),
            run=replace(DEFAULT_RUN, pieces=PieceFolder(folder, problem.trace_key, shard)),
            threads=context.scene.render.threads,
            patience=engine_patience(context),
        )

    def _end(self, _context: bpy.types.Context, result: ShardEstimate | None) -> None:
        assert self._job
        if result:
            for line in _estimated(result, self.count, self._reading):
                self.report({"INFO"}, line)
            return
        self._conclude(f"Baked shard {self.index} of {self.count}, {self._job.work.rays:,} rays.")


class PRT_OT_merge_shards(ShardOperator, WholeBakeOperator, MemoryProperties, bpy.types.Operator):
    """Finish a bake whose shards all lie in a folder: bounce the light and write the result, as a bake on one machine does"""

    bl_idname = "prt.merge_shards"
    bl_label = "Merge Shards"
    bl_options = {"UNDO"}

    _choices = ("update_light", "update_shading")

    def _pieces(self, _context: bpy.types.Context, key: TraceKey) -> PieceFolder | None:
        if key.mode not in CASTING:
            raise ShardError(
                "Unshadowed transport has no shards: use Bake PRT (prt.bake), or choose the mode of the shards."
            )
        pieces = PieceFolder(self._folder(), key)
        self._warn(pieces.check_complete())
        return pieces


def _estimated(found: ShardEstimate, count: int, reading: float) -> Iterator[str]:
    """Sentences about a bake in shards."""
    before = reading + found.preparing
    each = before + found.casting
    yield (
        f"{count} shard(s) of {found.receivers:,} receivers, {found.rays:,} rays: {spoken(each)} each on this machine, "
        f"{before / each:.0%} of it before the first ray, and {_size(found.memory)} beside Blender's own."
    )
    yield f"The folder will hold {_size(found.disk)}."
    yield f"The merge: {spoken(reading + found.merging)}, and {_size(found.merging_memory)} beside Blender's own."


def _size(count: int) -> str:
    """Bytes, as precise as one cares to know."""
    return f"{count / 2**30:.1f} GiB" if count >= 2**30 else f"{max(1, round(count / 2**20))} MiB"


CLASSES = (PRT_OT_bake_shard, PRT_OT_merge_shards)
