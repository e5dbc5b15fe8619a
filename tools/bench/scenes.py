# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes what the benchmark bakes: meshes of any size, made in code, that shadow themselves and each other."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from prt_addon.core.problem import Occluders, ReceiverGroup
from prt_addon.core.surface import Albedo

Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]

_RED, _GREEN, _WHITE = (0.7, 0.1, 0.08), (0.1, 0.5, 0.12), (0.75, 0.72, 0.65)


@dataclass(frozen=True)
class Mesh:
    """Vertices (V, 3), triangles (T, 3) counter-clockwise from the front, and one colour."""

    name: str
    vertices: Float64
    triangles: Int32
    colour: tuple[float, float, float]

    @property
    def normals(self) -> Float64:
        """(V, 3) unit, weighed by area."""
        a, b, c = (self.vertices[corner] for corner in self.triangles.T)
        normal = np.cross(b - a, c - a)
        corners = self.triangles.T.ravel()
        sums = np.stack([np.bincount(corners, np.tile(column, 3), len(self.vertices)) for column in normal.T], axis=1)
        return sums / np.linalg.norm(sums, axis=1, keepdims=True)

    @property
    def radius(self) -> float:
        """Half the diagonal of its box."""
        return float(np.linalg.norm(np.ptp(self.vertices, axis=0))) / 2.0


def court(receivers: int) -> list[Mesh]:
    """A dented ball, half of the receivers, on a wavy floor between four walls under an open sky."""
    return [
        _ball(receivers // 2),
        _floor(receivers // 4),
        *(_wall(receivers // 16, quarter) for quarter in range(4)),
    ]


def bake_input(meshes: list[Mesh], mended: bool = False) -> tuple[list[ReceiverGroup], Occluders]:
    """What `core.bake` takes: every vertex a receiver.

    Args:
        meshes: that `court` makes.
        mended: whether receivers know their neighbours, so that what is sunk into the ground is mended.
    """
    groups = [
        ReceiverGroup(
            mesh.name,
            mesh.vertices,
            mesh.normals,
            mesh.radius,
            _edges(mesh.triangles) if mended else None,
            mesh.triangles if mended else None,
        )
        for mesh in meshes
    ]
    starts = np.cumsum([0, *map(len, groups)])
    triangles = np.concatenate([mesh.triangles + start for mesh, start in zip(meshes, starts, strict=False)])
    colours = np.repeat([mesh.colour for mesh in meshes], [len(mesh.triangles) for mesh in meshes], axis=0)
    vertices = np.concatenate([mesh.vertices for mesh in meshes])
    return groups, Occluders(vertices, triangles.astype(np.int32), triangles.astype(np.int64), Albedo(colours))


def _edges(triangles: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """(E, 2) each edge once."""
    pairs = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    return np.unique(pairs, axis=0).astype(np.int32)


def _ball(count: int) -> Mesh:
    """A sphere of squares on two sides, closed at the poles by fans; its dents shadow a third of their sky."""
    rings = max(4, round(np.sqrt(count / 2.0)))
    around = max(8, count // rings)
    polar, azimuth = np.pi * (np.arange(rings) + 0.5) / rings, 2.0 * np.pi * np.arange(around) / around
    p, a = (angle.ravel() for angle in np.meshgrid(polar, azimuth, indexing="ij"))
    directions = np.stack([np.sin(p) * np.cos(a), np.sin(p) * np.sin(a), np.cos(p)], axis=1)
    directions = np.concatenate([directions, [(0.0, 0.0, 1.0), (0.0, 0.0, -1.0)]])
    x, y, z = directions.T
    height = 1.0 + 0.35 * np.sin(8.0 * x + 1.0) * np.sin(7.0 * y) + 0.2 * np.sin(9.0 * z)
    index = np.arange(rings * around).reshape(rings, around)
    after = np.roll(index, -1, axis=1)
    north, south = np.full(around, rings * around), np.full(around, rings * around + 1)
    fans = [np.stack([north, index[0], after[0]], axis=1), np.stack([south, after[-1], index[-1]], axis=1)]
    triangles = np.concatenate([_quads(index[:-1], index[1:], after[1:], after[:-1]), *fans])
    return Mesh("Ball", directions * height[:, None] * 0.6 + (0.0, 0.0, 0.9), triangles.astype(np.int32), _WHITE)


def _floor(count: int) -> Mesh:
    x, y, triangles = _sheet(count)
    z = 0.06 * np.sin(9.0 * x) * np.sin(8.0 * y)
    return Mesh("Floor", np.stack([2.0 * x, 2.0 * y, z], axis=1), triangles, _WHITE)


def _wall(count: int, quarter: int) -> Mesh:
    """One of four, turned about Z by quarters; its front looks at the middle."""
    x, y, triangles = _sheet(count)
    depth = 2.0 + 0.05 * np.sin(14.0 * x) - 0.1
    wall = np.stack([2.0 * x, depth, y + 0.9], axis=1)
    for _ in range(quarter):
        wall = wall[:, [1, 0, 2]] * (-1.0, 1.0, 1.0)
    return Mesh(f"Wall {quarter}", wall, triangles, (_RED, _WHITE, _GREEN, _WHITE)[quarter])


def _sheet(count: int) -> tuple[Float64, Float64, Int32]:
    """A square of about so many vertices: x and y in -1..1, and triangles that face +Z (or -Y, if y is up)."""
    side = max(2, round(np.sqrt(count)))
    line = np.linspace(-1.0, 1.0, side)
    x, y = (axis.ravel() for axis in np.meshgrid(line, line, indexing="ij"))
    index = np.arange(side * side).reshape(side, side)
    return x, y, _quads(index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:])


def _quads(*corners: npt.NDArray[np.int64]) -> Int32:
    a, b, c, d = (corner.ravel() for corner in corners)
    return np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)]).astype(np.int32)
