# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures the part of the error that more samples take away: the noise of a bake's own rays.

Seen on the surface, between vertices, where the shader averages the noise of three receivers: at the vertices themselves
it is about 1.4 times as large.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import Float64
from .findings import Findings
from .measures import UNKNOWN, Estimate, percentile, relative_rms
from .pool import pooled


@dataclass(frozen=True)
class Sampling:
    """The standard error of what is shown, as a share of the true radiance's RMS.

    Attributes:
        relative_rms: of it.
        percentile_95: what 95 % of the surface stay below.
    """

    relative_rms: Estimate
    percentile_95: Estimate


def squared_noise(found: Findings) -> Float64:
    """(m,) estimates of the variance: half the squared difference of two replicates, mean of the channels."""
    difference = found.between[0] - found.between[1]
    return np.asarray((difference**2).mean(axis=-1) / 2.0, dtype=np.float64)


def sampling(found: Sequence[Findings]) -> Sampling:
    """Measure the noise on the surface of some objects."""
    squares, truth, weights = pooled(found, squared_noise)
    rms = relative_rms(squares, truth, weights)
    if not rms.is_known:
        return Sampling(rms, UNKNOWN)
    whole = np.sqrt((weights @ truth) / weights.sum())
    return Sampling(rms, percentile(np.sqrt(squares) / whole, weights, 0.95))
