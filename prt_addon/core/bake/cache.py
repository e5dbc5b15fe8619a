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
"""Bytes of traces that are kept: about a million receivers at 256 samples."""


class KeptTraces:
    """The latest traces that fit in a budget."""

    def __init__(self, budget: int = BUDGET) -> None:
        self._budget = budget
        self._kept: OrderedDict[TraceKey, Traced] = OrderedDict()

    def __len__(self) -> int:
        return len(self._kept)

    def find(self, key: TraceKey) -> Traced | None:
        """Find the trace of a key, which becomes the latest; None if it is not kept."""
        found = self._kept.pop(key, None)
        if found:
            self._kept[key] = found
        return found

    def keep(self, key: TraceKey, traced: Traced) -> None:
        """Keep one more trace, and drop the oldest ones if there is no room for it."""
        self._kept[key] = traced
        while self._kept and sum(kept.nbytes for kept in self._kept.values()) > self._budget:
            self._kept.popitem(last=False)

    def clear(self) -> None:
        """Drop all traces."""
        self._kept.clear()


class KeptScenes:
    """Keeps ray casters for as long as their occluders live: a preview and its bake share them."""

    def __init__(self) -> None:
        self._kept: dict[int, RayScene] = {}

    def of(self, occluders: Occluders, monitor: Monitor) -> RayScene:
        """The ray caster of some occluders, made at the first call. Errors as those of `RayScene`."""
        if id(occluders) not in self._kept:
            self._kept[id(occluders)] = RayScene.of(occluders, monitor)
        return self._kept[id(occluders)]
