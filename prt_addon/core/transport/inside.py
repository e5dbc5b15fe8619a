# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds receivers inside other geometry by the backs of faces about them, and fills them from their neighbours on the
mesh.

Where one mesh sinks into another, the receivers below the seam are black, and every triangle that crosses the seam
draws that black above it. A receiver counts as buried if all of this holds:

1. It sees almost no sky. The others are not looked at, so that the usual bake pays nothing.
2. More than half of its rays end on the back of a face. In a solid nearly all do (what else is buried there shows its
   front); in a room whose faces point inwards, which is rightly black, none does.
3. The way out leads through a surface: of the mesh edges between its region of such receivers and the rest, three
   quarters pass through the back of a face. This distinguishes a solid, also one that is open below, from the shadow of a
   roof of single faces, from a thicket of sheets, and from a room that was built with its faces outwards and has a
   window: there, edges lead from dark to light and nothing lies between. What has no way out at all, an object deep
   inside another, has nothing to be filled from, and stays as it is.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ..arrays import Bools, Float32, Float64, Int64, Ints
from ..sphere import sh
from ..workers import ALL_CORES, Workers
from .cover import Fit
from .direct import RayPattern, Receivers
from .gather import Gather
from .raycast import Hits, RayScene

_DARK = 0.05  # share of the sky, weighed by the cosine
_BACKS = 0.5  # share of the rays
_CROSSED = 0.75  # share of the edges that lead out
_PROBES = 32  # rays: enough for a share that is about 0 or 1
_LIFT = 0.02  # of an edge's length: clear of the mesh's own faces, which the edge lies in
_BEYOND = 1.1  # of an edge's length: vertices often lie in the very surface, as the equator of a ball does


@dataclass(frozen=True)
class _Layer:
    """Receivers that are filled in one step: `target` (n,) by the means of runs of `source` (m,) from `starts` (n,)."""

    target: Int64
    source: Int64
    starts: Int64
    count: Int64


class Fill:
    """Replaces what buried receivers got by what their neighbours got, outermost receivers first. Linear."""

    def __init__(self, buried: Bools, edges: Ints) -> None:
        """
        Args:
            buried: (N,) which receivers.
            edges: (E, 2) pairs of receivers that are neighbours.
        """
        self.buried = buried
        self._layers: list[_Layer] = []
        known = ~buried
        edges = edges[buried[edges].any(axis=1)]
        pairs = np.concatenate([edges, edges[:, ::-1]])
        pairs = pairs[buried[pairs[:, 0]]]
        pairs = pairs[np.argsort(pairs[:, 0], kind="stable")]  # each one's neighbours in the order of its own edges
        while known[pairs[:, 1]].any():
            target, source = pairs[known[pairs[:, 1]]].T
            target, starts, count = np.unique(target, return_index=True, return_counts=True)
            self._layers.append(_Layer(target, source, starts, count))
            known[target] = True
            pairs = pairs[~known[pairs[:, 0]]]

    def __call__(self, transport: Float32) -> Float32:
        """(N, ...) float32, changed in place."""
        rows = transport.reshape(len(transport), -1)
        for layer in self._layers:
            sums = np.add.reduceat(rows[layer.source], layer.starts, axis=0)
            rows[layer.target] = sums / layer.count[:, None].astype(np.float32)
        return rows.reshape(transport.shape)


class Mend:
    """What is done about receivers inside other geometry. Linear.

    Covered corners of faces that are open in parts are fitted to these, what lies deeper is filled from its neighbours.
    """

    def __init__(self, fit: Fit, fill: Fill) -> None:
        self._fit, self._fill = fit, fill

    def __call__(self, transport: Float32) -> Float32:
        """(N + M, ...) float32 of N receivers and M samples, changed in place."""
        return self._fill(self._fit(transport))


class MendedGather(Gather):
    """Bounces whose light neither starts nor ends at a receiver inside other geometry."""

    def __init__(self, mend: Mend, *gather: Any) -> None:
        super().__init__(*gather)
        self._mend = mend

    def __call__(self, transport: Float32, thin: int | None = None) -> Float32:
        """One bounce: (N + M, C, 9) float32 from (N + M, C, 9)."""
        return self._mend(super().__call__(transport, thin))


@dataclass(frozen=True)
class Surroundings:
    """What receivers may be buried in.

    Attributes:
        scene: to cast rays at.
        vertices: (V, 3) world space.
        triangles: (T, 3) the same that `scene` was made of.
    """

    scene: RayScene
    vertices: Float64
    triangles: npt.NDArray[np.int32]

    def backs(self, receivers: Receivers, seed: int, workers: Workers) -> Float64:
        """(N,) share of each receiver's rays that end on the back of a face."""
        return self.share(lambda hits: (hits.triangle >= 0) & ~hits.front, receivers, seed, workers)

    def share(self, counts: Callable[[Hits], Bools], receivers: Receivers, seed: int, workers: Workers) -> Float64:
        """(N,) share of each receiver's rays that count; the few rays are not monitored.

        Args:
            counts: says of hits which do.
            receivers: N points.
            seed: as the bake's.
            workers: who casts the rays.
        """
        pattern = RayPattern(_PROBES, seed)
        share = np.empty(len(receivers))

        def work(part: slice) -> None:
            """Cast the rays of some receivers, and fill in their shares."""
            rays = pattern.rays(receivers[part])
            hits = self.scene.hits(rays.origins, rays.directions)
            share[part] = counts(hits).reshape(-1, _PROBES).mean(axis=1)

        workers.run(len(receivers), pattern.chunk, work)
        return share

    def pass_through_a_back(self, start: Float64, end: Float64) -> Bools:
        """(N,) whether the first surface from one point to another, or just behind it, shows its back to the start."""
        way = end - start
        length = np.linalg.norm(way, axis=1)
        way /= np.where(length > 0.0, length, 1.0)[:, None]
        hits = self.scene.hits(start.astype(np.float32), way.astype(np.float32))
        a, b, c = np.moveaxis(self.scene.normalised(self.vertices[self.triangles[hits.triangle]]), 1, 0)
        point = a + hits.u[:, None] * (b - a) + hits.v[:, None] * (c - a)
        distance = np.einsum("ij,ij->i", point - start, way)
        crossed: Bools = (hits.triangle >= 0) & ~hits.front & (distance < _BEYOND * length)
        return crossed


def find_buried(
    surroundings: Surroundings,
    receivers: Receivers,
    edges: Ints,
    direct: Float32,
    seed: int = 0,
    workers: Workers = ALL_CORES,
) -> Bools:
    """Find the receivers that lie inside other geometry and can be filled from outside, as the top of this file says.

    Args:
        surroundings: the geometry that they may lie in.
        receivers: N points.
        edges: (E, 2) pairs of receivers that are neighbours on a mesh.
        direct: (N, 9) their shadowed transport.
        seed: as the bake's.
        workers: who does it; the few rays are not counted.

    Returns:
        (N,) bool.
    """
    inside = is_dark(direct)
    if inside.any():
        inside &= _touches_light(inside, edges, workers)
    workers.monitor.check_cancelled()  # each of these steps takes a moment on large meshes: a cancel should not wait for all
    candidates = np.flatnonzero(inside)
    if not len(candidates):
        return inside
    inside[candidates] = surroundings.backs(receivers[candidates], seed, workers) > _BACKS
    ends_inside = inside[edges]
    region = _regions(edges[ends_inside.all(axis=1)], len(receivers), workers)
    out = edges[ends_inside[:, 0] != ends_inside[:, 1]]
    out = np.where(inside[out[:, :1]], out, out[:, ::-1])  # from the inside outwards
    start, end = receivers.points[out[:, 0]], receivers.points[out[:, 1]]
    lift = _LIFT * np.linalg.norm(end - start, axis=1)[:, None]
    crossed = surroundings.pass_through_a_back(
        start + lift * receivers.normals[out[:, 0]], end + lift * receivers.normals[out[:, 1]]
    )
    workers.monitor.check_cancelled()
    ways_out = np.bincount(region[out[:, 0]], minlength=len(receivers))
    through = np.bincount(region[out[:, 0]], crossed, len(receivers))
    return inside & ((ways_out > 0) & (through >= _CROSSED * ways_out))[region]


def is_dark(direct: Float32) -> Bools:
    """(N,) whether receivers of that shadowed transport (N, 9) see almost no sky."""
    dark: Bools = direct[:, 0] < _DARK * sh.basis([0.0, 0.0, 1.0])[0]
    return dark


def _touches_light(dark: Bools, edges: Ints, workers: Workers) -> Bools:
    """(N,) whether the dark region a receiver is in touches light: a closed room need not be looked at."""
    ends_dark = dark[edges]
    region = _regions(edges[ends_dark.all(axis=1)], len(dark), workers)
    touches = np.zeros(len(dark), dtype=np.bool_)
    touches[region[edges[ends_dark[:, 0] != ends_dark[:, 1]]]] = True
    found: Bools = touches[region]
    return found


def _regions(edges: Ints, count: int, workers: Workers = ALL_CORES) -> Int64:
    """(count,) the lowest index of all that edges (E, 2) connect each with.

    Every round hooks the roots of neighbouring trees, then shortens all paths (Shiloach & Vishkin 1982).
    """
    root = np.arange(count)
    while True:
        workers.monitor.check_cancelled()
        ends = root[edges]
        ends = ends[ends[:, 0] != ends[:, 1]]
        if not len(ends):
            return root
        np.minimum.at(root, ends.max(axis=1), ends.min(axis=1))
        while (root[root] != root).any():
            root = root[root]
