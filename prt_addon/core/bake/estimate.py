# SPDX-License-Identifier: GPL-3.0-or-later
"""Estimates what a bake in shards takes on this machine: counts the work, and times a few of its rays."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from ..problem import BakeProblem, Island
from ..sphere import sh
from .run import Run
from .shards import Shard
from .trace import RAYS_IN_A_PIECE, Caster, check_finite

PROBE = 1 << 20
"""Rays that the speed is measured with."""

_LEAST_RECEIVERS = 64
_ENGINE = 64 << 20  # bytes of the process before it has read anything: measured
_PER_RECEIVER = 250  # bytes beside its triangles: measured on a million
_PER_TRIANGLE = 130  # bytes with the ray caster's: measured on two million
_BOUNCED = 400  # bytes per receiver while light bounces: its transport and what is gathered
_DIRECT = 4 * sh.coefficient_count(sh.ORDER)
_HIT = 8


@dataclass(frozen=True)
class ShardEstimate:
    """What a bake in shards takes, on the machine that this was measured on.

    Attributes:
        receivers: of the largest shard.
        rays: of the largest shard.
        preparing: seconds before its first ray.
        casting: seconds for its rays.
        memory: bytes of the engine's process, beside Blender's own.
        disk: bytes of all shards together.
        merging: seconds to read the shards and to bounce the light.
        merging_memory: bytes of the engine's process meanwhile.
    """

    receivers: int
    rays: int
    preparing: float
    casting: float
    memory: int
    disk: int
    merging: float
    merging_memory: int


def estimate(problem: BakeProblem, count: int, run: Run) -> ShardEstimate:
    """Estimate a bake in so many shards; its mode must cast rays.

    The speed is that of receivers which lie evenly in the island that has most of them.

    Raises:
        ShardError: if there can be no such shards.
        Others as `bake.bake`.
    """
    spans = [Shard(index, count).span(problem.receivers) for index in (0, count - 1)]
    receivers = max(span.stop - span.start for span in spans)
    samples, bounces = problem.settings.samples, problem.settings.bounces_light
    preparing, per_ray, hits = _measured(max(problem.islands, key=len), problem, run)
    triangles = sum(len(island.occluders.triangles) for island in problem.islands)
    resident = _ENGINE + _PER_RECEIVER * problem.receivers + _PER_TRIANGLE * triangles
    all_hits = round(_HIT * hits * samples * problem.receivers)
    return ShardEstimate(
        receivers,
        samples * receivers,
        preparing,
        per_ray * samples * receivers,
        resident + round(_HIT * hits * min(samples * receivers, RAYS_IN_A_PIECE)),
        (_DIRECT + (_HIT if bounces else 0)) * problem.receivers + all_hits,
        preparing + per_ray * problem.work.bounces,
        resident + _BOUNCED * problem.receivers + min(all_hits, run.memory),
    )


def _measured(island: Island, problem: BakeProblem, run: Run) -> tuple[float, float, float]:
    """Seconds to prepare an island, seconds per ray, and hits per ray that light may bounce off."""
    check_finite(island.groups)
    begun = time.monotonic()
    caster = Caster(island, problem.settings, run)
    prepared = time.monotonic()
    samples = problem.settings.samples
    some = min(len(island), max(_LEAST_RECEIVERS, PROBE // samples))
    piece = caster.cast(caster.receivers[np.linspace(0, len(island) - 1, some).astype(np.int64)])
    cast = samples * some
    return (
        prepared - begun,
        (time.monotonic() - prepared) / cast,
        len(piece.hits.packed) / cast if piece.hits else 0.0,
    )
