# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes a problem from arrays to arrays: unshadowed, shadowed or interreflected, whole or the shard of one machine."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..arrays import Float32
from ..monitor import Work
from ..notices import Notice
from ..problem import BakeProblem, BakeSettings, Island, Occluders
from ..transport.bounces import interreflected
from ..transport.direct import unshadowed
from ..transport.inside import MendedGather
from .run import DEFAULT_RUN, Run
from .shards import Shard
from .trace import Caster, Traced, check_finite, trace_island


@dataclass(frozen=True)
class BakeResult:
    """The result of a bake.

    Attributes:
        transport: of each group of the problem, (N, 9) float32, or (N, 9, 3) RGB if interreflected.
        direct: (N, 9) float32 of each group, the part of it that no bounce brought.
        findings: what there is to say of the groups, each with the number of its group.
    """

    transport: list[Float32]
    direct: list[Float32]
    findings: list[tuple[int, Notice]]


def bake(problem: BakeProblem, run: Run = DEFAULT_RUN) -> BakeResult:
    """Bake the transport of all receivers of a problem.

    Light bounces only off triangles whose corners are receivers: an island has groups of everything that shall bounce
    it, also of objects whose transport is not wanted. The result has the same bits whatever the order of the groups, the
    number of threads and the chunk size.

    Receivers inside other geometry take the light of open parts around them (see `transport.cover`), in whichever mode casts rays. The
    findings hold their share, and name objects that no light reaches or that float32 is too coarse for.

    Raises:
        MeshError: coordinates that are not finite, or nothing to cast rays at.
        RayCasterMissing: the mode casts rays and embreex is not installed.
        NoRoom: hits exceed `run.memory`, and the temporary folder cannot hold the rest.
        OSError: the folder of `run.pieces` cannot be written.
        Cancelled: if the workers' monitor raised it.
    """
    result = BakeResult([], [], [])
    for island, first_group, first_receiver in problem.numbered():
        baked = _bake_island(island, problem.settings, _counted_from(first_receiver, run))
        result.transport.extend(baked.transport)
        result.direct.extend(baked.direct)
        result.findings.extend((first_group + number, notice) for number, notice in baked.findings)
    return result


def trace_shard(problem: BakeProblem, shard: Shard, run: Run) -> None:
    """Cast the rays of one shard of what `bake` would bake, and save what they find in `run.pieces`.

    Once all shards lie in one folder, `bake` with it casts no more rays, and gives the same bits as without.
    Errors as those of `bake`; the mode must cast rays.
    """
    for island, _, first in problem.numbered():
        span = _overlap(shard.span(problem.receivers), first, len(island))
        if span.start < span.stop:
            check_finite(island.groups)
            for _ in Caster(island, problem.settings, _counted_from(first, run)).pieces(span):
                pass


def _counted_from(first: int, run: Run) -> Run:
    """The run of an island whose first receiver has that number."""
    return replace(run, pieces=run.pieces and run.pieces.counted_from(first))


def _overlap(span: slice, first: int, count: int) -> slice:
    """What lies of a span in `count` receivers from `first`, counted from there."""
    return slice(max(span.start - first, 0), min(span.stop - first, count))


def _bake_island(island: Island, settings: BakeSettings, run: Run) -> BakeResult:
    """The result for its groups, counted from 0."""
    if not len(island) or not settings.casts_rays:
        check_finite(island.groups)
        direct = [unshadowed(group.normals, workers=run.workers) for group in island.groups]
        return BakeResult(direct, direct, [])
    if not settings.bounces_light:
        traced = trace_island(island, settings, run)
        direct = _split(traced.direct, traced.sizes)
        return BakeResult(direct, direct, traced.findings)
    traced = _cached_or_traced(island, settings, run)
    transport = bounce(traced, island.occluders, settings, run)
    return BakeResult(transport, _split(traced.direct, traced.sizes), traced.findings)


def _cached_or_traced(island: Island, settings: BakeSettings, run: Run) -> Traced:
    if run.traces is None:
        return trace_island(island, settings, run)
    key = island.trace_key(settings)
    run.workers.monitor.check_cancelled()  # the key of a large scene takes a moment
    traced = run.traces.find(key)
    if traced:
        run.workers.monitor.advance(Work(rays=settings.samples * len(island)))
    else:
        traced = trace_island(island, settings, run)
        run.traces.add(key, traced)
    return traced


def bounce(traced: Traced, occluders: Occluders, settings: BakeSettings, run: Run = DEFAULT_RUN) -> list[Float32]:
    """Bounce the light: the second half of a bake. Only the albedo may differ from the occluders that were traced.

    Returns:
        (N, 9, 3) float32 per group, RGB.
    """
    albedo = occluders.albedo_of_sides
    receivers = sum(traced.sizes)
    gather = MendedGather(traced.mend, traced.hits, albedo, occluders.receiver_at_corners, run.workers, receivers)
    transport = interreflected(traced.direct, gather, settings.bounces, settings.tolerance)
    return _split(transport, traced.sizes)


def _split(transport: Float32, sizes: Sequence[int]) -> list[Float32]:
    """Of each group, without the samples that follow the receivers."""
    return np.split(transport, np.cumsum(sizes))[:-1]
