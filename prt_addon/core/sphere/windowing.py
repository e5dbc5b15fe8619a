# SPDX-License-Identifier: GPL-3.0-or-later
"""Windows an SH light against ringing: how much of each band to keep, and how little to give up so that no light is
negative.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from ..arrays import Float64
from . import sh
from .directions import fibonacci_sphere

Window = Literal["NONE", "HANN", "LANCZOS"]

_DIRECTIONS = 4096  # for shares of the sphere: to about a thousandth
_CUTOFFS = 256
_ZOOMS = 4  # into one of so many intervals, four times over: the cutoff is right to 2e-10
_HALVINGS = 60  # of an interval, down to float64's last bits


def band_factors(window: Window, cutoff: float | None = None, order: int = sh.ORDER) -> Float64:
    """What a window leaves of each band; Sloan 2008, "Stupid Spherical Harmonics Tricks", section "Windowing".

    Hann is `(1 + cos(pi l / cutoff)) / 2`, Lanczos `sin(pi l / cutoff) / (pi l / cutoff)`; both are zero from the
    cutoff on.

    Args:
        window: which one; NONE keeps everything.
        cutoff: the first band that is gone, need not be whole, at least 1; order + 1 without it.
        order: highest band.

    Returns:
        (order + 1,) float64 in [0, 1], 1 for band 0.

    Raises:
        ValueError: for a cutoff below 1; at 1 band 0 alone is left already.
    """
    cutoff = order + 1.0 if cutoff is None else cutoff
    if not cutoff >= 1.0:
        raise ValueError(f"a window's cutoff is at least 1, not {cutoff}")
    if window == "NONE":
        return np.ones(order + 1)
    share = np.minimum(np.arange(order + 1) / cutoff, 1.0)
    return (1.0 + np.cos(np.pi * share)) / 2.0 if window == "HANN" else np.sinc(share)


def windowed(light: Float64, factors: Float64) -> Float64:
    """The light ((order + 1)**2, 3) with each band scaled by its factor (order + 1,)."""
    return light * sh.per_coefficient(factors)[:, None]


@dataclass(frozen=True)
class Deringed:
    """A light that is nowhere negative, and what the window took to make it so."""

    light: Float64
    """(9, 3), windowed."""
    factors: Float64
    """(3,), what is left of each band."""
    cutoff: float
    """Of the window; infinite if none was needed."""
    negative_before: float
    """Share of the sphere on which any channel was negative, in [0, 1]."""
    negative_after: float


def dering(light: Float64, window: Window = "HANN") -> Deringed:
    """Find the mildest window, one cutoff for all channels, that keeps the reconstructed light non-negative everywhere.

    The light's minimum need not fall steadily with the cutoff: all cutoffs are looked through, the widest first,
    and the first that will do is then narrowed down. The minimum is exact, not that of some directions.

    Args:
        light: (9, 3).
        window: HANN or LANCZOS.

    Returns:
        The windowed light; unchanged if it had no negative part. Of a sky whose mean is negative only band 0 is left.
    """
    bad, good = 0.0, 1.0  # inverse cutoffs: no window, and band 0 alone
    for _ in range(_ZOOMS):
        steps = np.linspace(bad, good, _CUTOFFS + 1)
        first = int(np.argmax([*_nowhere_negative(light, window, steps[:-1]), True]))
        bad, good = float(steps[max(first - 1, 0)]), float(steps[first])
    cutoff = 1.0 / good if good else np.inf
    factors = band_factors(window, cutoff)
    kept = windowed(light, factors)
    return Deringed(kept, factors, cutoff, negative_share(light), negative_share(kept))


def _nowhere_negative(light: Float64, window: Window, inverse_cutoffs: Float64) -> npt.NDArray[np.bool_]:
    """For each of some windows, whether the light is non-negative, but for rounding, in all channels."""
    cutoffs = [1.0 / inverse if inverse else np.inf for inverse in inverse_cutoffs]
    lights = np.concatenate([windowed(light, band_factors(window, cutoff)) for cutoff in cutoffs], axis=1)
    least = minimum(lights).reshape(len(cutoffs), -1)
    return (least >= -1e-12 * np.abs(light[0])).all(axis=1)


def minimum(light: Float64) -> Float64:
    """Find the least value of an order-2 light over the whole sphere, per channel.

    `c + b.w + w^T Q w` on the unit sphere is the trust-region problem; its dual has no gap (More & Sorensen 1983,
    "Computing a trust region step"): the largest, over t below the least eigenvalue q_0 of Q, of
    `c + t - sum b_i**2 / (4 (q_i - t))`, b taken along the eigenvectors. That is concave, and any t bounds the light
    from below, so that halving towards its top errs to the safe side.

    Args:
        light: (9, channels).

    Returns:
        (channels,) float64, radiance.
    """
    values, vectors = np.linalg.eigh(sh.band2_form(light[4:9].T))
    linear = np.sqrt(3.0 / (4.0 * np.pi)) * light[[3, 1, 2]].T
    squares = np.einsum("cij,ci->cj", vectors, linear) ** 2 / 4.0
    gaps = values - values[:, :1]
    # t is q_0 less a distance: the distance alone keeps its bits where band 1 is next to nothing beside q_0
    near, far = np.zeros((len(values), 1)), np.sqrt(squares.sum(axis=1, keepdims=True))
    for _ in range(_HALVINGS):
        middle = (near + far) / 2.0
        with np.errstate(divide="ignore", invalid="ignore"):
            slope = np.nansum(squares / (gaps + middle) ** 2, axis=1, keepdims=True)  # 0 / 0 stands for 0
        near, far = np.where(slope <= 1.0, near, middle), np.where(slope <= 1.0, middle, far)
    with np.errstate(divide="ignore", invalid="ignore"):
        penalty = np.nansum(squares / (gaps + far), axis=1)
    return light[0] * np.sqrt(1.0 / (4.0 * np.pi)) + values[:, 0] - far[:, 0] - penalty


def negative_share(light: Float64) -> float:
    """Share of the sphere, in [0, 1], on which any channel of the light ((order + 1)**2, 3) is negative."""
    values = sh.basis(fibonacci_sphere(_DIRECTIONS), sh.order_of(len(light))) @ light
    return float(np.mean((values < 0.0).any(axis=1)))


def energy_shares(light: Float64, total: float | None = None) -> Float64:
    """Which share of the energy, the integral of the square over the sphere and all channels, lies in each band.

    Args:
        light: ((order + 1)**2, 3).
        total: energy of the picture, of which the projection kept a share; the light's own without it (Parseval).

    Returns:
        (order + 1,) float64; all zero for a black light.
    """
    squares = np.sum(light**2, axis=1)
    bands = np.array([squares[sh.band_slice(band)].sum() for band in range(sh.order_of(len(light)) + 1)])
    whole = float(bands.sum()) if total is None else total
    return bands / whole if whole else bands
