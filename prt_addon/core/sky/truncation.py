# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures what a light loses in nine coefficients, from the light alone: the yardstick of how many lamps a sky needs."""

from __future__ import annotations

from functools import lru_cache
from math import pi

import numpy as np

from ..arrays import Float64
from ..sphere import sh
from ..sphere.equirect import directions_at
from .projection import project_equirect


def truncation(left: Float64, whole: Float64 | None = None) -> float:
    """What a light loses beyond order 2 where half of the sky is hidden, as a share of all that arrives there; RMS.

    The yardstick is a surface at the foot of a wall, turned in all ways: there a sharp light casts a sharp shadow, while in the
    open nothing of it would be lost.

    Args:
        left: ((order + 1)**2, 3) the light that is shown in bands.
        whole: the light that arrives; without it, the same.
    """
    lost = _arriving(left)[sh.ORDER + 1 :].sum()
    everything = _arriving(left if whole is None else whole).sum()
    return float(np.sqrt(lost / everything)) if everything > 0.0 else 0.0


def _arriving(light: Float64) -> Float64:
    """(order + 1,) mean square of what each band of a light sends to the foot of a wall."""
    order = sh.order_of(len(light))
    squares = (light**2).mean(axis=-1)
    return np.array([squares[sh.band_slice(band)].sum() * share for band, share in enumerate(_wall(order))])


@lru_cache
def _wall(order: int) -> tuple[float, ...]:
    """(order + 1,) mean square, over all turns, of the transport at the foot of a wall, per coefficient of each band."""
    height = 64
    x, _, z = np.moveaxis(directions_at(np.arange(height)[:, None] + 0.5, np.arange(2 * height) + 0.5, height), -1, 0)
    seen = np.where(x > 0.0, np.maximum(z, 0.0), 0.0) / pi
    transport = project_equirect(np.repeat(seen[..., None], 3, axis=-1), order)[:, 0]
    return tuple(float((transport[sh.band_slice(band)] ** 2).sum() / (2 * band + 1)) for band in range(order + 1))
