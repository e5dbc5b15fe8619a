# SPDX-License-Identifier: GPL-3.0-or-later
"""Traces kept within a session, so that another colour or number of bounces needs no new rays."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from .digest import digest
from .inputs import BakeSettings, Occluders, ReceiverGroup

if TYPE_CHECKING:
    from .casting import Traced

Findings = list[tuple[int, str]]
"""Sentences, each with the number of the group it is about."""

BUDGET = 1 << 30
"""Bytes of traces that are kept: about a million receivers at 256 samples."""


class KeptTraces:
    """The latest traces that fit in a budget, found again by all that their rays depended on."""

    def __init__(self, budget: int = BUDGET) -> None:
        self._budget = budget
        self._kept: OrderedDict[bytes, tuple[Traced, Findings]] = OrderedDict()

    def get_or_trace(
        self,
        groups: Sequence[ReceiverGroup],
        occluders: Occluders,
        settings: BakeSettings,
        trace: Callable[[], tuple[Traced, Findings]],
    ) -> tuple[Traced, Findings, bool]:
        """The trace of this question, and whether it was kept; if not, `trace` makes it."""
        key = _key(groups, occluders, settings)
        found = self._kept.pop(key, None)
        traced, findings = found or trace()
        self._kept[key] = traced, findings
        while self._kept and sum(kept.nbytes for kept, _ in self._kept.values()) > self._budget:
            self._kept.popitem(last=False)
        return traced, findings, found is not None

    def clear(self) -> None:
        """Forget everything."""
        self._kept.clear()


def _key(groups: Sequence[ReceiverGroup], occluders: Occluders, settings: BakeSettings) -> bytes:
    """A digest of what rays depend on: all but the colours and the number of bounces."""
    numbers = settings.samples, settings.seed, [(group.name, group.radius) for group in groups]
    parts: list[npt.NDArray[Any] | None] = [occluders.vertices, occluders.triangles, occluders.corner_receiver]
    for group in groups:
        parts += [group.points, group.normals, group.edges]
    arrays: list[npt.NDArray[Any]] = [np.empty(0) if part is None else part for part in parts]
    return digest(repr(numbers).encode(), *arrays)
