# SPDX-License-Identifier: GPL-3.0-or-later
"""One bake from arrays to arrays: receivers of several objects, what blocks their light, one set of settings."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import numpy.typing as npt

from . import sh
from .albedo import Albedo
from .buried import Fill, FilledGather, Surroundings, find_buried, is_dark
from .errors import MeshError
from .hits import HitStore, trace
from .interreflection import interreflected
from .kept import Findings, KeptTraces
from .parallel import ALL_CORES, Progress, Workers, ignore_progress
from .pieces import Piece, PieceFolder, Shard, cut
from .raycast import SMALLEST_SKIP, RayScene
from .transport import Receivers, shadowed, unshadowed

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]

MEMORY = 2 << 30
"""Bytes of hits that stay in memory, unless a bake is told otherwise."""

_RAYS_IN_A_PIECE = 1 << 24  # at most 128 MiB of hits
_BOUNCE_IN_RAYS = 0.03  # measured: a bounce takes as long as that share of the rays whose hits it uses
_TOO_BLIND = 0.02  # skipped start of rays, as a share of their object's radius, that is worth a word

Mode = Literal["UNSHADOWED", "SHADOWED", "INTERREFLECTED"]


@dataclass(frozen=True)
class BakeSettings:
    """What a bake depends on beside the geometry.

    samples: rays per receiver.
    bounces: of light, if interreflected and tolerance is 0.
    tolerance: if above 0, bounce until no coefficient changes by as much.
    """

    mode: Mode = "SHADOWED"
    samples: int = 256
    seed: int = 0
    bounces: int = 3
    tolerance: float = 0.0


@dataclass(frozen=True)
class ReceiverGroup:
    """The receivers of one object, in world space.

    name: the object's, for messages.
    points, normals: (N, 3) float64; normals are unit length.
    radius: of the object, to scale the skipped start of rays.
    own: if the object may move, all that blocks its light, instead of the scene: its own surface. Points, normals and
        result are then in the object's own axes, and `own.corner_receiver` counts its receivers alone.
    edges: (E, 2) pairs of receivers that are neighbours on the mesh, over which those inside other geometry are
        filled; without any, none is.
    """

    name: str
    points: Float64
    normals: Float64
    radius: float
    own: Occluders | None = None
    edges: npt.NDArray[np.int32] | None = None

    def __len__(self) -> int:
        return len(self.points)


Tell = Callable[[ReceiverGroup, str], None]
"""Called with a sentence about what came out for a group, for the person."""


def tell_nobody(_group: ReceiverGroup, _sentence: str) -> None:
    """For someone who does not ask."""


@dataclass(frozen=True)
class Run:
    """How a bake is carried out: nothing that its result depends on.

    workers: who casts the rays, and who watches.
    tell: told what came out for each group.
    kept: where traces of interreflected bakes are kept; one that is found there needs no new rays.
    memory: bytes of hits that stay in memory; those beyond lie on disk, and light bounces more slowly.
    pieces: where what rays find is saved while they are cast; what is there already needs no new rays.
    bounced: told of bounces, as the number of rays that would take as long.
    """

    workers: Workers = ALL_CORES
    tell: Tell = tell_nobody
    kept: KeptTraces | None = None
    memory: int = MEMORY
    pieces: PieceFolder | None = None
    bounced: Progress = ignore_progress


PLAINLY = Run()
"""On all cores, unwatched, keeping nothing."""


@dataclass(frozen=True)
class Occluders:
    """All that blocks light, in world space.

    vertices: (V, 3) float64.
    triangles: (T, 3), front = counter-clockwise.
    corner_receiver: (T, 3) int64, which receiver, counted through all groups, stands at each corner of a triangle;
        -1 returns no light. All black if None. Only interreflection asks for it.
    albedo: of the triangles; white if None.
    """

    vertices: Float64
    triangles: npt.NDArray[np.int32]
    corner_receiver: npt.NDArray[np.int64] | None = None
    albedo: Albedo | None = None


@dataclass(frozen=True)
class Traced:
    """What the rays of a bake found; another albedo or number of bounces needs no new ones.

    sizes: receivers of each group.
    direct: (N, 9) float32 shadowed transport of all groups, filled where buried.
    hits: what the blocked rays hit, if light shall bounce.
    fill: of the receivers that lie inside other geometry.
    """

    sizes: list[int]
    direct: Float32
    hits: HitStore
    fill: Fill

    @property
    def nbytes(self) -> int:
        """Memory it occupies."""
        return self.direct.nbytes + self.hits.nbytes


def ray_count(groups: Sequence[ReceiverGroup], settings: BakeSettings) -> int:
    """Rays that `bake_all` and `bake` will report to their progress."""
    return 0 if settings.mode == "UNSHADOWED" else settings.samples * sum(map(len, groups))


def bounce_work(groups: Sequence[ReceiverGroup], settings: BakeSettings) -> int:
    """What `bake_all` and `bake` will report to `Run.bounced`, about."""
    if settings.mode != "INTERREFLECTED":
        return 0
    bounces = BakeSettings.bounces if settings.tolerance > 0.0 else settings.bounces  # nobody knows: as often as usual
    return bounces * _bounce_work(sum(map(len, groups)), settings.samples)


def _bounce_work(receivers: int, samples: int) -> int:
    return int(_BOUNCE_IN_RAYS * samples * receivers)


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
            _check_finite(members)
            for _ in _Caster(members, part.occluders, settings, part.run(run)).pieces(span):
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
        Cancelled: if the workers' progress raised it.
    """
    if settings.mode == "INTERREFLECTED":
        if run.kept:
            traced = _kept_or_traced(run.kept, groups, occluders, settings, run)
        else:
            traced = trace_groups(groups, occluders, settings, run)
        return bounce(traced, occluders, settings, run)
    _check_finite(groups)
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

        def note(group: ReceiverGroup, sentence: str) -> None:
            findings.append((numbers[id(group)], sentence))

        return trace_groups(groups, occluders, settings, replace(run, tell=note)), findings

    traced, findings, was_kept = kept.get_or_trace(groups, occluders, settings, trace_now)
    if was_kept:
        run.workers.progress(ray_count(groups, settings))
    for number, sentence in findings:
        run.tell(groups[number], sentence)
    return traced


def trace_groups(
    groups: Sequence[ReceiverGroup],
    occluders: Occluders,
    settings: BakeSettings,
    run: Run = PLAINLY,
) -> Traced:
    """The first half of a bake: all of its rays. Arguments and errors as those of `bake`; the mode must cast rays."""
    _check_finite(groups)
    caster = _Caster(groups, occluders, settings, run)
    receivers = caster.receivers
    direct = np.empty((len(receivers), sh.coefficient_count(sh.ORDER)), dtype=np.float32)
    hits = HitStore(settings.samples, run.memory)
    for piece in caster.pieces(slice(0, len(receivers))):
        direct[piece.receivers] = piece.direct
        if piece.hits:
            hits.add(piece.hits)
    around = Surroundings(caster.scene, occluders.vertices, occluders.triangles)
    fill = _fill(around, groups, receivers, direct, settings.seed, run)
    return Traced([len(group) for group in groups], direct, hits, fill)


class _Caster:
    """Casts the rays of some groups, piece by piece."""

    def __init__(self, groups: Sequence[ReceiverGroup], occluders: Occluders, settings: BakeSettings, run: Run) -> None:
        self._run = run
        self.scene = RayScene(occluders.vertices, occluders.triangles, run.workers.progress)
        self.receivers = _joined(groups, self.scene)
        self._settings = settings
        self._returns = (_corner_receiver(occluders) >= 0).any(axis=1)

    def pieces(self, span: slice) -> Iterator[Piece]:
        """Pieces that cover a span of receivers, in order; those that the run's folder holds need no rays."""
        samples, folder = self._settings.samples, self._run.pieces
        size = max(1, _RAYS_IN_A_PIECE // samples)
        if folder is None:
            yield from map(self._traced, cut(span, size))
            return
        for piece in folder.cover(span, size, self._traced):
            if piece.found:
                self._run.workers.progress(samples * len(piece.direct))
            yield piece

    def _traced(self, part: slice) -> Piece:
        settings, workers = self._settings, self._run.workers
        rays = self.scene, self.receivers[part], settings.samples, settings.seed
        if settings.mode == "SHADOWED":
            return Piece(part, shadowed(*rays, workers), None)
        return Piece(part, *trace(*rays, self._returns, workers))


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

    def watch(receivers: int) -> None:
        run.bounced(_bounce_work(receivers, settings.samples))
        run.workers.progress(0)

    workers = replace(run.workers, progress=watch)
    gather = FilledGather(traced.fill, traced.hits, albedo, _corner_receiver(occluders), workers)
    transport = interreflected(traced.direct, gather, settings.bounces, settings.tolerance)
    return _split(transport, traced.sizes)


def _check_finite(groups: Sequence[ReceiverGroup]) -> None:
    for group in groups:
        if not np.isfinite(group.points).all():
            raise MeshError(
                f"Mesh of '{group.name}' holds NaN or infinite coordinates: remove those vertices and bake again."
            )


def _corner_receiver(occluders: Occluders) -> npt.NDArray[np.int64]:
    if occluders.corner_receiver is None:
        return np.full(occluders.triangles.shape, -1, dtype=np.int64)
    return occluders.corner_receiver


def _split(transport: Float32, sizes: Sequence[int]) -> list[Float32]:
    return np.split(transport, np.cumsum(sizes)[:-1])


def _joined(groups: Sequence[ReceiverGroup], scene: RayScene) -> Receivers:
    return Receivers(
        points=scene.normalised(np.concatenate([group.points for group in groups])),
        normals=np.concatenate([group.normals for group in groups]),
        ids=np.concatenate([np.arange(len(group)) for group in groups]),
        skips=np.concatenate([np.full(len(group), scene.skip_length(group.radius)) for group in groups]),
    )


def _fill(
    around: Surroundings,
    groups: Sequence[ReceiverGroup],
    receivers: Receivers,
    direct: Float32,
    seed: int,
    run: Run,
) -> Fill:
    """Fill `direct` (N, 9) in place where receivers are buried, and tell what came out for each group."""
    starts = np.cumsum([0, *map(len, groups)])
    none = np.zeros((0, 2), dtype=np.int64)
    edges = np.concatenate(
        [none, *(group.edges + start for group, start in zip(groups, starts, strict=False) if group.edges is not None)]
    )
    fill = Fill(find_buried(around, receivers, edges, direct, seed, run.workers), edges)
    fill(direct)
    for group, start in zip(groups, starts, strict=False):
        part = slice(start, start + len(group))
        for sentence in _findings(group, around.scene, direct[part], fill.buried[part]):
            run.tell(group, sentence)
    return fill


def _findings(group: ReceiverGroup, scene: RayScene, direct: Float32, buried: npt.NDArray[np.bool_]) -> Iterator[str]:
    """What the person should know of a group's (N, 9) transport and of which (N,) were filled."""
    if not len(group):
        return
    if buried.any():
        share = f"{buried.mean():.0%}" if buried.mean() >= 0.01 else "Less than 1%"
        yield f"{share} of the receivers of '{group.name}' lie inside other geometry and were filled from their neighbours."
    if is_dark(direct).all():
        yield (
            f"No light reaches '{group.name}': unless it is a closed room, its faces point inwards "
            "(Mesh > Normals > Recalculate Outside) or it lies inside other geometry."
        )
    blind = SMALLEST_SKIP * scene.radius
    if blind > _TOO_BLIND * group.radius > 0.0:
        yield (
            f"'{group.name}' is tiny beside the scene: shadows from closer than {blind:.2g} are lost on it; move distant "
            "objects closer, or hide them from renders."
        )
