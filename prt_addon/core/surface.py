# SPDX-License-Identifier: GPL-3.0-or-later
"""Looks up what a surface is like where a ray hits it: which share of the light it returns, and which it stops.

A triangle has one value, unless a pattern covers it: a texture, or values at its corners. The lookup is per hit and not
per triangle, because a floor of two triangles may carry a whole picture.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from .arrays import Float32, Ints
from .sphere.directions import hash_fraction

_DIRECTION_STEPS = 1 << 12
"""Of each component of a ray's direction: from a receiver that sends 2^17 rays, neighbours differ by eight."""

Interpolation = Literal["Linear", "Closest"]
Extension = Literal["REPEAT", "EXTEND", "CLIP", "MIRROR"]


@dataclass(frozen=True)
class CornerColours:
    """A colour attribute: linear between the corners of each triangle.

    Attributes:
        triangles: (P,) which of the scene's triangles it covers.
        colours: (P, 3, C) float32, that of corner k at [:, k]; linear RGB, or one number.
    """

    triangles: Ints
    colours: Float32

    def at(self, row: Ints, u: Float32, v: Float32) -> Float32:
        """(M, C) values at barycentrics u, v of corners 1 and 2 in the patch's own triangles `row` (M,)."""
        return _interpolated(self.colours[row], u, v)

    @property
    def is_grey(self) -> bool:
        """Whether the three channels are equal everywhere."""
        return _is_grey(self.colours)

    def arrays(self) -> list[npt.NDArray[Any]]:
        """All that it is made of."""
        return [self.triangles, self.colours]


@dataclass(frozen=True)
class TexturePatch:
    """A picture laid over triangles by their UV map.

    Attributes:
        triangles: (P,) which of the scene's triangles it covers.
        uv: (P, 3, 2) float32, coordinates of corner k at [:, k]; (0, 0) is the picture's lower left corner.
        image: (H, W, C) float32, linear RGB or one number, row 0 at the bottom; texel i has its centre at (i + 0.5) / W.
        interpolation: as the Image Texture node names it.
        extension: as the Image Texture node names it. What CLIP leaves out is 0.
    """

    triangles: Ints
    uv: Float32
    image: Float32
    interpolation: Interpolation = "Linear"
    extension: Extension = "REPEAT"

    def at(self, row: Ints, u: Float32, v: Float32) -> Float32:
        """(M, C) values at barycentrics u, v of corners 1 and 2 in the patch's own triangles `row` (M,)."""
        position = _interpolated(self.uv[row], u, v)
        colour = self._bilinear(position) if self.interpolation == "Linear" else self._closest(position)
        if self.extension == "CLIP":
            colour[((position < 0.0) | (position > 1.0)).any(axis=1)] = 0.0
        return colour

    @property
    def is_grey(self) -> bool:
        """Whether the three channels are equal everywhere."""
        return _is_grey(self.image)

    def arrays(self) -> list[npt.NDArray[Any]]:
        """All that it is made of."""
        ways = np.frombuffer(f"{self.interpolation} {self.extension}".encode(), dtype=np.uint8)
        return [self.triangles, self.uv, self.image, ways]

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


Pattern = CornerColours | TexturePatch


@dataclass(frozen=True)
class Patterned:
    """Values in [0, 1] on a scene's triangles.

    Attributes:
        constant: (T, C), one value of C channels per triangle.
        patterns: what covers some triangles instead; where two overlap the later one shows.
    """

    constant: npt.NDArray[np.floating[Any]]
    patterns: tuple[Pattern, ...] = ()

    def at(self, triangle: Ints, u: Float32, v: Float32) -> Float32:
        """Values where rays hit.

        Args:
            triangle: (M,) triangle indices.
            u: (M,) barycentrics of the triangles' corners 1.
            v: (M,) those of their corners 2.

        Returns:
            (M, C) float32 in [0, 1]; NaN counts as 0.
        """
        values = self.constants[triangle]
        cover = self._cover[triangle]
        for number, pattern in enumerate(self.patterns):
            here = np.flatnonzero(cover == number)
            if len(here):
                values[here] = _clipped(pattern.at(self._row[triangle[here]], u[here], v[here]))
        return values

    @cached_property
    def constants(self) -> Float32:
        """(T, C) float32 in [0, 1]."""
        return _clipped(np.asarray(self.constant, dtype=np.float32))

    @cached_property
    def is_patterned(self) -> npt.NDArray[np.bool_]:
        """(T,) whether the value varies over the triangle."""
        return self._cover >= 0

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


@dataclass(frozen=True)
class Albedo(Patterned):
    """The diffuse albedo of a scene's triangles: RGB, linear light."""

    @cached_property
    def is_grey(self) -> bool:
        """Whether all three channels are equal everywhere, so that one of them says it all."""
        return _is_grey(self.constants) and all(pattern.is_grey for pattern in self.patterns)

    def of_both_sides(self) -> Albedo:
        """The same on 2 T sides: all fronts, then all backs."""
        backs = [replace(one, triangles=one.triangles + len(self.constant)) for one in self.patterns]
        return Albedo(np.concatenate([self.constant, self.constant]), (*self.patterns, *backs))


@dataclass(frozen=True)
class Opacity(Patterned):
    """Which share of the light a scene's triangles stop, one channel: cut-outs, panes and veils let the rest through.

    A ray passes whole or not at all, as drawn for it: the mean over many rays is the share.
    """

    @cached_property
    def is_open(self) -> npt.NDArray[np.bool_]:
        """(T,) whether a triangle lets any light through."""
        return self.is_patterned | (self.constants[:, 0] < 1.0)

    def lets_through(self, triangle: Ints, u: Float32, v: Float32, directions: Float32) -> npt.NDArray[np.bool_]:
        """(M,) which rays pass the triangles that they hit.

        The draw is made of the triangle and of the ray's direction, in steps that its rounding seldom changes: it depends
        on no other ray, and two panes behind each other draw anew.

        Args:
            triangle: (M,) triangle indices.
            u: (M,) barycentrics of the triangles' corners 1.
            v: (M,) those of their corners 2.
            directions: (M, 3) unit vectors.
        """
        steps = np.rint(directions * np.float32(_DIRECTION_STEPS)).astype(np.int64) + _DIRECTION_STEPS
        x, y, z = steps.astype(np.uint64).T
        code = triangle.astype(np.uint64) << np.uint64(42) | x << np.uint64(28) | y << np.uint64(14) | z
        return self.at(triangle, u, v)[:, 0] <= hash_fraction(code)

    def arrays(self) -> list[npt.NDArray[Any]]:
        """All that it is made of."""
        return [self.constant, *(array for pattern in self.patterns for array in pattern.arrays())]


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
