# SPDX-License-Identifier: GPL-3.0-or-later
"""A bake on several machines: each casts a share of the rays into a common folder, one of them merges the shares."""

from dataclasses import replace
from typing import Any

import bpy
from bpy.props import IntProperty, StringProperty

from ..prt_addon.bake_job import BakeJob
from ..prt_addon.core.bake import trace_shard
from ..prt_addon.core.errors import ShardError
from ..prt_addon.core.pieces import PieceFolder, Question, Shard
from ..prt_addon.core.run import PLAINLY
from ..prt_addon.scene.settings import (
    BakeProperties,
    MemoryProperties,
    PrepareProperties,
    bake_settings,
    preparation,
)
from ..prt_addon.scene.whole_bake import WholeBake
from .bake import WholeBakeOperator
from .folder import Folder
from .job import JobOperator


class ShardFolder(Folder):
    """Mixin of the folder where the shards of one bake lie."""

    directory: StringProperty(  # type: ignore[valid-type]
        name="Folder",
        description="Folder of the shards of this bake, which all machines see",
        subtype="DIR_PATH",
        options={"PATH_SUPPORTS_BLEND_RELATIVE"},
    )


class PRT_OT_bake_shard(JobOperator, ShardFolder, BakeProperties, PrepareProperties, bpy.types.Operator):
    """Cast one share of the rays of a bake and write what they find into a folder; the file stays as it is"""

    bl_idname = "prt.bake_shard"
    bl_label = "Bake Shard"
    bl_options = {"REGISTER"}

    index: IntProperty(name="Shard", description="Which of the shards, counted from 0", default=0, min=0)  # type: ignore[valid-type]
    count: IntProperty(  # type: ignore[valid-type]
        name="Shards", description="How many shards the bake is split into, the same for all", default=1, min=1
    )

    def _begin(self, context: bpy.types.Context) -> BakeJob[Any]:
        folder, shard = self._folder(), Shard(self.index, self.count)
        settings = bake_settings(context.scene, self)
        if settings.mode == "UNSHADOWED":
            raise ShardError("Unshadowed transport needs no rays, so that there is nothing to share: use prt.bake.")
        whole = WholeBake(context, settings, preparation(context.scene, self))
        for warning in whole.plan.warnings:
            self.report({"WARNING"}, warning)
        groups, occluders = whole.plan.groups, whole.plan.occluders
        span = shard.span(whole.question.receivers)
        return BakeJob(
            lambda run: trace_shard(groups, occluders, settings, shard, run),
            settings.samples * (span.stop - span.start),
            context.scene.render.threads,
            run=replace(PLAINLY, pieces=PieceFolder(folder, whole.question, shard)),
        )

    def _end(self, _context: bpy.types.Context, _result: Any) -> None:
        assert self._job
        self.report({"INFO"}, f"Baked shard {self.index} of {self.count}, {self._job.total:,} rays.")


class PRT_OT_merge_shards(WholeBakeOperator, ShardFolder, MemoryProperties, bpy.types.Operator):
    """Finish a bake whose shards all lie in a folder: bounce the light and write the result, as a bake on one machine does"""

    bl_idname = "prt.merge_shards"
    bl_label = "Merge Shards"
    bl_options = {"REGISTER", "UNDO"}

    def _pieces(self, _context: bpy.types.Context, question: Question) -> PieceFolder | None:
        if question.mode == "UNSHADOWED":
            raise ShardError("Unshadowed transport has no shards: use prt.bake, or choose the mode of the shards.")
        pieces = PieceFolder(self._folder(), question)
        pieces.check_complete()
        return pieces


CLASSES = (PRT_OT_bake_shard, PRT_OT_merge_shards)
