# SPDX-License-Identifier: GPL-3.0-or-later
"""How a bake is carried out, which its result does not depend on."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from .inputs import ReceiverGroup
from .kept import KeptTraces
from .parallel import ALL_CORES, Progress, Workers, ignore_progress
from .pieces import PieceFolder

MEMORY = 2 << 30
"""Bytes of hits that stay in memory, unless a bake is told otherwise."""

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
