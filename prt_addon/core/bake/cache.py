# SPDX-License-Identifier: GPL-3.0-or-later
"""Traces kept within a session, so that another colour or number of bounces needs no new rays."""

from __future__ import annotations

from collections import OrderedDict
from typing import TYPE_CHECKING

from ..problem import TraceKey

if TYPE_CHECKING:
    from .trace import Traced

BUDGET = 1 << 30
"""Bytes of traces that are kept: about a million receivers at 256 samples."""


class KeptTraces:
    """The latest traces that fit in a budget."""

    def __init__(self, budget: int = BUDGET) -> None:
        self._budget = budget
        self._kept: OrderedDict[TraceKey, Traced] = OrderedDict()

    def find(self, key: TraceKey) -> Traced | None:
        """The trace of that key, if it is kept; it is now the latest."""
        found = self._kept.pop(key, None)
        if found:
            self._kept[key] = found
        return found

    def keep(self, key: TraceKey, traced: Traced) -> None:
        """Keep one more, and forget the oldest if there is no room for it."""
        self._kept[key] = traced
        while self._kept and sum(kept.nbytes for kept in self._kept.values()) > self._budget:
            self._kept.popitem(last=False)

    def clear(self) -> None:
        """Forget everything."""
        self._kept.clear()
