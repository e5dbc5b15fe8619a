# SPDX-License-Identifier: GPL-3.0-or-later
"""Casts the rays of a bake, piece by piece, and mends what receivers inside other geometry get."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..arrays import Float32
from ..errors import MeshError
from ..monitor import Work
from ..notices import Notice
from ..problem import BakeSettings, Island, ReceiverGroup
from ..sphere import sh
from ..transport.cover import Faces, Fit, Samples, sample_covered
from ..transport.direct import Receivers, shadowed
from ..transport.hits import HitStore, PackedHits, trace
from ..transport.inside import Fill, Mend, Surroundings, find_buried, is_dark
from ..transport.raycast import RayScene
from ..workers import uncounted
from .findings import Findings
from .run import DEFAULT_RUN, Run
from .shards import Piece, cut

RAYS_IN_A_PIECE = 1 << 24
"""At most 128 MiB of hits."""


@dataclass(frozen=True)
class Traced:
    """What the rays of an island found; another albedo or number of bounces needs no new ones.

    Attributes:
        sizes: receivers of each group.
        direct: (N + M, 9) float32 shadowed transport of all groups, mended where they lie inside other geometry; then that of
            samples in the open parts of faces with covered corners.
        hits: what the blocked rays of both hit, if light shall bounce.
        mend: what is done about receivers inside other geometry.
        mended: (N,) which these are.
        findings: what there is to say of the groups, each with the number of its group.
    """

    sizes: list[int]
    direct: Float32
    hits: HitStore
    mend: Mend
    mended: npt.NDArray[np.bool_]
    findings: list[tuple[int, Notice]]

    @property
    def nbytes(self) -> int:
        """Memory it occupies."""
        return self.direct.nbytes + self.hits.nbytes


def trace_island(island: Island, settings: BakeSettings, run: Run = DEFAULT_RUN) -> Traced:
    """Cast all rays of an island: the first half of its bake. Errors as those of `bake`; the mode must cast rays."""
    check_finite(island.groups)
    caster = Caster(island, settings, run)
    receivers, occluders = caster.receivers, island.occluders
    direct = np.empty((len(receivers), sh.coefficient_count(sh.ORDER)), dtype=np.float32)
    hits = HitStore(settings.samples, run.memory)
    for piece in caster.pieces(slice(0, len(receivers))):
        direct[piece.receivers] = piece.direct
        if piece.hits:
            hits.add(piece.hits)
    surroundings = Surroundings(caster.scene, occluders.vertices, occluders.triangles)
    edges, dark = _edges(island.groups), is_dark(direct)
    buried = find_buried(surroundings, receivers, edges, direct, settings.seed, run.workers)
    samples = sample_covered(caster.scene, receivers, _faces(island.groups), edges, dark, settings.seed, run.workers)
    direct = np.concatenate([direct, *_sampled(caster, samples, hits)])
    mend = Mend(Fit(samples, len(receivers)), Fill(buried & ~samples.covered, edges))
    mend(direct)
    mended = buried | samples.covered
    findings = list(Findings(island, caster.receivers, surroundings, settings.seed, run.workers).of(direct, mended))
    return Traced([len(group) for group in island.groups], direct, hits, mend, mended, findings)


def _sampled(caster: Caster, samples: Samples, hits: HitStore) -> Iterator[Float32]:
    """The direct transport of samples, (n, 9) each; what their rays hit follows that of the receivers."""
    for part in cut(slice(0, len(samples)), max(1, RAYS_IN_A_PIECE // hits.samples)):
        found = caster.cast(samples.receivers[part], counted=False)
        if found.hits:
            hits.add(found.hits)
        yield found.direct


class Found(NamedTuple):
    """What rays found: (n, 9) transport without bounces, and what light may bounce off, in a bake with bounces."""

    direct: Float32
    hits: PackedHits | None


class Caster:
    """Casts the rays of an island, piece by piece."""

    def __init__(self, island: Island, settings: BakeSettings, run: Run) -> None:
        self._run, occluders = run, island.occluders
        self.scene = (run.casters.of if run.casters else RayScene.of)(occluders, run.workers.monitor)
        self.receivers = Receivers.of(island.groups, self.scene)
        self._settings = settings
        self._returns = (occluders.receiver_at_corners >= 0).any(axis=1)

    def pieces(self, span: slice) -> Iterator[Piece]:
        """Yield the pieces that cover a span of receivers, in order; those that the run's folder holds need no rays."""
        samples, folder = self._settings.samples, self._run.pieces
        size = max(1, RAYS_IN_A_PIECE // samples)
        if folder is None:
            yield from map(self._traced, cut(span, size))
            return
        for piece in folder.cover(span, size, self._traced, 3 * len(self._returns)):
            if piece.found:
                self._run.workers.monitor.advance(Work(rays=samples * len(piece.direct)))
            yield piece

    def cast(self, receivers: Receivers, counted: bool = True) -> Found:
        """Cast the rays of some receivers; uncounted, no monitor sees how many."""
        settings, workers = self._settings, self._run.workers if counted else uncounted(self._run.workers)
        rays = self.scene, receivers, settings.samples, settings.seed
        if not settings.bounces_light:
            return Found(shadowed(*rays, workers), None)
        return Found(*trace(*rays, self._returns, workers))

    def _traced(self, part: slice) -> Piece:
        found = self.cast(self.receivers[part])
        return Piece(part, found.direct, found.hits)


def check_finite(groups: Sequence[ReceiverGroup]) -> None:
    """Raises MeshError for the first group with coordinates that are not finite."""
    for group in groups:
        if not np.isfinite(group.points).all():
            raise MeshError(
                f"Mesh of '{group.name}' holds NaN or infinite coordinates: remove those vertices and bake again."
            )


def _edges(groups: Sequence[ReceiverGroup]) -> npt.NDArray[np.int64]:
    """(E, 2) pairs of neighbours, counted through all groups."""
    starts = np.cumsum([0, *map(len, groups)])
    none = np.zeros((0, 2), dtype=np.int64)
    return np.concatenate(
        [none, *(group.edges + start for group, start in zip(groups, starts, strict=False) if group.edges is not None)]
    )


def _faces(groups: Sequence[ReceiverGroup]) -> Faces:
    """Of all groups, their receivers counted through."""
    starts = np.cumsum([0, *map(len, groups)])
    corners = [np.zeros((0, 3), dtype=np.int64)]
    corners += [
        group.faces.astype(np.int64) + start
        for group, start in zip(groups, starts, strict=False)
        if group.faces is not None
    ]
    return Faces(np.concatenate(corners), np.concatenate([np.arange(len(some)) for some in corners]))
