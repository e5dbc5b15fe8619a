# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures one object at random points of its surface: all that the parts of a report are computed from."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from ..arrays import Float64
from ..sphere import sh
from ..workers import ALL_CORES, Workers
from .fresh import fresh_transport
from .measures import CONVERGED, reference_interval
from .path_tracer import trace_light
from .points import SurfacePoints, areas, scatter
from .subject import ORDERS, Lighting, Subject, clamped, dot

INSIDE = 0.9
"""Share of the rays that end on backs of faces, from which on a point lies in the midst of other geometry."""

_MOST = 16  # times the samples, for a truth that is slow to converge
_FRESH_RAYS = 1 << 22  # of one object, for sampling and tessellation: about a second


@dataclass(frozen=True)
class Effort:
    """How much work a report may take.

    Attributes:
        points: of each object's surface.
        samples: paths per point, twice; up to 16 times as many until the truth has converged.
        seed: of all random numbers.
    """

    points: int = 256
    samples: int = 256
    seed: int = 0


@dataclass(frozen=True)
class Findings:
    """Radiance that a white surface shows at n points, RGB; what is estimated comes twice, independently.

    Attributes:
        name: of the object.
        weights: (n,) the area each point stands for.
        shown: (n, 3) what the shader shows.
        truth: (2, n, 3) what arrives.
        truncated: (2, n, 3) what the light stored on the world would show, of transport without noise.
        orders: (2, 6, n, 3) the same of the sky in orders 1 to 6, none windowed.
        without_lamps: (2, n, 3) what order 2 loses of the sky without its lamps, against what arrives of that; None if it has none.
        at_points: (2, m, 3) what fresh bakes show at m of the points, m < n where the bake had many samples, and
        between: (2, m, 3) what they show there if they are made at the corners and interpolated.
        fresh: (m,) which points these are.
        at_seam: (n,) which points lie on faces with a corner inside other geometry.
        inside: share of the surface that lies inside other geometry, and is left out.
        mode: of the bake.
        samples: of the bake; none where it cast no rays.
    """

    name: str
    weights: Float64
    shown: Float64
    truth: Float64
    truncated: Float64
    orders: Float64
    without_lamps: Float64 | None
    at_points: Float64
    between: Float64
    fresh: npt.NDArray[np.int64]
    at_seam: npt.NDArray[np.bool_]
    inside: float
    mode: str
    samples: int

    @property
    def area(self) -> float:
        """The area of the surface that is looked at."""
        return float(self.weights.sum())


def find(subject: Subject, light: Lighting, effort: Effort, workers: Workers = ALL_CORES) -> Findings:
    """Measure an object: at each point, cast the rays of two bakes like the stored one, and trace two sets of paths."""
    surface = float(areas(subject.corners).sum())
    points = scatter(subject.corners, subject.corner_receiver, subject.group.normals, effort.points, effort.seed)
    seen, clear, at_seam = _outside(subject, points, effort, workers)
    weights = np.full(int(seen.sum()), surface / max(len(seen), 1))
    points, clear, at_seam = _some(points, seen), _some(clear, seen), at_seam[seen]
    with_corners = np.flatnonzero(clear.shares.any(axis=1))

    shown_light = light.shown(subject.axes)
    stored = subject.transport[points.corners].astype(np.float64)
    shown = clamped(points.between(dot(stored, shown_light)))

    radiance, transport = _truth(subject, light, points, weights, effort, workers)
    projected = light.projected(subject.axes)
    truncated = _clamped_twice(dot(transport[:, :, : len(shown_light)], shown_light))
    orders = [_clamped_twice(_truncated(transport, projected[0], order)) for order in ORDERS]
    without_lamps = None
    if light.lamps.lamps:
        without_lamps = _clamped_twice(_truncated(transport, projected[1], sh.ORDER)) - radiance[:, :, 1]
    rays = 2 * (1 + 3) * subject.settings.samples if subject.casts_rays else 1
    fresh = with_corners[_thinned(len(with_corners), rays)]
    at_points, between = _fresh(subject, _some(clear, fresh), shown_light, effort, workers)
    return Findings(
        name=subject.group.name,
        weights=weights,
        shown=shown,
        truth=radiance[:, :, 0],
        truncated=truncated,
        orders=np.stack(orders, axis=1),
        without_lamps=without_lamps,
        at_points=at_points,
        between=between,
        fresh=fresh,
        at_seam=at_seam,
        inside=float(1.0 - seen.mean()) if len(seen) else 0.0,
        mode=subject.settings.mode,
        samples=subject.settings.samples if subject.casts_rays else 0,
    )


def _truth(
    subject: Subject, light: Lighting, points: SurfacePoints, weights: Float64, effort: Effort, workers: Workers
) -> tuple[Float64, Float64]:
    """Two independent traces, radiance (2, n, P, 3) and transport (2, n, K, 3), of as many paths as it takes."""
    scene = subject.scenery.scene if subject.casts_rays else None
    receivers = subject.receivers_at(points.positions, points.normals, np.arange(len(points)))
    sky, bounces = light.sky(subject.axes), subject.scenery.bounces(subject.settings)

    def trace(samples: int, seed: int) -> tuple[Float64, Float64]:
        """Radiance (2, n, P, 3) and transport (2, n, K, 3) of two independent traces."""
        pair = [trace_light(scene, receivers, sky, samples, 2 * seed + k, bounces, ORDERS[-1], workers) for k in (0, 1)]
        return np.stack([one.radiance for one in pair]), np.stack([one.transport for one in pair])

    samples = effort.samples
    radiance, transport = trace(samples, effort.seed)
    while samples < _MOST * effort.samples and reference_interval(radiance[:, :, 0], weights) > CONVERGED:
        more = trace(samples, effort.seed + samples)
        radiance, transport = (radiance + more[0]) / 2.0, (transport + more[1]) / 2.0
        samples *= 2
    return radiance, transport


def _truncated(transport: Float64, light: Float64, order: int) -> Float64:
    count = sh.coefficient_count(order)
    return dot(transport[:, :, :count], light[:count])


def _clamped_twice(radiance: Float64) -> Float64:
    """Both replicates (2, n, 3) clamped where their mean is negative."""
    return clamped(radiance, by=radiance.mean(axis=0)[None])


def _thinned(count: int, rays: int) -> npt.NDArray[np.int64]:
    """Which points get so many rays each: all, or evenly chosen ones that the budget allows."""
    allowed = min(count, max(16, _FRESH_RAYS // rays))
    return (np.arange(allowed) * count) // max(allowed, 1)


def _fresh(
    subject: Subject, points: SurfacePoints, light: Float64, effort: Effort, workers: Workers
) -> tuple[Float64, Float64]:
    """Radiance of two fresh bakes at m points, and between their corners: (2, m, 3) each.

    A corner that several points share is baked anew for each, with a turn of its own: the points stay independent.
    """
    corners = points.corners.ravel()
    receivers = subject.receivers_at(
        np.concatenate([subject.group.points[corners], points.positions]),
        np.concatenate([subject.group.normals[corners], points.normals]),
        np.arange(len(corners) + len(points)),
    )
    found = []
    for k in (1, 2):
        seed = subject.settings.seed + 2 * effort.seed + k
        transport = fresh_transport(subject, receivers, subject.settings.samples, seed, workers)
        there, here = np.split(dot(transport, light), [len(corners)])
        found.append((here, points.between(there.reshape(-1, 3, 3))))
    here, between = (np.stack(one) for one in zip(*found, strict=True))
    return _clamped_twice(here), _clamped_twice(between)


def _outside(
    subject: Subject, points: SurfacePoints, effort: Effort, workers: Workers
) -> tuple[npt.NDArray[np.bool_], SurfacePoints, npt.NDArray[np.bool_]]:
    """Which points can be seen at all; all points with no share in corners that cannot; and which have such corners.

    What lies inside other geometry is never seen: errors there do not count.
    """
    if not subject.casts_rays or not len(points):
        return np.ones(len(points), dtype=np.bool_), points, np.zeros(len(points), dtype=np.bool_)
    surroundings = subject.scenery.surroundings
    receivers = subject.receivers_at(points.positions, points.normals, np.arange(len(points)))
    seen = surroundings.backs(receivers, effort.seed, workers) <= INSIDE
    corners, place = np.unique(points.corners, return_inverse=True)
    receivers = subject.receivers_at(subject.group.points[corners], subject.group.normals[corners], corners)
    clear = (surroundings.backs(receivers, effort.seed, workers) <= INSIDE)[place.reshape(points.corners.shape)]
    shares = np.where(clear, points.shares, 0.0)
    whole = shares.sum(axis=1, keepdims=True)
    return seen, replace(points, shares=shares / np.where(whole > 0.0, whole, 1.0)), ~clear.all(axis=1)


def _some(points: SurfacePoints, index: npt.NDArray[np.int64] | npt.NDArray[np.bool_]) -> SurfacePoints:
    return SurfacePoints(points.positions[index], points.normals[index], points.corners[index], points.shares[index])
