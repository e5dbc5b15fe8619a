# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures the part of the error that more bands take away: nine coefficients hold only the broad shape of a light.

The sky in full resolution is traced directly, bounces included, and the same rays are weighed with the band-limited
sky: the difference is the truncation's alone, with no noise of a bake and no error between vertices in it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import nan

import numpy as np

from ..arrays import Float64
from .findings import Findings
from .measures import Estimate, product, reference_interval, relative_rms
from .pool import pooled
from .subject import ORDERS


@dataclass(frozen=True)
class Truncation:
    """What the stored order loses of this light on this mesh, as a share of the true radiance's RMS.

    Attributes:
        relative_rms: with the light as it is stored on the world, its window included.
        by_order: what orders 1 to 6 lose of the plain sky.
        without_lamps: what order 2 loses of the sky without what lamps take, still as a share of all light; None if there are none.
        reference_interval: half the 95 % interval of the truth at a point, that is, of the yardstick itself; the largest
            of the objects.
    """

    relative_rms: Estimate
    by_order: dict[int, Estimate]
    without_lamps: Estimate | None
    reference_interval: float


def truncation(found: Sequence[Findings]) -> Truncation:
    """Measure the truncation on the surface of some objects."""
    without_lamps = None
    if any(one.without_lamps is not None for one in found):
        without_lamps = relative_rms(*pooled(found, _lost_without_lamps))
    return Truncation(
        relative_rms(*pooled(found, lambda one: product(*(one.truncated - one.truth)))),
        {
            order: relative_rms(*pooled(found, lambda one, k=k: product(*(one.orders[:, k] - one.truth))))  # type: ignore[misc]
            for k, order in enumerate(ORDERS)
        },
        without_lamps,
        max((reference_interval(one.truth, one.weights) for one in found), default=nan),
    )


def _lost_without_lamps(one: Findings) -> Float64:
    return np.zeros(len(one.weights)) if one.without_lamps is None else product(*one.without_lamps)
