# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws random points of a surface, every square metre with the same chance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Float64, Int64


@dataclass(frozen=True)
class SurfacePoints:
    """n points of one object's surface.

    Attributes:
        positions: (n, 3) in the axes of its receivers.
        normals: (n, 3) the unit shading normals, in the same axes.
        corners: (n, 3) the object's receivers at the corners of the triangle that each lies in.
        shares: (n, 3) barycentric coordinates.
    """

    positions: Float64
    normals: Float64
    corners: Int64
    shares: Float64

    def __len__(self) -> int:
        return len(self.positions)

    def between(self, values: Float64) -> Float64:
        """(n, ...) what the shader makes of values (n, 3, ...) at the corners."""
        return np.einsum("nk,nk...->n...", self.shares, values)


def areas(corners: Float64) -> Float64:
    """(T,) the areas of triangles (T, 3, 3)."""
    a, b, c = np.moveaxis(corners, 1, 0)
    area: Float64 = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2.0
    return area


def scatter(corners: Float64, receivers: Int64, normals: Float64, count: int, seed: int) -> SurfacePoints:
    """Draw points, stratified by area: so many equal parts of the surface, a point in each.

    Args:
        corners: (T, 3, 3) of the surface's triangles.
        receivers: (T, 3) the receivers at these corners.
        normals: (N, 3) of the receivers.
        count: how many points; none on a surface without area.
        seed: another draw.
    """
    rng = np.random.default_rng(seed)
    ends = np.cumsum(areas(corners))
    if not len(ends) or not ends[-1] > 0.0:
        count = 0
    where = (np.arange(count) + rng.random(count)) / max(count, 1) * (ends[-1] if count else 0.0)
    triangle = np.minimum(np.searchsorted(ends, where, side="right"), max(len(ends) - 1, 0))
    root, other = np.sqrt(rng.random(count)), rng.random(count)  # uniform in a triangle (Turk 1990, "Graphics Gems")
    shares = np.stack([1.0 - root, root * (1.0 - other), root * other], axis=-1)
    found = receivers[triangle]
    normal = np.einsum("nk,nkc->nc", shares, normals[found])
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    normal = np.where(length > 0.0, normal / np.where(length > 0.0, length, 1.0), normals[found[:, 0]])
    return SurfacePoints(np.einsum("nk,nkc->nc", shares, corners[triangle]), normal, found, shares)
