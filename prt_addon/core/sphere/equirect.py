# SPDX-License-Identifier: GPL-3.0-or-later
"""Relates texels of equirectangular pictures, as Blender lays them round the world, to directions and solid angles.

Places are counted in texels from the lower left corner, row 0 at the bottom; the middle column looks along +x. The
picture's u is `0.5 - atan2(y, x) / 2 pi`, its v `0.5 + asin(z) / pi`.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ..arrays import Float64

Numbers = npt.NDArray[np.number[Any]]


def directions_at(rows: Numbers, columns: Numbers, height: int) -> Float64:
    """(..., 3) unit vectors towards places in a picture of `height` rows and twice as many columns.

    Args:
        rows: need not be whole.
        columns: the same, of a shape that broadcasts with it.
        height: of the picture, in rows.
    """
    azimuth = np.pi * (1.0 - columns / height)
    elevation = np.pi * (rows / height - 0.5)
    ring = np.cos(elevation)
    parts = ring * np.cos(azimuth), ring * np.sin(azimuth), np.sin(elevation)
    return np.stack(np.broadcast_arrays(*parts), axis=-1)


def texel_directions(height: int, rows: slice = slice(None)) -> Float64:
    """(rows, 2 * height, 3) unit vectors towards the middles of texels."""
    return directions_at(np.arange(height)[rows, None] + 0.5, np.arange(2 * height) + 0.5, height)


def texels_along(directions: Float64, height: int, width: int) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Row and column (...) of the texels that unit vectors (..., 3) point at, in a picture of any proportions."""
    x, y, z = np.moveaxis(directions, -1, 0)
    row = np.floor((0.5 + np.arcsin(np.clip(z, -1.0, 1.0)) / np.pi) * height).astype(np.int64)
    column = np.floor((0.5 - np.arctan2(y, x) / (2.0 * np.pi)) * width).astype(np.int64)
    return np.clip(row, 0, height - 1), column % width


def row_edges(height: int) -> Float64:
    """(height + 1,) z of the rows' edges, -1 to 1."""
    return np.sin(np.pi * (np.arange(height + 1) / height - 0.5))


def solid_angles(height: int, width: int) -> Float64:
    """(height,) solid angle of a texel in each row, exactly; all texels add up to 4 pi."""
    return np.diff(row_edges(height)) * (2.0 * np.pi / width)
