# SPDX-License-Identifier: GPL-3.0-or-later
"""Wraps embreex in one safe class, the only place that deals with its traps.

It owns what the ray caster wants and does not check: float32, contiguous arrays of equal length (a mismatch
crashes the interpreter), coordinates near the origin.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import numpy.typing as npt

from ..arrays import Float32, Float64
from ..errors import MeshError, RayCasterMissing
from ..monitor import UNWATCHED, Monitor
from ..problem import Occluders
from ..surface import Opacity

try:
    from embreex.mesh_construction import TriangleMesh
    from embreex.rtcore_scene import EmbreeScene
except ImportError:
    TriangleMesh = EmbreeScene = None


SKIP = 1e-4
"""Length a ray skips at its start, as a share of the radius of the object it starts from.

The length is along the ray, as a renderer's near clip: lifting the origin along the normal by as much moves
concave vertices out of their crease and leaves 7 % RMS error at any ray count."""

SMALLEST_SKIP = 1e-5
"""The least length, as a share of how far from the origin the ray and the surface it starts on reach: below it float32 hits
that surface. The origin lies amid the scene's smallest triangles: a backdrop far away costs nothing there."""


_MOST_PASSED = 64
"""So many surfaces that let light through does a ray pass; what lies behind more of them counts as the sky."""

_BEYOND = 2e-6
"""How far behind such a surface a ray goes on, as a share of its way and of its start's distance: a few roundings of float32."""

_LOOKED_AT = 1 << 15  # triangles that the middle is found by
_HALVINGS = 36  # a part of some 2^-12 of the whole along each axis

_BLOCK = 1 << 13
"""Triangles that are handed over at once: a cancel is heard in between."""


def is_available() -> bool:
    """Whether embreex could be imported."""
    return EmbreeScene is not None


def require() -> None:
    """Raises RayCasterMissing, with what to do, if embreex could not be imported."""
    if not is_available():
        raise RayCasterMissing(
            "The ray caster embreex is not installed for this Python: install the extension's zip made for your "
            "platform, or bake with mode Unshadowed, which needs no rays."
        )


@dataclass(frozen=True)
class Hits:
    """Nearest hits of N rays: triangle index or -1, barycentrics of corners 1 and 2, and whether a front face."""

    triangle: npt.NDArray[np.int32]
    u: Float32
    v: Float32
    front: npt.NDArray[np.bool_]

    def sides(self, triangles: int, both: bool) -> npt.NDArray[np.int32]:
        """(N,) the side that each ray hit, or -1.

        Args:
            triangles: T, how many there are: the front of one has its number, the back that plus T.
            both: whether backs count; they have -1 if not.
        """
        if not both:
            return np.where(self.front, self.triangle, np.int32(-1))
        return np.where(self.front | (self.triangle < 0), self.triangle, self.triangle + np.int32(triangles))


class RayScene:
    """Triangles to shoot at, scaled to about a unit sphere, in whose middle the smallest are: there float32 is most precise."""

    def __init__(
        self,
        vertices: Float64,
        triangles: npt.NDArray[np.int32],
        monitor: Monitor = UNWATCHED,
        one_sided: npt.NDArray[np.bool_] | None = None,
        opacity: Opacity | None = None,
    ) -> None:
        """
        Args:
            vertices: (V, 3) finite coordinates in any unit.
            triangles: (T, 3) vertex indices, counter-clockwise seen from the front. Without any, all rays leave.
            monitor: checked for a cancel now and then.
            one_sided: (T,) whether rays pass through the back of a triangle; through none if None.
            opacity: which share of the rays a triangle stops; all if None.

        Raises:
            RayCasterMissing: if embreex is not installed.
            MeshError: if a coordinate is not finite.
        """
        require()
        if not np.isfinite(vertices).all():
            raise MeshError("A mesh holds NaN or infinite coordinates: remove those vertices and bake again.")
        low, high = (vertices.min(axis=0), vertices.max(axis=0)) if len(vertices) else (np.zeros(3), np.zeros(3))
        self.centre: Float64 = _finest(vertices, triangles) if len(triangles) else (low + high) / 2.0
        self.radius = float(np.linalg.norm(high - low)) / 2.0 or 1.0
        self._scene = EmbreeScene(robust=True)
        points = self.normalised(vertices).astype(np.float32)
        self._one_sided = np.zeros(len(triangles), dtype=np.bool_) if one_sided is None else one_sided
        self._opacity = opacity
        self.triangles = len(triangles)
        self._may_pass = self._one_sided if opacity is None else self._one_sided | opacity.is_open
        self._stops_all = not self._may_pass.any()
        self._blocks: list[Any] = []
        for start in range(0, len(triangles), _BLOCK):
            self._blocks.append(_mesh(self._scene, points, triangles[start : start + _BLOCK]))
            monitor.check_cancelled()

    @classmethod
    def of(cls, occluders: Occluders, monitor: Monitor = UNWATCHED) -> RayScene:
        """All that blocks light in an island. Errors as above."""
        return cls(occluders.vertices, occluders.triangles, monitor, occluders.one_sided, occluders.opacity)

    def normalised(self, points: Float64) -> Float64:
        """World points to the scene's own unit sphere, where rays are given."""
        return (points - self.centre) / self.radius

    def skips(self, points: Float64, object_radius: float) -> Float64:
        """(N,) how far rays from an object of that radius (world units) start along themselves.

        Args:
            points: (N, 3) where they start, normalised as the result.
            object_radius: in world units.
        """
        size = object_radius / self.radius
        return np.clip(SKIP * size, self.least_skips(points, size), SKIP)

    @staticmethod
    def least_skips(points: Float64, sizes: Float64 | float) -> Float64:
        """(N,) how far they must start along themselves at least, from surfaces of those sizes; all normalised."""
        least: Float64 = SMALLEST_SKIP * (np.linalg.norm(points, axis=1) + sizes)
        return least

    def visible(self, origins: Float32, directions: Float32) -> npt.NDArray[np.bool_]:
        """(N,) whether each ray leaves the scene unblocked. Rays are (N, 3), normalised units."""
        if not (self._stops_all and self._blocks):
            return self.hits(origins, directions).triangle < 0
        self._check(origins, directions)
        answer: npt.NDArray[np.int32] = self._scene.run(origins, directions, query="OCCLUDED")
        return answer < 0

    def hits(self, origins: Float32, directions: Float32) -> Hits:
        """Nearest hits of rays (N, 3), normalised units."""
        nearest, distance = self.crossings(origins, directions)
        if not self._stops_all:
            self._pass_through(nearest, distance, origins, directions)
        return nearest

    def crossings(self, origins: Float32, directions: Float32) -> tuple[Hits, Float32]:
        """Nearest hits of rays (N, 3), surfaces that let light through among them, and how far they are; normalised units."""
        self._check(origins, directions)
        if not self._blocks:
            nowhere = np.zeros(len(origins), dtype=np.float32)
            return Hits(np.full(len(origins), -1, dtype=np.int32), nowhere, nowhere.copy(), nowhere > 0.0), nowhere
        return self._nearest(origins, directions)

    def _nearest(self, origins: Float32, directions: Float32) -> tuple[Hits, Float32]:
        found = self._scene.run(origins, directions, output=True)
        front = np.einsum("ij,ij->i", found["Ng"], directions) < 0.0
        triangle = found["geomID"]
        triangle *= _BLOCK
        triangle += found["primID"]
        np.maximum(triangle, -1, out=triangle)
        return Hits(triangle, found["u"], found["v"], front), found["tfar"]

    def _pass_through(self, hits: Hits, distance: Float32, origins: Float32, directions: Float32) -> None:
        """Send the rays that a surface lets through on their way, changing the hits in place."""
        rays = np.arange(len(origins))
        for _ in range(_MOST_PASSED):
            passes = self._passes(hits, rays, directions)
            rays, distance = rays[passes], distance[passes]
            if not len(rays):
                return
            start = np.linalg.norm(origins[rays], axis=1)
            distance = distance * np.float32(1.0 + _BEYOND) + np.float32(_BEYOND) * start
            after, further = self._nearest(origins[rays] + directions[rays] * distance[:, None], directions[rays])
            for field in fields(Hits):
                getattr(hits, field.name)[rays] = getattr(after, field.name)
            distance = distance + further
        hits.triangle[rays] = -1

    def _passes(self, hits: Hits, rays: npt.NDArray[np.int64], directions: Float32) -> npt.NDArray[np.bool_]:
        """(R,) which of some rays the surfaces that they hit let through."""
        triangle = hits.triangle[rays]
        passes = (triangle >= 0) & self._may_pass.take(triangle, mode="clip")
        may_pass = np.flatnonzero(passes)
        rays, triangle = rays[may_pass], triangle[may_pass]
        passes[may_pass] = self._one_sided[triangle] & ~hits.front[rays]
        if self._opacity is not None:
            passes[may_pass] |= self._opacity.lets_through(triangle, hits.u[rays], hits.v[rays], directions[rays])
        return passes

    @staticmethod
    def _check(origins: Float32, directions: Float32) -> None:
        for rays in (origins, directions):
            if rays.dtype != np.float32 or rays.ndim != 2 or rays.shape[1] != 3 or not rays.flags.c_contiguous:
                raise ValueError("rays must be C-contiguous float32 arrays of shape (N, 3)")
        if len(origins) != len(directions):
            raise ValueError(f"{len(origins)} origins for {len(directions)} directions")


def _finest(vertices: Float64, triangles: npt.NDArray[np.int32]) -> Float64:
    """(3,) a place amid the smallest triangles: all of them are halved along their longest extent again and again, and the half
    that weighs more is kept. A triangle weighs one over its longest edge squared. Of many triangles some are looked at."""
    corners = vertices[triangles[:: max(1, len(triangles) // _LOOKED_AT)]]
    size = np.square(corners - np.roll(corners, 1, axis=1)).sum(axis=2).max(axis=1)
    place, weight = corners.mean(axis=1), 1.0 / np.where(size > 0.0, size, np.inf)
    for _ in range(_HALVINGS):
        low, high = place.min(axis=0), place.max(axis=0)
        axis = int(np.argmax(high - low))
        lower = place[:, axis] <= (low[axis] + high[axis]) / 2.0
        kept = lower if weight[lower].sum() >= weight[~lower].sum() else ~lower
        place, weight = place[kept], weight[kept]
    middle: Float64 = (place.min(axis=0) + place.max(axis=0)) / 2.0
    return middle


def _mesh(scene: Any, points: Float32, triangles: npt.NDArray[np.int32]) -> Any:
    """Hand over some triangles with the points that they use."""
    used, corners = np.unique(triangles, return_inverse=True)
    return TriangleMesh(scene, points[used], corners.reshape(-1, 3).astype(np.int32))
