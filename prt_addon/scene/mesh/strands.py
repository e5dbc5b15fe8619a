# SPDX-License-Identifier: GPL-3.0-or-later
"""Turns hair curves and point clouds into triangles that block as much light as they do.

Strands become tubes of three sides, points polyhedra of twenty faces. By Cauchy's formula a convex body shows, in the mean
over all directions, a quarter of its area: the radii are those at which this is what the round body shows.
"""

from __future__ import annotations

from math import pi, sqrt

import bpy
import numpy as np
import numpy.typing as npt

from ...core.arrays import Float64
from .meshes import Surface

_SIDES = 3
_TUBE = 2.0 * pi / (2.0 * _SIDES * np.sin(pi / _SIDES))  # circumradius of a polygon as long around as the unit circle
_BALL = sqrt(4.0 * pi / 9.574541382)  # circumradius of an icosahedron with as much surface as the unit ball
_DEFAULT_RADIUS = 0.01  # Blender's, of points and curves without radii


def strands(ob: bpy.types.Object, matrix: Float64) -> Surface | None:
    """World-space triangles of an evaluated object of hair curves or points; None if it has none."""
    data = ob.data
    points = _floats(data, "position", "vector", 3)
    if points is None or not len(points):
        return None
    radii = _floats(data, "radius", "value", 1)
    radius = np.full(len(points), _DEFAULT_RADIUS) if radii is None else radii[:, 0]
    world = points @ matrix[:3, :3].T + matrix[:3, 3]
    radius = radius * abs(np.linalg.det(matrix[:3, :3])) ** (1.0 / 3.0)
    if ob.type == "POINTCLOUD":
        return _surface(*_balls(world, radius))
    starts = np.empty(len(data.curves), dtype=np.int32)
    data.curves.foreach_get("first_point_index", starts)
    return _surface(*_tubes(world, radius, starts.astype(np.int64)))


def _floats(data: bpy.types.ID, layer: str, key: str, width: int) -> Float64 | None:
    found = data.attributes.get(layer)
    if found is None or found.domain != "POINT" or not len(found.data):
        return None
    flat = np.empty(len(found.data) * width, dtype=np.float32)
    found.data.foreach_get(key, flat)
    return flat.reshape(-1, width).astype(np.float64)


def _tubes(points: Float64, radius: Float64, starts: npt.NDArray[np.int64]) -> tuple[Float64, npt.NDArray[np.int64]]:
    """Vertices and triangles of open tubes along polylines that start at some of the points."""
    first = np.zeros(len(points), dtype=bool)
    first[starts] = True
    head = np.flatnonzero(~first) - 1  # each segment leads from a point to the next, where that begins no other curve
    along = np.zeros_like(points)
    step = points[head + 1] - points[head]
    np.add.at(along, head, step)
    np.add.at(along, head + 1, step)
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-30)
    least = np.eye(3)[np.argmin(np.abs(along), axis=1)]
    side = np.cross(along, least)
    side /= np.maximum(np.linalg.norm(side, axis=1, keepdims=True), 1e-30)
    up = np.cross(along, side)
    angle = 2.0 * pi * np.arange(_SIDES) / _SIDES
    ring = np.cos(angle)[:, None] * side[:, None] + np.sin(angle)[:, None] * up[:, None]
    vertices = points[:, None] + (_TUBE * radius)[:, None, None] * ring
    here = head[:, None] * _SIDES + np.arange(_SIDES)
    after = head[:, None] * _SIDES + (np.arange(_SIDES) + 1) % _SIDES
    triangles = np.stack(
        [np.stack([here, after, here + _SIDES], axis=-1), np.stack([after, after + _SIDES, here + _SIDES], axis=-1)]
    )
    return vertices.reshape(-1, 3), triangles.reshape(-1, 3)


def _balls(points: Float64, radius: Float64) -> tuple[Float64, npt.NDArray[np.int64]]:
    """Vertices and triangles of icosahedra."""
    golden = (1.0 + sqrt(5.0)) / 2.0
    corners = np.array([(-1, golden, 0), (1, golden, 0), (-1, -golden, 0), (1, -golden, 0)], dtype=np.float64)
    corners = np.concatenate([corners, np.roll(corners, 1, axis=1), np.roll(corners, 2, axis=1)])
    corners /= np.linalg.norm(corners[0])
    faces = _hull(corners)
    vertices = points[:, None] + (_BALL * radius)[:, None, None] * corners
    triangles = faces + len(corners) * np.arange(len(points))[:, None, None]
    return vertices.reshape(-1, 3), triangles.reshape(-1, 3)


def _hull(corners: Float64) -> npt.NDArray[np.int64]:
    """(20, 3) the faces of an icosahedron, their fronts outwards: all triples of corners that are an edge apart."""
    distance = np.linalg.norm(corners[:, None] - corners[None], axis=-1)
    near = np.isclose(distance, distance[distance > 0.0].min())
    i, j, k = np.indices((12, 12, 12)).reshape(3, -1)
    keep = (i < j) & (j < k) & near[i, j] & near[j, k] & near[i, k]
    faces = np.stack([i, j, k], axis=-1)[keep]
    a, b, c = (corners[faces[:, n]] for n in range(3))
    inwards = np.einsum("ij,ij->i", np.cross(b - a, c - a), a) < 0.0
    faces[inwards] = faces[inwards][:, ::-1]
    return faces


def _surface(vertices: Float64, triangles: npt.NDArray[np.int64]) -> Surface:
    corners = triangles.astype(np.int32)
    return Surface(
        vertices, corners, corners, np.zeros(len(triangles), dtype=np.int32), np.zeros(len(triangles), dtype=np.bool_)
    )
