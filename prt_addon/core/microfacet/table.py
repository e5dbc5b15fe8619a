# SPDX-License-Identifier: GPL-3.0-or-later
"""Tabulates the albedo of rough mirrors by angle and roughness, and its average over angles, for quick reading."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
import numpy.typing as npt

from ..arrays import Float64
from .albedo import DirectionalAlbedo, by_quadrature

SIZE = 33

_NEARLY_ZERO = 1e-3  # stands for 0, of which there is a limit, but no value


@dataclass(frozen=True)
class EnergyTable:
    """Albedos at even steps from 0 to 1.

    Attributes:
        steps: (N,) for mu as well as for roughness.
        albedo: of shape (N, N), roughness along rows, mu along columns.
        average: (N,) E_avg at each roughness.
    """

    steps: Float64
    albedo: DirectionalAlbedo
    average: Float64

    def at(self, mu: npt.ArrayLike, roughness: npt.ArrayLike) -> DirectionalAlbedo:
        """Interpolate E linearly in both arguments, both in [0, 1]; shapes broadcast."""
        return DirectionalAlbedo(
            *(self._read(values, roughness, mu) for values in (self.albedo.scale, self.albedo.bias))
        )

    def average_at(self, roughness: float | Float64) -> Float64:
        """Interpolate E_avg linearly."""
        return np.interp(roughness, self.steps, self.average)

    def _read(self, values: Float64, row: npt.ArrayLike, column: npt.ArrayLike) -> Float64:
        (top, down), (left, across) = self._cell(row), self._cell(column)
        above = values[top, left] * (1.0 - across) + values[top, left + 1] * across
        below = values[top + 1, left] * (1.0 - across) + values[top + 1, left + 1] * across
        return above * (1.0 - down) + below * down

    def _cell(self, value: npt.ArrayLike) -> tuple[npt.NDArray[np.int64], Float64]:
        """The step before a value, and how far on the value is to the next."""
        last = len(self.steps) - 1
        place = np.clip(np.asarray(value, dtype=np.float64), 0.0, 1.0) * last
        first = np.minimum(place.astype(np.int64), last - 1)
        return first, place - first


@cache
def energy_table(size: int = SIZE) -> EnergyTable:
    """Make the table of so many steps per axis, two at least; of 33, in about a second.

    Right to 2e-4 at the steps, and to 0.01 between them, where E falls steeply: towards grazing angles.
    """
    steps = np.linspace(0.0, 1.0, size)
    values = np.maximum(steps, _NEARLY_ZERO)
    return EnergyTable(steps, by_quadrature(values, values[:, None]), average_albedo(values))


def average_albedo(roughness: npt.ArrayLike) -> Float64:
    """E_avg, the integral of `2 mu E(mu)` over mu: what rough mirrors return of light from everywhere."""
    nodes, weights = np.polynomial.legendre.leggauss(24)  # type: ignore[no-untyped-call]
    mu = (nodes + 1.0) / 2.0
    albedo = by_quadrature(mu, np.asarray(roughness, dtype=np.float64)[..., None]).white
    return (albedo * mu) @ weights
