# SPDX-License-Identifier: GPL-3.0-or-later
"""Looks up what share of the light a surface returns where a ray hits it.

A triangle's albedo is one colour, unless a pattern covers it: a texture, or colours at its corners. The lookup is
per hit and not per triangle, because a floor of two triangles may carry a whole picture.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

Float32 = npt.NDArray[np.float32]
Ints = npt.NDArray[np.integer[Any]]

Interpolation = Literal["Linear", "Closest"]
Extension = Literal["REPEAT", "EXTEND", "CLIP", "MIRROR"]


@dataclass(frozen=True)
class CornerColours:
    """A colour attribute: linear between the corners of each triangle.

    Attributes:
        triangles: (P,) which of the scene's triangles it covers.
        colours: (P, 3, 3) float32, linear RGB of corner k at [:, k].
    """

    triangles: Ints
    colours: Float32

    def at(self, row: Ints, u: Float32, v: Float32) -> Float32:
        """(M, 3) RGB at barycentrics u, v of corners 1 and 2 in the patch's own triangles `row` (M,)."""
        return _interpolated(self.colours[row], u, v)

    @property
    def is_grey(self) -> bool:
        """Whether the three channels are equal everywhere."""
        return _is_grey(self.colours)


@dataclass(frozen=True)
class TexturePatch:
    """A picture laid over triangles by their UV map.

    Attributes:
        triangles: (P,) which of the scene's triangles it covers.
        uv: (P, 3, 2) float32, coordinates of corner k at [:, k]; (0, 0) is the picture's lower left corner.
        image: (H, W, 3) float32, linear light, row 0 at the bottom; texel i has its centre at (i + 0.5) / W.
        interpolation: as the Image Texture node names it.
        extension: as the Image Texture node names it. What CLIP leaves out is black.
    """

    triangles: Ints
    uv: Float32
    image: Float32
    interpolation: Interpolation = "Linear"
    extension: Extension = "REPEAT"

    def at(self, row: Ints, u: Float32, v: Float32) -> Float32:
        """(M, 3) RGB at barycentrics u, v of corners 1 and 2 in the patch's own triangles `row` (M,)."""
        position = _interpolated(self.uv[row], u, v)
        colour = self._bilinear(position) if self.interpolation == "Linear" else self._closest(position)
        if self.extension == "CLIP":
            colour[((position < 0.0) | (position > 1.0)).any(axis=1)] = 0.0
        return colour

    @property
    def is_grey(self) -> bool:
        """Whether the three channels are equal everywhere."""
        return _is_grey(self.image)

    def _closest(self, position: Float32) -> Float32:
        x, y = np.floor(position * self._size).astype(np.int64).T
        return self._texel(x, y)

    def _bilinear(self, position: Float32) -> Float32:
        texel = position * self._size - np.float32(0.5)
        low = np.floor(texel)
        right, up = (texel - low).T[:, :, None]
        x, y = low.astype(np.int64).T
        bottom = (1 - right) * self._texel(x, y) + right * self._texel(x + 1, y)
        top = (1 - right) * self._texel(x, y + 1) + right * self._texel(x + 1, y + 1)
        colour: Float32 = (1 - up) * bottom + up * top
        return colour

    def _texel(self, x: Ints, y: Ints) -> Float32:
        height, width = self.image.shape[:2]
        texels: Float32 = self.image[self._inside(y, height), self._inside(x, width)]
        return texels

    def _inside(self, index: Ints, count: int) -> Ints:
        """Texel indices of one axis, brought back into 0..count-1."""
        if self.extension == "REPEAT":
            return index % count
        if self.extension == "MIRROR":
            index = index % (2 * count)
            return np.minimum(index, 2 * count - 1 - index)
        return np.minimum(np.maximum(index, 0), count - 1)

    @property
    def _size(self) -> Float32:
        height, width = self.image.shape[:2]
        return np.array([width, height], dtype=np.float32)


AlbedoPattern = CornerColours | TexturePatch


@dataclass(frozen=True)
class Albedo:
    """The diffuse albedo of a scene's triangles, RGB, linear light.

    Attributes:
        constant: (T, 3), one colour per triangle.
        patterns: what covers some triangles instead; where two overlap the later one shows.
    """

    constant: npt.NDArray[np.floating[Any]]
    patterns: tuple[AlbedoPattern, ...] = ()

    def at(self, triangle: Ints, u: Float32, v: Float32) -> Float32:
        """Colours where rays hit.

        Args:
            triangle: (M,) triangle indices.
            u: (M,) barycentrics of the triangles' corners 1.
            v: (M,) those of their corners 2.

        Returns:
            (M, 3) float32 in [0, 1]; NaN counts as black.
        """
        colour = self.colours[triangle]
        cover = self._cover[triangle]
        for number, pattern in enumerate(self.patterns):
            here = np.flatnonzero(cover == number)
            if len(here):
                colour[here] = _clipped(pattern.at(self._row[triangle[here]], u[here], v[here]))
        return colour

    @cached_property
    def colours(self) -> Float32:
        """(T, 3) float32 constant colours in [0, 1]."""
        return _clipped(np.asarray(self.constant, dtype=np.float32))

    @cached_property
    def is_patterned(self) -> npt.NDArray[np.bool_]:
        """(T,) whether the colour varies over the triangle."""
        return self._cover >= 0

    @cached_property
    def is_grey(self) -> bool:
        """Whether all three channels are equal everywhere, so that one of them says it all."""
        return _is_grey(self.colours) and all(pattern.is_grey for pattern in self.patterns)

    @cached_property
    def _cover(self) -> npt.NDArray[np.int32]:
        """(T,) which pattern covers a triangle, or -1."""
        cover = np.full(len(self.constant), -1, dtype=np.int32)
        for number, pattern in enumerate(self.patterns):
            cover[pattern.triangles] = number
        return cover

    @cached_property
    def _row(self) -> npt.NDArray[np.int64]:
        """(T,) where the triangle stands in the pattern that covers it."""
        row = np.zeros(len(self.constant), dtype=np.int64)
        for pattern in self.patterns:
            row[pattern.triangles] = np.arange(len(pattern.triangles))
        return row


def _interpolated(corners: Float32, u: Float32, v: Float32) -> Float32:
    """(M, C) values at barycentrics u, v from corner values (M, 3, C)."""
    first, second, third = np.moveaxis(corners, 1, 0)
    values: Float32 = first + u[:, None] * (second - first) + v[:, None] * (third - first)
    return values


def _clipped(colour: Float32) -> Float32:
    clipped: Float32 = np.fmin(np.fmax(colour, np.float32(0.0)), np.float32(1.0))
    return clipped


def _is_grey(colour: Float32) -> bool:
    return bool((colour[..., :1] == colour[..., 1:]).all())
