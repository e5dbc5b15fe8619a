# SPDX-License-Identifier: GPL-3.0-or-later
"""Holds what a bake is carried out with, and its result does not depend on: threads, memory, caches, a folder of
pieces.
"""

from __future__ import annotations

from dataclasses import dataclass

from ..workers import ALL_CORES, Workers
from .cache import CasterCache, TraceCache
from .shards import PieceFolder

MEMORY = 2 << 30
"""Bytes of hits that stay in memory, unless a bake sets another number."""


@dataclass(frozen=True)
class Run:
    """What a bake is carried out with; its result depends on none of it.

    Attributes:
        workers: who casts the rays, and who watches.
        traces: of earlier interreflected bakes; one that is found there needs no new rays.
        casters: of the occluders, if there will be several passes over the same occluders.
        memory: bytes of hits that stay in memory; those beyond lie on disk, and light bounces more slowly.
        pieces: where what rays find is saved while they are cast; what is there already needs no new rays.
    """

    workers: Workers = ALL_CORES
    traces: TraceCache | None = None
    casters: CasterCache | None = None
    memory: int = MEMORY
    pieces: PieceFolder | None = None


DEFAULT_RUN = Run()
"""On all cores, unwatched, keeping nothing."""
