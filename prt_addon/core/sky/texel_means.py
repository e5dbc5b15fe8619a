# SPDX-License-Identifier: GPL-3.0-or-later
"""Averages a function on the sphere over each texel of a picture, with more samples where the function is rough.

A sun covers five millionths of the sphere. Texels that differ from their neighbours are cut into 64, of these those that
still differ again, until what may be missed is small against the whole (adaptive cubature with one point per cell).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from ..arrays import Float32, Float64
from ..sphere.equirect import directions_at, solid_angles

Index = npt.NDArray[np.intp]
Radiance = Callable[[Float32], Float32]
"""(N, 3) unit directions to (N, 3) linear radiance."""

_CUTS = 8  # a texel is cut into so many rows and columns
_DEPTH = 3  # so many times over: of texels of a third of a degree, that leaves a thousandth of one
_AT_ONCE = 1 << 14  # texels that are cut per level at most
_MISSED = 0.3  # of the step between two neighbours: the error of one point, on average over where the step lies
_PLASTIC = 1.324717957244746  # of the R2 sequence (Roberts 2018), which spreads points within cells


def equirect_means(radiance: Radiance, height: int = 512, tolerance: float = 1e-4) -> Float32:
    """Average a sky over each texel of an equirectangular picture.

    What is smaller than a texel (`180 / height` degrees) is found if the centre of a texel sees it.

    Args:
        radiance: what is seen along directions; called a few times, for many at once, neighbours next to each other.
        height: rows; there are twice as many columns. A picture as large is hit in the centres of its texels.
        tolerance: of the integral over the sphere, relative, as estimated from differences between neighbours.

    Returns:
        (height, 2 height, 3) means over texels, row 0 at the bottom, Blender's equirectangular directions.
    """
    rows, columns = (index.ravel() for index in np.indices((height, 2 * height)))
    means = radiance(directions_at(rows + 0.5, columns + 0.5, height).astype(np.float32))
    allowed = tolerance * float(np.abs(means).max(axis=1) @ _areas(rows, height))
    _refine(radiance, rows, columns, means, height, allowed, _DEPTH)
    return means.reshape(height, 2 * height, 3)


def _refine(
    radiance: Radiance, rows: Index, columns: Index, means: Float32, height: int, allowed: float, depth: int
) -> None:
    """Replace the means (N, 3) of rough texels, of the grid of `height` rows, by those over their parts."""
    rough = _worth_cutting(_steps(rows, columns, means, height) * _areas(rows, height), allowed)
    if not depth or not len(rough):
        return
    height, parts = height * _CUTS, np.arange(_CUTS)
    shape = (len(rough), _CUTS, _CUTS)
    rows = np.broadcast_to((rows[rough, None] * _CUTS + parts)[:, :, None], shape).ravel()
    columns = np.broadcast_to((columns[rough, None] * _CUTS + parts)[:, None, :], shape).ravel()
    spread = np.arange(len(rows)) + 1.0  # no regular grid, which an edge along it would fool
    places = rows + spread / _PLASTIC % 1.0, columns + spread / _PLASTIC**2 % 1.0
    cut = radiance(directions_at(*places, height).astype(np.float32))
    _refine(radiance, rows, columns, cut, height, allowed, depth - 1)
    weights = _areas(rows, height).reshape(len(rough), -1, 1)
    means[rough] = (cut.reshape(len(rough), -1, 3) * weights).sum(axis=1) / weights.sum(axis=1)


def _steps(rows: Index, columns: Index, means: Float32, height: int) -> Float32:
    """(N,) largest difference of each texel from those of its eight neighbours that are among them."""
    width = 2 * height
    keys = rows * width + columns
    order = np.argsort(keys, kind="stable")
    steps = np.zeros(len(keys), dtype=np.float32)
    for up, right in ((0, 1), (1, -1), (1, 0), (1, 1)):
        wanted = (rows + up) * width + (columns + right) % width
        found = order[np.minimum(np.searchsorted(keys, wanted, sorter=order), len(keys) - 1)]
        here = np.flatnonzero(keys[found] == wanted)
        there = found[here]
        step = np.abs(means[here] - means[there]).max(axis=1)
        steps[here] = np.maximum(steps[here], step)
        steps[there] = np.maximum(steps[there], step)
    return steps


def _worth_cutting(errors: Float64, allowed: float) -> Index:
    """The fewest texels, ascending, without which the others' errors add up (in squares) to what is allowed."""
    squares = (_MISSED * errors) ** 2
    order = np.argsort(squares, kind="stable")
    fine = int(np.searchsorted(np.cumsum(squares[order]), allowed**2, side="right"))
    return np.sort(order[max(fine, len(order) - _AT_ONCE) :])


def _areas(rows: Index, height: int) -> Float64:
    """Solid angle of a texel in each of some rows, exactly."""
    return solid_angles(height, 2 * height)[rows]
