# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures the part of the error that a finer mesh takes away: light is interpolated between vertices.

Interpolated transport is compared with transport baked at the point itself, at random points of the faces and not at
their centres alone: only so is it the error of the surface that is seen, which adds up with the other parts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ..arrays import Float64
from .findings import Findings
from .measures import Estimate, product, relative_rms
from .pool import pooled


@dataclass(frozen=True)
class Tessellation:
    """What interpolation loses, as a share of the true radiance's RMS.

    Attributes:
        relative_rms: of it.
        shares: of the squared error, by object; they sum to one, or are all zero where there is no error.
    """

    relative_rms: Estimate
    shares: dict[str, float]


def squared_bend(found: Findings) -> Float64:
    """(m,) estimates of the squared error of interpolation, free of noise."""
    return product(*(found.between - found.at_points))


def tessellation(found: Sequence[Findings]) -> Tessellation:
    """Measure the error between the vertices of some objects."""
    sums = {}
    for one in found:
        squares, _, weights = pooled([one], squared_bend)
        sums[one.name] = max(float(weights @ squares), 0.0)
    whole = sum(sums.values())
    shares = {name: amount / whole if whole else 0.0 for name, amount in sums.items()}
    return Tessellation(relative_rms(*pooled(found, squared_bend)), shares)
