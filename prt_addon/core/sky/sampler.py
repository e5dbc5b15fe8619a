# SPDX-License-Identifier: GPL-3.0-or-later
"""Looks up the sky in full resolution, and draws directions by its brightness: what a bake in nine coefficients is
judged by.
"""

from __future__ import annotations

from copy import copy

import numpy as np
import numpy.typing as npt

from ..arrays import Float32, Float64, Int64
from ..errors import PictureError
from ..sphere.equirect import row_edges, solid_angles, texels_along

MAX_WIDTH = 2048
"""Of pictures as they are looked up: texels of 0.18 degrees, a third of the sun's disc. Wider ones are averaged down."""


class Skylight:
    """Equirectangular pictures of one sky; draws directions by the brightness of the first.

    Within a texel the radiance is constant. Renderers, and the stored light, go in straight lines from texel to texel
    instead: measured, that is 0.4 % of the light of 16 rows, and 0.03 % of 64. Directions are drawn by the inverse of
    the cumulated flux, row by row (Pharr, Jakob & Humphreys, "Physically Based Rendering", section
    "Infinite Area Lights"); within a texel they are uniform in solid angle, so that their density is the texel's
    brightness over the whole flux, exactly.
    """

    def __init__(self, pictures: Float32, turn: npt.ArrayLike) -> None:
        """
        Args:
            pictures: (P, H, W, 3) linear radiance, row 0 at the bottom; the first one decides where to look.
            turn: (3, 3) R: along w, the sky shows what the pictures hold along R w.

        Raises:
            PictureError: if a texel is NaN or infinite.
        """
        if not np.isfinite(pictures).all():
            raise PictureError("The sky holds NaN or infinite radiance: repair its picture and load it again.")
        self.count, self.height, self.width = pictures.shape[:3]
        self._texels = np.ascontiguousarray(np.moveaxis(pictures, 0, 2)).reshape(-1, self.count, 3)
        self._turn = np.asarray(turn, dtype=np.float64)
        self._edges: Float64 = row_edges(self.height)
        solid_angle = solid_angles(self.height, self.width)
        brightness = np.maximum(pictures[0].astype(np.float64).mean(axis=-1), 0.0)
        self._ends: Float64 = np.cumsum(brightness * solid_angle[:, None]).reshape(self.height, self.width)
        self.flux = float(self._ends[-1, -1])
        """Brightness (the mean of the channels) integrated over the sphere."""
        self._brightness = brightness.ravel()

    def turned(self, turn: npt.ArrayLike) -> Skylight:
        """The same sky under another turn (3, 3); shares its pictures."""
        other = copy(self)
        other._turn = np.asarray(turn, dtype=np.float64)
        return other

    def radiance(self, directions: Float64) -> Float64:
        """(N, P, 3) what each picture shows along unit vectors (N, 3)."""
        return self._texels[self._texel(directions @ self._turn.T)].astype(np.float64)

    def density(self, directions: Float64) -> Float64:
        """(N,) probability per steradian that `draw` returns unit vectors (N, 3)."""
        if not self.flux:
            return np.zeros(len(directions))
        return self._brightness[self._texel(directions @ self._turn.T)] / self.flux

    def draw(self, uniform: Float64) -> Float64:
        """Draw (N, 3) unit vectors by numbers (N, 2) in [0, 1): the first chooses the row, the second the place in it."""
        row, up = _inverted(self._ends[:, -1], uniform[:, 0] * self.flux)
        before = np.where(row > 0, self._ends[row - 1, -1], 0.0)
        brightness = before + uniform[:, 1] * (self._ends[row, -1] - before)
        texel, along = _inverted(self._ends.ravel(), brightness)
        row, column = np.divmod(texel, self.width)  # rounding may have crossed into a neighbour
        z = self._edges[row] + up * (self._edges[row + 1] - self._edges[row])
        azimuth = 2.0 * np.pi * (0.5 - (column + along) / self.width)
        ring = np.sqrt(np.maximum(0.0, 1.0 - z * z))
        return np.stack([ring * np.cos(azimuth), ring * np.sin(azimuth), z], axis=-1) @ self._turn

    def _texel(self, looked_up: Float64) -> Int64:
        """(N,) index of the texel along unit vectors in the picture's own axes."""
        row, column = texels_along(looked_up, self.height, self.width)
        return row * self.width + column


def _inverted(ends: Float64, amount: Float64) -> tuple[Int64, Float64]:
    """Where amounts (N,) fall among runs that end at `ends`: which run, and how far into it, in [0, 1]."""
    run = np.minimum(np.searchsorted(ends, amount, side="right"), len(ends) - 1)
    start = np.where(run > 0, ends[run - 1], 0.0)
    length = ends[run] - start
    return run, np.clip((amount - start) / np.where(length > 0.0, length, 1.0), 0.0, 1.0)


def reduced(picture: Float32) -> Float32:
    """Average a picture (H, W, 3) down by a whole number if it is wider than `MAX_WIDTH`."""
    height, width = picture.shape[:2]
    step = -(-width // MAX_WIDTH)
    if step == 1 or height % step or width % step:
        return picture
    return (
        picture.reshape(height // step, step, width // step, step, 3)
        .mean(axis=(1, 3), dtype=np.float64)
        .astype(np.float32)
    )
