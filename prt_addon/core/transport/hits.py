# SPDX-License-Identifier: GPL-3.0-or-later
"""Keeps what every ray of a bake hit, compactly: light can then bounce over it again and again without new rays."""

from __future__ import annotations

import sys
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from ..arrays import Float32
from ..files import Spill, memory_of
from ..monitor import Work
from ..sphere import sh
from ..workers import ALL_CORES, Workers
from .direct import RayPattern, Receivers
from .raycast import Hits, RayScene

Packed = npt.NDArray[np.uint64]
UInt32 = npt.NDArray[np.uint32]

ONE = 0xFFFF
"""A barycentric of one, in the fixed point that hits are kept in."""

STEADY_BITS = 0xFFC0
"""The bits of a barycentric that random choices are made of: the rounding of a ray seldom changes them."""


@dataclass(frozen=True)
class PackedHits:
    """Hits that return light, eight bytes each, in the order of the receivers and of the rays of each.

    Attributes:
        samples: rays that were cast per receiver.
        starts: (N + 1,) int64; the hits of receiver x are `packed[starts[x]:starts[x + 1]]`.
        packed: (H,) uint64; in the upper 32 bits a corner, counted through all sides of triangles: k of side t is 3 t + k. It is
            drawn by the barycentrics, and may stand for the hit. Then u and v in 16 bits each, `ONE` being 1.
    """

    samples: int
    starts: npt.NDArray[np.int64]
    packed: Packed

    @property
    def nbytes(self) -> int:
        """The memory that the hits occupy."""
        return memory_of(self.starts, self.packed)

    def __len__(self) -> int:
        return len(self.starts) - 1


class HitStore:
    """The hits of many receivers in pieces, each of consecutive receivers: they are never copied into one array.

    samples: rays that were cast per receiver.
    pieces: in the order of the receivers. Where they are cut changes no result.
    spill: where what belongs to the hits is kept.
    """

    def __init__(self, samples: int, budget: int) -> None:
        """
        Args:
            samples: rays per receiver.
            budget: bytes that may stay in memory; the hits beyond are kept on disk (see `spill`).
        """
        self.samples = samples
        self.pieces: list[PackedHits] = []
        self.spill = Spill(budget)

    @classmethod
    def of(cls, hits: PackedHits) -> HitStore:
        """A store of one piece, all in memory."""
        store = cls(hits.samples, sys.maxsize)
        store.add(hits)
        return store

    def add(self, hits: PackedHits) -> None:
        """Append the hits of the next receivers. Such as lie in a file already cost no memory.

        Raises:
            ValueError: if another number of rays was cast per receiver than in the pieces before.
            NoRoom: if hits beyond the budget cannot be kept on disk.
        """
        if hits.samples != self.samples:
            raise ValueError(f"hits of {hits.samples} rays per receiver among those of {self.samples}")
        self.pieces.append(PackedHits(hits.samples, hits.starts, self.spill.keep(hits.packed)))

    @property
    def count(self) -> int:
        """The number of hits of all receivers."""
        return sum(len(piece.packed) for piece in self.pieces)

    @property
    def nbytes(self) -> int:
        """The memory that the hits occupy."""
        return sum(piece.nbytes for piece in self.pieces)

    def __len__(self) -> int:
        return sum(map(len, self.pieces))


def corners(packed: Packed) -> UInt32:
    """(H,) uint32 the corner that may stand for each hit: one of its triangle's three, counted through all sides, 3 t + 0..2."""
    return np.asarray(packed).view("<u4")[1::2]


def barycentrics(packed: Packed) -> tuple[UInt32, UInt32]:
    """(H,) uint32 u and v, the shares of corners 1 and 2, in fixed point: each 0..`ONE`, as is their sum."""
    both: UInt32 = np.asarray(packed).view("<u4")[::2]
    return both >> np.uint32(16), both & np.uint32(ONE)


def trace(
    scene: RayScene,
    receivers: Receivers,
    samples: int,
    seed: int,
    returns: npt.NDArray[np.bool_],
    workers: Workers = ALL_CORES,
) -> tuple[Float32, PackedHits]:
    """Trace rays: direct transport, the same bits as `direct.shadowed`, and what the blocked rays hit.

    A hit on a side that returns nothing blocks the light all the same.

    Args:
        scene: what blocks the light.
        receivers: N points.
        samples: rays per receiver.
        seed: of their pattern.
        returns: (T,) whether a triangle's front returns light; or (2 T,), also whether its back does, after all fronts.
        workers: who does it.

    Returns:
        (N, 9) float32 direct transport, and the hits.
    """
    pattern, both = RayPattern(samples, seed), len(returns) > scene.triangles
    direct = np.empty((len(receivers), sh.coefficient_count(sh.ORDER)), dtype=np.float32)
    starts = np.zeros(len(receivers) + 1, dtype=np.int64)
    chunks: dict[int, Packed] = {}

    def work(part: slice) -> Work:
        """Trace the rays of some receivers: fills their rows of `direct`, their hits, and how many those are."""
        rays = pattern.rays(receivers[part])
        hits = scene.hits(rays.origins, rays.directions)
        visible, side = hits.triangle < 0, hits.sides(scene.triangles, both)
        keep = side >= 0
        if rays.above is not None:
            visible &= rays.above
            keep &= rays.above
        direct[part] = pattern.project(visible, rays.frames)
        keep &= returns.take(side, mode="clip")
        starts[part.start + 1 : part.stop + 1] = np.count_nonzero(keep.reshape(-1, samples), axis=1)
        chunks[part.start] = _packed(replace(hits, triangle=side), np.flatnonzero(keep), receivers.ids[part], samples)
        return Work(rays=len(rays.origins))

    workers.run(len(receivers), pattern.chunk, work)
    np.cumsum(starts, out=starts)
    return direct, PackedHits(samples, starts, _joined(chunks, starts, workers))


def _packed(hits: Hits, which: npt.NDArray[np.intp], ids: npt.NDArray[np.int64], samples: int) -> Packed:
    """Some of the hits in eight bytes each; `ids` are those of the receivers, which cast so many samples each."""
    u = _fixed_point(hits.u.take(which))
    v = np.minimum(_fixed_point(hits.v.take(which)), ONE - u)
    packed = np.empty((len(which), 2), dtype="<u4")
    packed[:, 0] = u << 16 | v
    packed[:, 1] = hits.triangle.take(which)
    packed[:, 1] *= 3
    receiver, ray = np.divmod(which, samples)
    packed[:, 1] += _drawn(u, v, ids.take(receiver), ray)
    return packed.reshape(-1).view(np.uint64)


def _drawn(u: UInt32, v: UInt32, ids: npt.NDArray[np.int64], ray: npt.NDArray[np.intp]) -> npt.NDArray[np.uint8]:
    """(H,) one corner of each triangle, 0..2, each with the probability of its barycentric.

    The random number is made of the receiver and the ray: of where the ray hit, all rays that hit about the same place of a
    large triangle would choose alike.
    """
    number = ids.astype(np.uint32) * np.uint32(0x9E3779B1) + ray.astype(np.uint32) * np.uint32(0x85EBCA77)
    number ^= number >> np.uint32(15)
    number *= np.uint32(0x2C1B3C6D)
    number >>= np.uint32(16)
    not_first, second = number < u + v, number < u
    return not_first.view(np.uint8) * np.uint8(2) - second.view(np.uint8)


def _fixed_point(barycentric: Float32) -> UInt32:
    barycentric *= np.float32(ONE)
    barycentric += np.float32(0.5)
    return np.clip(barycentric, 0.0, ONE, out=barycentric).astype(np.uint32)


def _joined(chunks: dict[int, Packed], starts: npt.NDArray[np.int64], workers: Workers) -> Packed:
    """All chunks in the order of the receivers; each is dropped once it is copied, to spare memory."""
    packed = np.empty(starts[-1], dtype=np.uint64)
    firsts = list(chunks)

    def copy(part: slice) -> None:
        """Copy the chunks that start at `firsts[part]` to their places."""
        for first in firsts[part]:
            chunk = chunks.pop(first)
            packed[starts[first] : starts[first] + len(chunk)] = chunk

    workers.run(len(firsts), 1, copy)
    return packed
