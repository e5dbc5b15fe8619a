# SPDX-License-Identifier: GPL-3.0-or-later
"""What the engine's process can be asked to do. Each task takes its arguments, and last how it is carried out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from ..core.bake import bake_all, trace_shard
from ..core.inputs import BakeSettings, Occluders, ReceiverGroup
from ..core.pieces import Shard
from ..core.report.findings import Effort, Findings, find
from ..core.report.heat import receiver_errors
from ..core.report.subject import Light, Subject
from ..core.run import Run

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Baked:
    """What a bake came to.

    transport: of each group, (N, 9) or (N, 9, 3).
    findings: sentences for the person, each with the number of the group that it is about.
    """

    transport: list[Float32]
    findings: list[tuple[int, str]]


def bake(groups: Sequence[ReceiverGroup], occluders: Occluders, settings: BakeSettings, run: Run) -> Baked:
    """Bake all groups: `core.bake.bake_all`."""
    numbers = {id(group): number for number, group in enumerate(groups)}
    findings: list[tuple[int, str]] = []
    run = replace(run, tell=lambda group, sentence: findings.append((numbers[id(group)], sentence)))
    return Baked(bake_all(groups, occluders, settings, run), findings)


def shard(
    groups: Sequence[ReceiverGroup], occluders: Occluders, settings: BakeSettings, share: Shard, run: Run
) -> None:
    """Cast the rays of one shard into the folder of the run: `core.bake.trace_shard`."""
    trace_shard(groups, occluders, settings, share, run)


@dataclass(frozen=True)
class Measured:
    """What a report found of one object.

    findings: at points of its surface; None if these were not asked for.
    errors: (N,) at its receivers; None if these were not asked for.
    """

    findings: Findings | None
    errors: Float64 | None


def measure(
    subjects: Sequence[Subject], light: Light, effort: Effort, at_points: bool, at_receivers: bool, run: Run
) -> list[Measured]:
    """Measure baked objects, at points of their surfaces, at their receivers, or at both. An object counts as one ray."""
    watching = replace(run.workers, progress=lambda _rays: run.workers.progress(0))
    measured = []
    for subject in subjects:
        findings = find(subject, light, effort, watching) if at_points else None
        errors = receiver_errors(subject, light, effort.seed, watching) if at_receivers else None
        measured.append(Measured(findings, errors))
        run.workers.progress(1)
    return measured
