# SPDX-License-Identifier: GPL-3.0-or-later
"""Defines what "error" means, once for every part of a report.

The error is in radiance: what a white surface shows under the world as it is turned now, in linear light. It is
measured at random points of the surface, every square metre counting alike, and related to the root mean square of
the true radiance on the same surface: `sqrt(mean |a - b|^2 / mean |b|^2)`, the means over points and channels.

Where a or b is itself estimated by rays, their noise would be counted as error. So both are estimated twice, with
independent rays, and `|a - b|^2` is replaced by `(a_1 - b_1)(a_2 - b_2)`, whose mean is free of noise.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite, nan, sqrt

import numpy as np

from ..arrays import Float64

CONVERGED = 0.02
"""Half the 95 % interval of a truth that is good enough to judge by, as a share of its RMS."""

TWO_SIDED_95 = 1.96
"""Standard errors to either side."""


@dataclass(frozen=True)
class Estimate:
    """A number and its 95 % confidence interval; NaN where there is nothing to measure."""

    value: float
    low: float
    high: float

    @property
    def is_known(self) -> bool:
        """Whether there was anything to measure."""
        return isfinite(self.value)


UNKNOWN = Estimate(nan, nan, nan)


def percent(share: float) -> str:
    """Write a share in words, with two digits that mean something."""
    if not isfinite(share):
        return "unknown"
    return f"{100.0 * share:.0f}%" if share >= 0.0995 else f"{100.0 * share:.1f}%"


def product(one: Float64, other: Float64) -> Float64:
    """(n,) mean over the channels of two independent estimates (n, 3) of one thing: an estimate of its square."""
    mean: Float64 = (one * other).mean(axis=-1)
    return mean


def ratio_of_means(values: Float64, truth: Float64, weights: Float64) -> Estimate:
    """`sum w v / sum w t`, and its interval by linearisation (Cochran 1977, "Sampling Techniques", equation 6.13).

    Args:
        values: (n,) at each point.
        truth: (n,) at each point.
        weights: (n,) the area that each point stands for.
    """
    whole = float(weights @ truth)
    if not len(weights) or not whole > 0.0:
        return UNKNOWN
    ratio = float(weights @ values) / whole
    residual = weights * (values - ratio * truth)
    margin = TWO_SIDED_95 * float(np.sqrt(residual @ residual)) / whole
    return Estimate(ratio, ratio - margin, ratio + margin)


def relative_rms(squares: Float64, truth: Float64, weights: Float64) -> Estimate:
    """`sqrt(sum w s / sum w t)` and its interval.

    Args:
        squares: (n,) unbiased estimates of the squared error at each point.
        truth: (n,) those of the squared truth.
        weights: (n,) the area that each point stands for.
    """
    squared = ratio_of_means(squares, truth, weights)
    if not squared.is_known:
        return UNKNOWN
    return Estimate(*(sqrt(max(end, 0.0)) for end in (squared.value, squared.low, squared.high)))


def percentile(values: Float64, weights: Float64, share: float) -> Estimate:
    """Find the value that a share of the surface stays below; the interval is that of order statistics.

    Args:
        values: (n,) at each point.
        weights: (n,) the area that each point stands for.
        share: in (0, 1).
    """
    if not weights.sum() > 0.0:
        return UNKNOWN
    order = np.argsort(values)
    below = np.cumsum(weights[order]) - weights[order] / 2.0
    effective = weights.sum() ** 2 / (weights @ weights)
    margin = TWO_SIDED_95 * np.sqrt(share * (1.0 - share) / effective)
    shares = np.clip((share, share - margin, share + margin), 0.0, 1.0)
    value, low, high = np.interp(shares * weights.sum(), below, values[order])
    return Estimate(float(value), float(low), float(high))


def reference_interval(truth: Float64, weights: Float64) -> float:
    """Half the 95 % interval of the mean of both estimates (2, n, 3) of the truth at a point, relative to its RMS."""
    variance = ((truth[0] - truth[1]) ** 2).mean(axis=-1) / 4.0
    return TWO_SIDED_95 * relative_rms(variance, product(*truth), weights).value
