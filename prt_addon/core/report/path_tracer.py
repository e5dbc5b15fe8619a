# SPDX-License-Identifier: GPL-3.0-or-later
"""Traces paths to the sky in full resolution, without spherical harmonics: the light that really arrives.

Surfaces are those of the bake: white Lambertian receivers, shading normals, sides that return light by their
albedo, as many bounces. Each vertex of a path looks for the sky twice, along a direction drawn by the sky's brightness
and along one drawn by the cosine, and both are weighed by the balance heuristic (Veach & Guibas 1995, "Optimally
Combining Sampling Techniques for Monte Carlo Rendering", equation 13): suns are found by the first, the broad sky by
the second. The same paths also project the light's way on spherical harmonics, so that what a band-limited sky would
show differs from the truth by the sky alone and by no other noise.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from ..arrays import Bools, Float64, Int64
from ..monitor import Work
from ..sky.sampler import Skylight
from ..sphere import sh
from ..sphere.directions import tangent_frames
from ..surface import Albedo
from ..transport.direct import Receivers
from ..transport.raycast import RayScene
from ..workers import ALL_CORES, Workers

_PATHS_AT_A_TIME = 1 << 15  # fixed: the random numbers belong to the chunk
_GOLDEN = (np.sqrt(5.0) - 1.0) / 2.0


@dataclass(frozen=True)
class Bounces:
    """What paths need to know of surfaces to go on from them.

    Attributes:
        count: how often a path may bounce.
        corners: (S, 3, 3) the sides' corners in the scene's normalised coordinates: of all fronts, then of all backs if they count.
        normals: (S, 3, 3) unit shading normals at the corners.
        returns: (S,) whether the side returns light.
        albedo: of the sides.
    """

    count: int
    corners: Float64
    normals: Float64
    returns: Bools
    albedo: Albedo


@dataclass(frozen=True)
class Arrived:
    """The light that arrives at n points.

    Attributes:
        radiance: (n, P, 3), what a white receiver shows under each picture of the sky.
        transport: (n, (order + 1)**2, 3), the same under each harmonic.
    """

    radiance: Float64
    transport: Float64


@dataclass
class _Paths:
    """The paths that still run: which point each began at, where it is, and what is left of its light."""

    point: Int64
    position: Float64
    normal: Float64
    skip: Float64
    tint: Float64


@dataclass
class _Tally:
    """Sums of what the paths of n points found."""

    order: int
    sky: Skylight
    count: int
    radiance: Float64 = field(init=False)
    transport: Float64 = field(init=False)

    def __post_init__(self) -> None:
        self.radiance = np.zeros((self.count, self.sky.count * 3))
        self.transport = np.zeros((self.count, 3, sh.coefficient_count(self.order)))

    def add(self, paths: _Paths, directions: Float64, reach: Bools) -> None:
        """Light that reaches the paths that `reach` says along unit vectors, weighed by the balance heuristic."""
        way = directions[reach]
        point, tint = paths.point[reach], paths.tint[reach]
        cosine = np.einsum("ij,ij->i", way, paths.normal[reach]) / np.pi
        light = tint * (cosine / (cosine + self.sky.density(way)))[:, None]
        shown = (self.sky.radiance(way) * light[:, None, :]).reshape(len(way), self.radiance.shape[1])
        for column in range(shown.shape[1]):
            self.radiance[:, column] += np.bincount(point, shown[:, column], self.count)
        harmonics = sh.basis(way, self.order)
        ends = np.searchsorted(point, np.arange(self.count + 1))
        for x, (first, last) in enumerate(pairwise(ends)):  # paths stay sorted by their point
            self.transport[x] += light[first:last].T @ harmonics[first:last]

    def means(self, samples: int) -> tuple[Float64, Float64]:
        """(count, P, 3) radiance and (count, K, 3) transport of each point, over so many paths."""
        radiance = self.radiance.reshape(self.count, -1, 3) / samples
        return radiance, self.transport.transpose(0, 2, 1) / samples


def trace_light(
    scene: RayScene | None,
    receivers: Receivers,
    sky: Skylight,
    samples: int,
    seed: int,
    bounces: Bounces | None = None,
    order: int = 6,
    workers: Workers = ALL_CORES,
) -> Arrived:
    """Trace paths from points to the sky. Unbiased: other seeds give other, independent estimates of the same.

    Args:
        scene: what blocks the light; nothing if None.
        receivers: n points; their ids play no part.
        sky: in the axes of the points.
        samples: paths per point, each with two rays per vertex.
        seed: of the random numbers; the result is a function of the arguments, whatever the threads.
        bounces: of light; none if None.
        order: of the harmonics.
        workers: who does it.
    """
    count = len(receivers)
    arrived = Arrived(np.empty((count, sky.count, 3)), np.empty((count, sh.coefficient_count(order), 3)))

    def work(part: slice) -> Work:
        """Trace all paths of some points, by random numbers of their own, and fill their rows."""
        rng = np.random.default_rng((seed, part.start))
        tally = _Tally(order, sky, part.stop - part.start)
        rays = _trace(scene, receivers[part], tally, samples, rng, bounces)
        arrived.radiance[part], arrived.transport[part] = tally.means(samples)
        return Work(rays=rays)

    workers.run(count, max(1, _PATHS_AT_A_TIME // samples), work)
    return arrived


def _trace(
    scene: RayScene | None,
    receivers: Receivers,
    tally: _Tally,
    samples: int,
    rng: np.random.Generator,
    bounces: Bounces | None,
) -> int:
    """All paths of some points; returns the rays that were cast."""
    point = np.repeat(np.arange(len(receivers)), samples)
    paths = _Paths(
        point, receivers.points[point], receivers.normals[point], receivers.skips[point], np.ones((len(point), 3))
    )
    uniform = np.concatenate([_shifted_lattice(len(receivers), samples, rng) for _ in range(2)], axis=1)
    rays, left = 0, bounces.count if bounces else 0
    while len(paths.point):
        to_sky = tally.sky.draw(uniform[:, :2]) if tally.sky.flux else -paths.normal
        tally.add(paths, to_sky, _unblocked(scene, paths, to_sky))
        onward = _by_cosine(paths.normal, uniform[:, 2:])
        rays += 2 * len(paths.point)
        if bounces is None or not left or scene is None:
            tally.add(paths, onward, _unblocked(scene, paths, onward))
            break
        hits = scene.hits(*_rays(paths, onward))
        tally.add(paths, onward, hits.triangle < 0)
        side = hits.sides(scene.triangles, both=len(bounces.returns) > scene.triangles)
        on = np.flatnonzero((side >= 0) & bounces.returns[side])
        paths = _bounced(paths.point[on], paths.tint[on], bounces, side[on], hits.u[on], hits.v[on])
        uniform = rng.random((len(on), 4))
        left -= 1
    return rays


def _bounced(
    point: Int64,
    tint: Float64,
    bounces: Bounces,
    side: npt.NDArray[np.int32],
    u: npt.NDArray[np.float32],
    v: npt.NDArray[np.float32],
) -> _Paths:
    """Paths that go on from where rays hit."""
    weights = np.stack([1.0 - u - v, u, v], axis=-1).astype(np.float64)
    position = np.einsum("ik,ikc->ic", weights, bounces.corners[side])
    normal = np.einsum("ik,ikc->ic", weights, bounces.normals[side])
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    kept = np.flatnonzero(length[:, 0] > 0.0)
    colour = bounces.albedo.at(side, u, v).astype(np.float64)
    place = position[kept]
    sizes = np.linalg.norm(bounces.corners[side[kept]] - place[:, None], axis=-1).max(axis=1)
    skip = RayScene.least_skips(place, sizes)
    return _Paths(point[kept], place, (normal / np.where(length > 0.0, length, 1.0))[kept], skip, (tint * colour)[kept])


def _unblocked(scene: RayScene | None, paths: _Paths, directions: Float64) -> Bools:
    """Which paths see the sky along unit vectors above their horizon."""
    above: Bools = np.einsum("ij,ij->i", directions, paths.normal) > 0.0
    if scene is not None and above.any():
        origins, ways = _rays(paths, directions)
        above[above] = scene.visible(np.ascontiguousarray(origins[above]), np.ascontiguousarray(ways[above]))
    return above


def _rays(paths: _Paths, directions: Float64) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]:
    origins = paths.position + directions * paths.skip[:, None]
    return origins.astype(np.float32), directions.astype(np.float32)


def _by_cosine(normals: Float64, uniform: Float64) -> Float64:
    """(N, 3) unit vectors about normals of numbers (N, 2) in [0, 1), their density the cosine over pi."""
    azimuth = 2.0 * np.pi * uniform[:, 0]
    radius, height = np.sqrt(uniform[:, 1]), np.sqrt(1.0 - uniform[:, 1])
    local = np.stack([radius * np.cos(azimuth), radius * np.sin(azimuth), height], axis=-1)
    return np.einsum("ij,ijk->ik", local, tangent_frames(normals, np.zeros(len(normals))))


def _shifted_lattice(count: int, samples: int, rng: np.random.Generator) -> Float64:
    """(count * samples, 2) numbers in [0, 1): a Fibonacci lattice per point, each shifted at random (Cranley & Patterson
    1976), which leaves its means unbiased."""
    index = np.arange(samples)
    lattice = np.stack([(index + 0.5) / samples, index * _GOLDEN], axis=-1)
    return ((lattice + rng.random((count, 1, 2))) % 1.0).reshape(-1, 2)
