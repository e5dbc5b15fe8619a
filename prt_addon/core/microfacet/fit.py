# SPDX-License-Identifier: GPL-3.0-or-later
"""Approximates the albedo of rough mirrors by polynomials, for shaders, which have no tables.

Fitted to `albedo.by_quadrature` by least squares, reweighted until the largest error was smallest.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from ..arrays import Float64

ALBEDO = (
    (0.4271, 2.3523, -3.2493, 1.6875, -0.2503),
    (3.8956, -10.3638, -0.0074, 13.3625, -9.5624),
    (-9.7772, -2.0423, 97.445, -148.7017, 68.4042),
    (10.0647, 29.6114, -187.0197, 231.5928, -91.2707),
    (-3.6184, -19.1587, 88.4193, -84.8412, 22.7443),
)
"""Of `x**i roughness**j`, by i and j, with `x = mu / (mu + roughness**2)`: E within 0.5 % of itself, mu from .02 on."""

AVERAGE = (0.9999, -0.018, 0.3542, -2.2392, 1.315)
"""Of `roughness**j`: E_avg within .003."""


def albedo(mu: npt.ArrayLike, roughness: npt.ArrayLike) -> Float64:
    """E of cosines in (0, 1] and a roughness in [0, 1]; shapes broadcast."""
    mu, roughness = np.broadcast_arrays(np.asarray(mu, dtype=np.float64), np.asarray(roughness, dtype=np.float64))
    return _polynomial(mu / (mu + roughness**2), [_polynomial(roughness, row) for row in ALBEDO])


def average(roughness: npt.ArrayLike) -> Float64:
    """E_avg of a roughness in [0, 1]."""
    return _polynomial(np.asarray(roughness, dtype=np.float64), AVERAGE)


def _polynomial(x: Float64, coefficients: Sequence[float | Float64]) -> Float64:
    """`c0 + c1 x + c2 x**2 ...`, by Horner's rule."""
    value = np.zeros_like(x)
    for coefficient in reversed(coefficients):
        value = value * x + coefficient
    return value
