# SPDX-License-Identifier: GPL-3.0-or-later
"""Defines the tasks of the engine's process. Each takes its arguments, and last how it is carried out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from ..core.arrays import Float64
from ..core.bake import bake as core_bake
from ..core.bake import estimate as core_estimate
from ..core.bake.bake import BakeResult
from ..core.bake.cache import CasterCache
from ..core.bake.estimate import ShardEstimate
from ..core.bake.previews import previews
from ..core.bake.run import Run
from ..core.bake.shards import Shard
from ..core.monitor import Work
from ..core.problem import BakeProblem
from ..core.report.findings import Effort, Findings, find
from ..core.report.heat import receiver_errors
from ..core.report.subject import Lighting, Subject
from ..core.workers import uncounted


def bake(problem: BakeProblem, run: Run) -> BakeResult:
    """A whole bake: `core.bake.bake.bake`."""
    return core_bake.bake(problem, run)


def bake_with_previews(problem: BakeProblem, run: Run) -> BakeResult:
    """The same bits; `core.bake.previews` show what they will be about."""
    sharing = replace(run, casters=CasterCache())
    for preview in previews(problem, sharing):
        run.workers.monitor.show(preview)
    return core_bake.bake(problem, sharing)


def shard(problem: BakeProblem, share: Shard, run: Run) -> None:
    """The rays of one shard, into the folder of the run: `core.bake.bake.trace_shard`."""
    core_bake.trace_shard(problem, share, run)


def estimate(problem: BakeProblem, count: int, run: Run) -> ShardEstimate:
    """What a bake in so many shards will take: `core.bake.estimate.estimate`."""
    return core_estimate.estimate(problem, count, run)


@dataclass(frozen=True)
class Measured:
    """What a report found of one object.

    findings: at points of its surface; None if these were not wanted.
    errors: (N,) at its receivers; None if these were not wanted.
    """

    findings: Findings | None
    errors: Float64 | None


def measure(
    subjects: Sequence[Subject], light: Lighting, effort: Effort, at_points: bool, at_receivers: bool, run: Run
) -> list[Measured]:
    """Measure baked objects, at points of their surfaces, at their receivers, or at both. An object counts as one ray."""
    watching = uncounted(run.workers)  # how many rays a report takes is not known beforehand
    measured = []
    for subject in subjects:
        findings = find(subject, light, effort, watching) if at_points else None
        errors = receiver_errors(subject, light, effort.seed, watching) if at_receivers else None
        measured.append(Measured(findings, errors))
        run.workers.monitor.advance(Work(rays=1))
    return measured
