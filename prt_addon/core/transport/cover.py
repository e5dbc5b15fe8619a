# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds corners that other geometry covers, and gives them values at which their faces show what their open parts get.

A face is interpolated between its corners. Where one of them lies inside other geometry, as the corners of a road do in its
kerbs, the black that it got would be drawn over the open part. So light is sampled inside such faces. Samples in the open are
kept, and the covered corners get the values that come closest to them by least squares (Kavan, Bargteil & Sloan 2011, "Least
Squares Vertex Baking"). The fit extrapolates to the corner: what is in shadow near the seam stays so, which a mean of
neighbours would brighten.

Corners are looked at that are dark and see backs of faces, or from which an edge passes through a face: below a floor that is a
single sheet they see the sky from below. What is in the open is found by a few probing rays: of a face's samples, those that see
the sky, or no backs, and no more backs than others. Another one is, and a corner is not covered, if the way to the nearest such
sample leads out of nothing: along it as many faces are entered as are left. This distinguishes a corner in a kerb from one in the
shadow of a roof, and from a dark room with a window.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ..arrays import Bools, Float32, Float64, Int64
from ..workers import ALL_CORES, Workers
from .direct import RayPattern, Receivers
from .raycast import RayScene

_PROBES = 8  # rays
_SOME_BACKS = 0.1  # share of a corner's probes that end on backs: with none it lies in no solid
_LIFT = 0.02  # of the way: clear of the face itself
_BEYOND = 1.1  # of the way: samples often lie in the very surface, as the equator of a ball does
_MOST_CROSSINGS = 8  # faces along a way
_ON = 1e-4  # of the way: beyond a face that was crossed
_ENOUGH = 9  # samples about a corner
_SMOOTHING = 0.03  # pull towards the mean of the samples nearby, beside what the samples say
_STEPS = 24  # of the solver
_EDGES_AT_A_TIME = 1 << 14
_SPECTRUM = 0.03, 3.0  # of the equations, each divided by its own diagonal: three corners a face, and the smoothing


def _spread(rows: int) -> Float64:
    """(rows (rows + 1) / 2, 3) barycentric coordinates inside a triangle: the middles of a grid of triangles in it."""
    i, j = np.meshgrid(np.arange(rows), np.arange(rows), indexing="ij")
    inside = i + j < rows
    u, v = (i[inside] + 1.0 / 3.0) / rows, (j[inside] + 1.0 / 3.0) / rows
    return np.stack([1.0 - u - v, u, v], axis=-1)


PLACES = _spread(5)
"""(15, 3) where light is sampled in a face."""

_FIRST_LOOK = _spread(2)
"""(3, 3) likewise, of faces that are likely to have no open part."""


@dataclass(frozen=True)
class Faces:
    """Triangles of receivers.

    Attributes:
        corners: (F, 3) receivers.
        number: (F,) of each within its object.
    """

    corners: Int64
    number: Int64


@dataclass(frozen=True)
class Samples:
    """Samples of light inside faces that have covered corners.

    Attributes:
        receivers: M points.
        corners: (M, 3) the receivers at the corners of each one's face.
        shares: (M, 3) its barycentric coordinates.
        weight: (M,) the area that it stands for.
        covered: (N,) which receivers are fitted to them.
    """

    receivers: Receivers
    corners: Int64
    shares: Float64
    weight: Float64
    covered: Bools

    @classmethod
    def none(cls, receivers: Receivers) -> Samples:
        """The samples of a scene in which nothing is covered."""
        nothing = np.zeros((0, 3))
        covered = np.zeros(len(receivers), dtype=np.bool_)
        return cls(receivers[:0], nothing.astype(np.int64), nothing, np.zeros(0), covered)

    def __len__(self) -> int:
        return len(self.weight)


def sample_covered(
    scene: RayScene,
    receivers: Receivers,
    faces: Faces,
    edges: npt.NDArray[np.integer[Any]],
    dark: Bools,
    seed: int = 0,
    workers: Workers = ALL_CORES,
) -> Samples:
    """Find covered corners, and place samples in the open parts of their faces, as the top of this file says.

    Args:
        scene: what blocks the light.
        receivers: N points.
        faces: between them.
        edges: (E, 2) pairs of them that are neighbours on a mesh.
        dark: (N,) which see almost no sky.
        seed: as the bake's.
        workers: who does it; the few rays are not counted.
    """
    if not len(faces.corners):
        return Samples.none(receivers)
    in_solid, pierced = _suspects(scene, receivers, edges, dark, seed, workers)
    chosen = _open_in_parts(scene, receivers, faces, in_solid | pierced, seed, workers)
    if not len(chosen):
        return Samples.none(receivers)
    corners = faces.corners[chosen]
    inside = _placed(receivers, corners, faces.number[chosen], PLACES)
    sky, backs = (share.reshape(len(chosen), -1) for share in _probed(scene, inside, seed, workers))
    fewest = backs <= backs.min(axis=1, keepdims=True) + 1.0 / _PROBES
    is_open = ((sky > 0.0) & (backs < 0.5) & fewest) | (backs == 0.0)
    workers.monitor.check_cancelled()
    # What lies in no solid is covered only beside what is clearly in the open: in a thicket nothing is.
    beside = is_open & ((backs == 0.0) | ~(pierced & ~in_solid)[corners].any(axis=1)[:, None])
    places = inside.points.reshape(*is_open.shape, 3)
    covered, leads_out = _covered(scene, receivers, corners, places, beside, in_solid | pierced)
    is_open &= leads_out.any(axis=1)[:, None]
    kept = _in_the_open(scene, receivers, corners, places, is_open)
    before = kept.sum(axis=1)
    kept = _thinned(kept, corners, leads_out, len(receivers))
    at = np.flatnonzero(kept.reshape(-1))
    face, place = np.divmod(at, len(PLACES))
    points = receivers.points[corners]
    area = np.linalg.norm(np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0]), axis=1)
    weight = area * before / np.maximum(kept.sum(axis=1), 1) + np.finfo(float).tiny
    return Samples(inside[at], corners[face], PLACES[place], weight[face], covered)


def _suspects(
    scene: RayScene,
    receivers: Receivers,
    edges: npt.NDArray[np.integer[Any]],
    dark: Bools,
    seed: int,
    workers: Workers,
) -> tuple[Bools, Bools]:
    """(N,) which receivers are dark and see backs; and from which an edge passes through a face."""
    in_solid, pierced = (np.zeros(len(receivers), dtype=np.bool_) for _ in range(2))
    candidates = np.flatnonzero(dark)
    if len(candidates):
        _, backs = _probed(scene, receivers[candidates], seed, workers)
        in_solid[candidates[backs > _SOME_BACKS]] = True
    pierced[_pierced(scene, receivers, edges, workers)] = True
    return in_solid, pierced


def _open_in_parts(
    scene: RayScene, receivers: Receivers, faces: Faces, suspected: Bools, seed: int, workers: Workers
) -> Int64:
    """Faces with a suspected corner; of those with three, which most often lie deep inside, such as a first look finds open."""
    number = suspected[faces.corners].sum(axis=1)
    deep = np.flatnonzero(number == 3)
    if len(deep):
        some = _placed(receivers, faces.corners[deep], faces.number[deep], _FIRST_LOOK)
        sky, backs = (share.reshape(len(deep), -1) for share in _probed(scene, some, seed, workers))
        number[deep[~((sky > 0.0) | (backs == 0.0)).any(axis=1)]] = 0
    return np.flatnonzero(number)


def _pierced(scene: RayScene, receivers: Receivers, edges: npt.NDArray[np.integer[Any]], workers: Workers) -> Int64:
    """Receivers at the ends of edges that pass through a face."""
    found = np.zeros(len(edges), dtype=np.bool_)

    def work(part: slice) -> None:
        """Say of some edges whether a face lies between their ends, both lifted off the surface."""
        start, end = receivers.points[edges[part, 0]], receivers.points[edges[part, 1]]
        length = np.linalg.norm(end - start, axis=1)
        normals = receivers.normals[edges[part]]
        lift = _LIFT * length[:, None]
        start, end = start + lift * normals[:, 0], end + lift * normals[:, 1]
        way = (end - start) / np.where(length > 0.0, length, 1.0)[:, None]
        hits, distance = scene.crossings(start.astype(np.float32), way.astype(np.float32))
        found[part] = (hits.triangle >= 0) & (distance < length)

    workers.run(len(edges), _EDGES_AT_A_TIME, work)
    ends: Int64 = np.unique(edges[found])
    return ends


def _placed(receivers: Receivers, corners: Int64, number: Int64, where: Float64) -> Receivers:
    """Samples at some places of faces, face by face. Their random numbers are no receiver's."""
    count = len(corners) * len(where)
    points = np.einsum("pk,fkc->fpc", where, receivers.points[corners]).reshape(count, 3)
    normals = np.einsum("pk,fkc->fpc", where, receivers.normals[corners]).reshape(count, 3)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    first = np.repeat(receivers.normals[corners[:, 0]], len(where), axis=0)
    normals = np.where(length > 1e-6, normals / np.where(length > 1e-6, length, 1.0), first)
    ids = (~number[:, None] * len(PLACES) - np.arange(len(where))).reshape(-1)  # below zero: no receiver has them
    skips = np.repeat(receivers.skips[corners].max(axis=1), len(where))
    return Receivers(points, normals, ids, skips)


def _probed(scene: RayScene, receivers: Receivers, seed: int, workers: Workers) -> tuple[Float64, Float64]:
    """(N,) shares of each receiver's probing rays that leave the scene, and that end on the back of a face."""
    pattern = RayPattern(_PROBES, seed)
    sky, backs = np.empty(len(receivers)), np.empty(len(receivers))

    def work(part: slice) -> None:
        """Cast the probing rays of some receivers, and fill in both shares."""
        rays = pattern.rays(receivers[part])
        hits = scene.hits(rays.origins, rays.directions)
        sky[part] = (hits.triangle < 0).reshape(-1, _PROBES).mean(axis=1)
        backs[part] = ((hits.triangle >= 0) & ~hits.front).reshape(-1, _PROBES).mean(axis=1)

    workers.run(len(receivers), pattern.chunk, work)
    return sky, backs


def _covered(
    scene: RayScene, receivers: Receivers, corners: Int64, places: Float64, is_open: Bools, suspected: Bools
) -> tuple[Bools, Bools]:
    """(N,) which receivers are covered: at half of their faces with an open part, at least, the way there leads out of
    something; and (F, 3) at which corners of the faces that is so. The open part of another face may lie beside its corner in
    the same cover, as below a floor of a single sheet.
    """
    face, corner = np.nonzero(suspected[corners] & is_open.any(axis=1)[:, None])
    receiver = corners[face, corner]
    start = receivers.points[receiver]
    nearest = _nearest(start, places[face], is_open[face])
    normals = receivers.normals[receiver]
    leaves = _leads_out(scene, start, places[face, nearest], normals)
    looks = np.bincount(receiver, minlength=len(receivers))
    covered: Bools = (looks > 0) & (2 * np.bincount(receiver, leaves, len(receivers)) >= looks)
    leads_out = np.zeros(corners.shape, dtype=np.bool_)
    leads_out[face, corner] = leaves & covered[receiver]
    return covered, leads_out


def _in_the_open(scene: RayScene, receivers: Receivers, corners: Int64, places: Float64, is_open: Bools) -> Bools:
    """(F, P) which samples are in the open: also those whose way to the nearest one that is leads out of nothing."""
    face, place = np.nonzero(~is_open & is_open.any(axis=1)[:, None])
    start = places[face, place]
    nearest = _nearest(start, places[face], is_open[face])
    leaves = _leads_out(scene, start, places[face, nearest], receivers.normals[corners[face, 0]])
    kept = is_open.copy()
    kept[face, place] = ~leaves
    return kept


def _thinned(kept: Bools, corners: Int64, leads_out: Bools, count: int) -> Bools:
    """(F, P) as many of the samples as covered corners need, evenly: where a corner has many faces, few of each."""
    face, corner = np.nonzero(leads_out)
    faces_at = np.bincount(corners[face, corner], minlength=count)
    wanted = np.zeros(len(kept), dtype=np.int64)
    np.maximum.at(wanted, face, -(-_ENOUGH // faces_at[corners[face, corner]]))
    have = kept.sum(axis=1, keepdims=True)
    wanted = np.minimum(wanted[:, None], have)
    rank = np.cumsum(kept, axis=1)  # of each kept sample, from 1
    steps = rank * wanted // np.maximum(have, 1)
    thinned: Bools = kept & (steps > (rank - 1) * wanted // np.maximum(have, 1))
    return thinned


def _nearest(start: Float64, places: Float64, allowed: Bools) -> Int64:
    """(n,) the nearest of (n, P) places to each of (n, 3) points."""
    distance = np.linalg.norm(places - start[:, None], axis=2)
    nearest: Int64 = np.argmin(np.where(allowed, distance, np.inf), axis=1)
    return nearest


def _leads_out(scene: RayScene, start: Float64, end: Float64, normals: Float64) -> Bools:
    """(n,) whether along straight ways, lifted off their faces, more faces are left through their backs than entered."""
    length = np.linalg.norm(end - start, axis=1)
    lift = _LIFT * length[:, None] * normals
    begin, way = start + lift, (end - start) / np.where(length > 0.0, length, 1.0)[:, None]
    depth, gone = np.zeros(len(start)), np.zeros(len(start))
    going = np.flatnonzero(length > 0.0)
    for _ in range(_MOST_CROSSINGS):
        if not len(going):
            break
        origins = (begin[going] + gone[going, None] * way[going]).astype(np.float32)
        hits, distance = scene.crossings(origins, way[going].astype(np.float32))
        reach = gone[going] + distance
        crossed = (hits.triangle >= 0) & (reach < _BEYOND * length[going])
        going, hits_front, reach = going[crossed], hits.front[crossed], reach[crossed]
        depth[going] += np.where(hits_front, -1.0, 1.0)
        gone[going] = reach + _ON * length[going]
    leads_out: Bools = depth > 0.0
    return leads_out


class Fit:
    """Gives covered receivers the values that come closest to the samples in their faces. Linear.

    The equations are solved by a fixed number of Chebyshev steps, which need no sums over all unknowns: the same bits
    whatever else is baked. Equations of faces that share no corner do not know of each other.
    """

    def __init__(self, samples: Samples, count: int) -> None:
        """
        Args:
            samples: the M samples.
            count: N, all receivers.
        """
        self._samples, self._count = samples, count
        self._covered = np.flatnonzero(samples.covered)
        index = np.full(count, -1, dtype=np.int64)
        index[self._covered] = np.arange(len(self._covered))
        self._unknown = index[samples.corners]
        self._is_unknown = self._unknown >= 0
        sample, corner = np.nonzero(self._is_unknown)
        unknown = self._unknown[sample, corner]
        order = np.argsort(unknown, kind="stable")
        self._sample, self._share = sample[order], samples.shares[sample, corner][order]
        self._starts = np.searchsorted(unknown[order], np.arange(len(self._covered)))
        weight = samples.weight[self._sample] * self._share
        self._weight = weight
        total = np.add.reduceat(weight, self._starts) if len(weight) else np.zeros(0)
        square = np.add.reduceat(weight * self._share, self._starts) if len(weight) else np.zeros(0)
        self._mean = weight / np.repeat(total, np.diff([*self._starts, len(weight)]))
        self._pull = _SMOOTHING * total
        self._diagonal = square + self._pull

    def __call__(self, transport: Float32) -> Float32:
        """(N + M, ...) float32, changed in place: the rows of the covered among N receivers, by those of the M samples."""
        if not len(self._covered):
            return transport
        rows = transport.reshape(len(transport), -1)
        sampled = rows[self._count :].astype(np.float64)
        known = np.where(self._is_unknown, 0.0, self._samples.shares)
        rest = sampled - np.einsum("mk,mkc->mc", known, rows[self._samples.corners].astype(np.float64))
        mean = self._summed(self._mean, sampled)
        right = self._summed(self._weight, rest) + self._pull[:, None] * mean
        rows[self._covered] = self._solved(right, mean)
        return transport

    def _summed(self, weight: Float64, values: Float64) -> Float64:
        """(U, C) sums over the samples about each unknown."""
        summed: Float64 = np.add.reduceat(weight[:, None] * values[self._sample], self._starts, axis=0)
        return summed

    def _product(self, x: Float64) -> Float64:
        """The equations' left side."""
        shown = np.einsum("mk,mkc->mc", np.where(self._is_unknown, self._samples.shares, 0.0), x[self._unknown])
        return self._summed(self._weight, shown) + self._pull[:, None] * x

    def _solved(self, right: Float64, x: Float64) -> Float64:
        """By Chebyshev's iteration (Saad 2003, "Iterative Methods for Sparse Linear Systems", algorithm 12.1)."""
        low, high = _SPECTRUM
        middle, half = (high + low) / 2.0, (high - low) / 2.0
        scale = 1.0 / self._diagonal[:, None]
        residual = scale * (right - self._product(x))
        sigma = middle / half
        rho, step = 1.0 / sigma, residual / middle
        for _ in range(_STEPS):
            x = x + step
            residual = residual - scale * self._product(step)
            before, rho = rho, 1.0 / (2.0 * sigma - rho)
            step = rho * before * step + 2.0 * rho / half * residual
        return x
