# SPDX-License-Identifier: GPL-3.0-or-later
"""Pools the points of several objects, as if these were one surface."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from ..arrays import Float64
from .findings import Findings
from .measures import product

Squares = Callable[[Findings], Float64]
"""Estimates of the squared error at the points of a finding: (n,) at all, or (m,) at those that were baked afresh."""


def pooled(found: Sequence[Findings], squares: Squares) -> tuple[Float64, Float64, Float64]:
    """Squared errors, squared truths and weights at the points of all objects, as `measures` takes them."""
    columns: list[tuple[Float64, Float64, Float64]] = []
    for one in found:
        errors, truth = squares(one), product(*one.truth)
        if len(errors) == len(truth):
            weights = one.weights
        else:
            truth, weights = truth[one.fresh], np.full(len(errors), one.area / max(len(errors), 1))
        columns.append((errors, truth, weights))
    if not columns:
        return np.empty(0), np.empty(0), np.empty(0)
    errors, truth, weights = (np.concatenate(column) for column in zip(*columns, strict=True))
    return errors, truth, weights
