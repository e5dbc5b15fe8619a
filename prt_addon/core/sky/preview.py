# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws an SH light as an equirectangular picture, beside the sky that it was projected from. Row 0 is at the bottom."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ..arrays import Float64
from ..sphere import sh
from ..sphere.equirect import solid_angles, texel_directions, texels_along

Picture = npt.NDArray[np.float32]

_ROWS_AT_A_TIME = 64


def light_picture(light: Float64, height: int) -> Picture:
    """The radiance that a light shows along each direction: what the projection kept.

    Args:
        light: ((order + 1)**2, 3).
        height: rows.

    Returns:
        (height, 2 * height, 3) float32; negative where a light of few bands rings.
    """
    return (sh.basis(texel_directions(height), sh.order_of(len(light))) @ light).astype(np.float32)


def turned_picture(picture: Picture, turn: Float64, height: int) -> Picture:
    """Turn a picture as a turned world shows it: along w, it holds what it held along R w.

    Args:
        picture: (H, W, 3) radiance.
        turn: (3, 3) the rotation R.
        height: rows of the result; what is finer is averaged.

    Returns:
        (height, 2 * height, 3) float32.
    """
    fine = _box_averaged(picture, 2 * height, 4 * height)
    rows, columns = fine.shape[:2]
    found = fine[texels_along(texel_directions(2 * height) @ turn.T, rows, columns)]
    return _box_averaged(found, height, 2 * height)


def energy(picture: Picture | Float64) -> float:
    """The integral of the square over the sphere and all channels, as `windowing.energy_shares` wants it for a total.

    Args:
        picture: (height, width, 3) radiance.
    """
    height, width = picture.shape[:2]
    areas = solid_angles(height, width)
    total = 0.0
    for first in range(0, height, _ROWS_AT_A_TIME):
        rows = slice(first, first + _ROWS_AT_A_TIME)
        squares = picture[rows].astype(np.float64) ** 2
        total += float(areas[rows] @ squares.sum(axis=(1, 2)))
    return total


def display(picture: Picture) -> Picture:
    """(height, width, 4) values for a screen: sRGB-encoded, opaque, with the brightest texel at 1 and nothing below 0."""
    brightest = max(float(picture.max()), 1e-30)
    linear = np.clip(picture / np.float32(brightest), 0.0, 1.0)
    encoded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1.0 / 2.4) - 0.055)
    return np.concatenate([encoded, np.ones_like(encoded[..., :1])], axis=-1).astype(np.float32)


def _box_averaged(picture: Picture, rows: int, columns: int) -> Picture:
    """Means of blocks, as (rows, columns, 3); a picture that is coarser along an axis stays so."""
    for axis, wanted in ((0, rows), (1, columns)):
        size = picture.shape[axis]
        if size > wanted:
            starts = np.arange(wanted) * size // wanted
            counts = np.diff([*starts, size]).astype(np.float32)
            picture = np.add.reduceat(picture, starts, axis=axis) / (
                counts[:, None, None] if axis == 0 else counts[:, None]
            )
    return picture
