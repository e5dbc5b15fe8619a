# SPDX-License-Identifier: GPL-3.0-or-later
"""One bake from arrays to arrays: unshadowed, shadowed or interreflected, whole or the share of one machine."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from .albedo import Albedo
from .buried import FilledGather
from .casting import Caster, Traced, check_finite, trace_groups
from .inputs import BakeSettings, Occluders, ReceiverGroup
from .interreflection import full_bounces, interreflected
from .kept import Findings, KeptTraces
from .pieces import Shard
from .run import PLAINLY, Run
from .transport import unshadowed

Float32 = npt.NDArray[np.float32]

_BOUNCE_IN_RAYS = 0.1  # measured: reading a hit takes as long as that share of its ray


def ray_count(groups: Sequence[ReceiverGroup], settings: BakeSettings) -> int:
    """Rays that `bake_all` and `bake` will report to their progress."""
    return 0 if settings.mode == "UNSHADOWED" else settings.samples * sum(map(len, groups))


def bounce_work(groups: Sequence[ReceiverGroup], settings: BakeSettings) -> int:
    """What `bake_all` and `bake` will report to `Run.bounced`, about."""
    if settings.mode != "INTERREFLECTED":
        return 0
    bounces = BakeSettings.bounces if settings.tolerance > 0.0 else settings.bounces  # nobody knows: as often as usual
    return int(_BOUNCE_IN_RAYS * full_bounces(bounces) * settings.samples * sum(map(len, groups)))


def bake_all(
    groups: Sequence[ReceiverGroup],
    occluders: Occluders,
    settings: BakeSettings,
    run: Run = PLAINLY,
) -> list[Float32]:
    """As `bake`, with a bake apart for every group that has occluders of its own.

    Args:
        occluders: of the other groups; `corner_receiver` counts the receivers of these alone.
    """
    results: dict[int, Float32] = {}
    for part in _parts(groups, occluders):
        together = bake(part.of(groups), part.occluders, settings, part.run(run))
        results.update(zip(part.members, together, strict=True))
    return [results[k] for k in range(len(groups))]


def trace_shard(
    groups: Sequence[ReceiverGroup],
    occluders: Occluders,
    settings: BakeSettings,
    shard: Shard,
    run: Run,
) -> None:
    """Cast the rays of one shard of what `bake_all` would bake, and save what they find to `run.pieces`.

    Once all shards lie in one folder, `bake_all` with it casts no more rays, and gives the same bits as without.
    Arguments and errors as those of `bake_all`; the mode must cast rays.
    """
    for part in _parts(groups, occluders):
        members = part.of(groups)
        span = _overlap(shard.span(sum(map(len, groups))), part.first, sum(map(len, members)))
        if span.start < span.stop:
            check_finite(members)
            for _ in Caster(members, part.occluders, settings, part.run(run)).pieces(span):
                pass


@dataclass(frozen=True)
class _Part:
    """Groups that are baked together.

    members: which groups.
    first: number of their first receiver, through all parts.
    """

    members: list[int]
    occluders: Occluders
    first: int

    def of(self, groups: Sequence[ReceiverGroup]) -> list[ReceiverGroup]:
        return [groups[k] for k in self.members]

    def run(self, run: Run) -> Run:
        return replace(run, pieces=run.pieces and run.pieces.counted_from(self.first))


def _parts(groups: Sequence[ReceiverGroup], occluders: Occluders) -> Iterator[_Part]:
    """Those without occluders of their own together, then each of the others."""
    staying = [k for k, group in enumerate(groups) if group.own is None]
    first = 0
    for members, blocking in [(staying, occluders), *(([k], group.own) for k, group in enumerate(groups) if group.own)]:
        if members and blocking:
            yield _Part(members, blocking, first)
            first += sum(len(groups[k]) for k in members)


def _overlap(span: slice, first: int, count: int) -> slice:
    """What lies of a span in `count` receivers from `first`, counted from there."""
    return slice(max(span.start - first, 0), min(span.stop - first, count))


def bake(
    groups: Sequence[ReceiverGroup],
    occluders: Occluders,
    settings: BakeSettings,
    run: Run = PLAINLY,
) -> list[Float32]:
    """Transport of every group: (N, 9) float32 each, or (N, 9, 3) RGB if interreflected.

    Light bounces only off triangles whose corners are receivers: pass the groups of everything that shall bounce it,
    and drop the results that are not wanted. The result has the same bits whatever the order of the groups, the number
    of threads and the chunk size.

    Receivers inside other geometry are filled from their neighbours (see `buried`), in whichever mode casts rays;
    `run.tell` is told their share, and of objects that no light reaches or that float32 is too coarse for.

    Raises:
        MeshError: coordinates that are not finite, or nothing to cast rays at.
        RayCasterMissing: the mode casts rays and embreex is not installed.
        NoRoom: hits exceed `run.memory`, and the temporary folder cannot hold the rest.
        OSError: the folder of `run.pieces` cannot be written.
        Cancelled: if the workers' progress raised it.
    """
    if settings.mode == "INTERREFLECTED":
        if run.kept:
            traced = _kept_or_traced(run.kept, groups, occluders, settings, run)
        else:
            traced = trace_groups(groups, occluders, settings, run)
        return bounce(traced, occluders, settings, run)
    check_finite(groups)
    if settings.mode == "UNSHADOWED":
        return [unshadowed(group.normals, workers=run.workers) for group in groups]
    traced = trace_groups(groups, occluders, settings, run)
    return _split(traced.direct, traced.sizes)


def _kept_or_traced(
    kept: KeptTraces,
    groups: Sequence[ReceiverGroup],
    occluders: Occluders,
    settings: BakeSettings,
    run: Run,
) -> Traced:
    numbers = {id(group): number for number, group in enumerate(groups)}

    def trace_now() -> tuple[Traced, Findings]:
        findings: Findings = []
        run.workers.progress(0)  # to compare a large scene with those that were kept takes a moment

        def note(group: ReceiverGroup, sentence: str) -> None:
            findings.append((numbers[id(group)], sentence))

        return trace_groups(groups, occluders, settings, replace(run, tell=note)), findings

    traced, findings, was_kept = kept.get_or_trace(groups, occluders, settings, trace_now)
    if was_kept:
        run.workers.progress(ray_count(groups, settings))
    for number, sentence in findings:
        run.tell(groups[number], sentence)
    return traced


def bounce(
    traced: Traced,
    occluders: Occluders,
    settings: BakeSettings,
    run: Run = PLAINLY,
) -> list[Float32]:
    """The second half: bounce the light. Only the albedo may differ from the occluders that were traced.

    Returns:
        (N, 9, 3) float32 per group, RGB.
    """
    albedo = occluders.albedo or Albedo(np.ones_like(occluders.triangles, dtype=np.float32))

    def watch(rays: int) -> None:
        run.bounced(int(_BOUNCE_IN_RAYS * rays))
        run.workers.progress(0)

    workers = replace(run.workers, progress=watch)
    gather = FilledGather(traced.fill, traced.hits, albedo, occluders.receiver_at_corners, workers)
    transport = interreflected(traced.direct, gather, settings.bounces, settings.tolerance)
    return _split(transport, traced.sizes)


def _split(transport: Float32, sizes: Sequence[int]) -> list[Float32]:
    return np.split(transport, np.cumsum(sizes)[:-1])
