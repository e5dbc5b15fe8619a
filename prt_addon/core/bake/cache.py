# SPDX-License-Identifier: GPL-3.0-or-later
"""Keeps traces for a session, so that other colours or bounces need no new rays, and ray casters for as long as a bake."""

from __future__ import annotations

from collections import OrderedDict
from typing import TYPE_CHECKING

from ..problem import Occluders, TraceKey
from ..transport.raycast import RayScene

if TYPE_CHECKING:
    from ..monitor import Monitor
    from .trace import Traced

BUDGET = 1 << 30
"""Bytes of traces: about a million receivers at 256 samples."""


class TraceCache:
    """The latest traces that fit in a budget."""

    def __init__(self, budget: int = BUDGET) -> None:
        self._budget = budget
        self._traces: OrderedDict[TraceKey, Traced] = OrderedDict()

    def __len__(self) -> int:
        return len(self._traces)

    def find(self, key: TraceKey) -> Traced | None:
        """Find the trace of a key, which becomes the latest; None if there is none."""
        found = self._traces.pop(key, None)
        if found:
            self._traces[key] = found
        return found

    def add(self, key: TraceKey, traced: Traced) -> None:
        """Add a trace, and drop the oldest ones if there is no room for it."""
        self._traces[key] = traced
        while self._traces and sum(one.nbytes for one in self._traces.values()) > self._budget:
            self._traces.popitem(last=False)

    def clear(self) -> None:
        """Drop all traces."""
        self._traces.clear()


class CasterCache:
    """Keeps ray casters for as long as their occluders live: a preview and its bake share them."""

    def __init__(self) -> None:
        self._casters: dict[int, RayScene] = {}

    def of(self, occluders: Occluders, monitor: Monitor) -> RayScene:
        """The ray caster of some occluders, made at the first call. Errors as those of `RayScene`."""
        if id(occluders) not in self._casters:
            self._casters[id(occluders)] = RayScene.of(occluders, monitor)
        return self._casters[id(occluders)]
