# SPDX-License-Identifier: GPL-3.0-or-later
"""Computes one bounce of light as a sparse matrix: what each receiver gets from the surfaces its rays hit.

`(G T)(x) = 1/S sum over hits h of x: albedo(h) sum over corners k: b_k(h) T(receiver at corner k)`. Rays are cosine-weighted,
so the weight is albedo / S with no further cosine, 1/pi or 4pi (Sloan, Kautz & Snyder 2002, section 5, with their
integral over the hemisphere sampled by its own cosine). Every row sums to at most the largest albedo.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from ..arrays import Float32, Int64
from ..files import Spill, memory_of
from ..monitor import Work
from ..problem import BOUNCE_IN_RAYS, THIN
from ..surface import Albedo
from ..workers import ALL_CORES, Workers
from .hits import ONE, STEADY_BITS, HitStore, Packed, PackedHits, barycentrics, corners
from .sources import Sources

_STEADY_MASK = np.uint64(STEADY_BITS << 16 | STEADY_BITS)  # of the barycentrics of a hit
_RECEIVERS_AT_A_TIME = 1 << 10
_HITS_AT_A_TIME = 1 << 19  # bounds the memory of bakes with many samples
_RAYS_IN_CACHE = 1 << 12  # measured: fewer pay for the calls, of more what they return leaves the cache
_COARSE_AT_A_TIME = 1 << 11
_TRIANGLES_AT_A_TIME = 1 << 13
_FINE = 0.03  # at 256 rays; see `Gather`


@dataclass(frozen=True)
class _Bounce:
    """What one bounce reads.

    Attributes:
        returned_light: (M + 1, C * 9) what each source returns; the last one nothing.
        stand_ins: (3 T,) the source that stands for hits drawn to each corner; the last one where the corners differ too much.
        thin: None to read all hits, or the number of a thin bounce.
        rays: how many rays of each receiver the hits that are read stand for.
    """

    returned_light: Float32
    stand_ins: npt.NDArray[np.int32]
    thin: int | None
    rays: int


@dataclass(frozen=True)
class _Piece:
    """Hits of consecutive receivers, and what was looked up for them once.

    Attributes:
        receivers: which.
        hits: theirs.
        pattern_starts: (n + 1,) where each receiver's hits on patterned triangles start in `pattern_colours`.
        pattern_colours: (P, C) uint16, fixed point.
    """

    receivers: slice
    hits: PackedHits
    pattern_starts: Int64
    pattern_colours: npt.NDArray[np.uint16]


class Gather:
    """`gather(T)` is G T, made from the kept hits as it is needed: eight bytes a hit and nothing else.

    Most of the time goes into fetching what the three corners of each hit return. Where these differ by less than can
    be seen, one of them stands for all: the one that was drawn by the barycentrics, which returns the same light on
    average, and always the same energy. `_FINE` is the largest difference of a coefficient that counts as none. The
    error that this adds is a small part of the noise that the rays have; as that falls faster with their number than the
    error of a random choice, the limit falls with the fourth root.
    """

    def __init__(
        self,
        hits: HitStore | PackedHits,
        albedo: Albedo,
        corner_receiver: npt.NDArray[np.integer[Any]],
        workers: Workers = ALL_CORES,
        counted: int | None = None,
    ) -> None:
        """
        Args:
            hits: of M receivers, which need not be those that light bounces off.
            albedo: of the triangles that were hit.
            corner_receiver: (T, 3) the receiver at each corner of a triangle; one at -1 returns no light.
            workers: who does it, now and in each bounce; their monitor sees the bounces done,
            counted: of so many of the receivers; of all if None.
        """
        store = HitStore.of(hits) if isinstance(hits, PackedHits) else hits
        self.channels = 1 if albedo.is_grey else 3
        self.sources = Sources.of(albedo, corner_receiver, self.channels)
        self._workers, self._samples, self._receivers = workers, store.samples, len(store)
        self._counted = len(store) if counted is None else counted
        self._chunk = min(_RECEIVERS_AT_A_TIME, max(1, _HITS_AT_A_TIME // store.samples))
        self._fine = _FINE * (256.0 / store.samples) ** 0.25
        self._is_patterned = albedo.is_patterned
        self._pieces = list(self._looked_up(store, albedo))

    @property
    def nbytes(self) -> int:
        """Memory that grows with the rays: the kept hits and the colours looked up for them."""
        return sum(piece.hits.nbytes + memory_of(piece.pattern_starts, piece.pattern_colours) for piece in self._pieces)

    def __call__(self, transport: Float32, thin: int | None = None) -> Float32:
        """One bounce: (M, C, 9) float32 from (N, C, 9).

        A thin one reads a quarter of the hits, others for each number: faster, with more noise, and the same on average.
        """
        returned_light = self.sources.returned_light(transport)
        rays = self._samples if thin is None else max(1, self._samples // THIN)
        bounce = _Bounce(returned_light, self._stand_ins(returned_light), thin, rays)
        out = np.empty((self._receivers, returned_light.shape[1]), dtype=np.float32)
        for piece in self._pieces:
            self._gather_piece(out[piece.receivers], piece, bounce)
        out *= np.float32(1.0 / self._samples)
        return out.reshape(len(out), *transport.shape[1:])

    def _stand_ins(self, returned_light: Float32) -> npt.NDArray[np.int32]:
        """(3 T,) sources; see `_Bounce`."""
        stand_ins = self.sources.corner.copy()

        def work(part: slice) -> None:
            """Mark the triangles among some whose corners return light that differs by `_fine` or more."""
            a, b, c = (returned_light.take(corner, axis=0) for corner in self.sources.corner[part].T)
            highest = np.maximum(a, b)
            np.maximum(highest, c, out=highest)
            np.minimum(a, b, out=a)
            np.minimum(a, c, out=a)
            highest -= a
            stand_ins[part][highest.max(axis=1) >= self._fine] = self.sources.black

        self._workers.run(len(stand_ins), _TRIANGLES_AT_A_TIME, work)
        return stand_ins.reshape(-1)

    def _gather_piece(self, out: Float32, piece: _Piece, bounce: _Bounce) -> None:
        def work(part: slice) -> Work | None:
            """Fill the rows of some receivers; what was counted before is no work again."""
            out[part] = self._gathered(piece, part, bounce)
            if piece.receivers.start >= self._counted:
                return None
            return Work(bounces=int(BOUNCE_IN_RAYS * bounce.rays * (part.stop - part.start)))

        self._workers.run(len(out), self._chunk, work)

    def _gathered(self, piece: _Piece, part: slice, bounce: _Bounce) -> Float32:
        """What some receivers of a piece get, times the samples."""
        starts = piece.hits.starts[part.start : part.stop + 1]
        packed = piece.hits.packed[starts[0] : starts[-1]]
        starts = starts - starts[0]
        colours = piece.pattern_colours[piece.pattern_starts[part.start] : piece.pattern_starts[part.stop]]
        tint = self._tint(packed, colours) if len(colours) else None
        if bounce.thin is None or not len(packed):
            return self._summed(packed, tint, starts, bounce)
        at, thin_starts = _thinned(packed, starts, bounce.thin)
        out = self._summed(packed[at], None if tint is None else tint[at], thin_starts, bounce)
        out *= (np.diff(starts) / np.maximum(np.diff(thin_starts), 1)).astype(np.float32)[:, None]
        return out

    def _summed(self, packed: Packed, tint: Float32 | None, starts: Int64, bounce: _Bounce) -> Float32:
        """(n, C * 9) sums over the hits of each receiver."""
        returned_light = bounce.returned_light
        source = bounce.stand_ins.take(corners(packed)).astype(np.intp)
        out = _run_sums(returned_light, source, starts, tint, max(1, _RAYS_IN_CACHE // bounce.rays))
        coarse = np.flatnonzero(source == self.sources.black)
        if len(coarse):
            returned = self._interpolated(returned_light, packed[coarse])
            _tinted(returned, None if tint is None else tint[coarse])
            coarse_starts = np.searchsorted(coarse, starts)
            filled = np.flatnonzero(np.diff(coarse_starts))
            out[filled] += np.add.reduceat(returned, coarse_starts[filled], axis=0)
        return out

    def _interpolated(self, returned_light: Float32, packed: Packed) -> Float32:
        """(H, C * 9) what hits return, between all three corners of their triangles."""
        u, v = barycentrics(packed)
        shares = np.stack([ONE - u - v, u, v], axis=1).astype(np.float32) / np.float32(ONE)
        sources = self.sources.corner.take(corners(packed) // 3, axis=0)
        returned = np.empty((len(packed), returned_light.shape[1]), dtype=np.float32)
        for first in range(0, len(packed), _COARSE_AT_A_TIME):
            part = slice(first, first + _COARSE_AT_A_TIME)
            np.einsum("hk,hkc->hc", shares[part], returned_light.take(sources[part], axis=0), out=returned[part])
        return returned

    def _tint(self, packed: Packed, colours: npt.NDArray[np.uint16]) -> Float32:
        """(H, C) the colours that patterns give to hits on them; white elsewhere, where the sources are coloured."""
        tint = np.ones((len(packed), self.channels), dtype=np.float32)
        tint[self._is_patterned.take(corners(packed) // 3)] = colours / np.float32(ONE)
        return tint

    def _looked_up(self, store: HitStore, albedo: Albedo) -> Iterator[_Piece]:
        stop, spill = 0, Spill(store.spill.left)
        for hits in store.pieces:
            start, stop = stop, stop + len(hits)
            pattern_starts, colours = self._pattern_colours(hits, albedo)
            yield _Piece(slice(start, stop), hits, pattern_starts, spill.keep(colours))

    def _pattern_colours(self, hits: PackedHits, albedo: Albedo) -> tuple[Int64, npt.NDArray[np.uint16]]:
        """Where each receiver's hits on patterned triangles start, (N + 1,), and their colours in fixed point."""
        starts = np.zeros(len(hits) + 1, dtype=np.int64)
        if not albedo.patterns or not len(hits):
            return starts, np.empty((0, self.channels), dtype=np.uint16)
        chunks: dict[int, npt.NDArray[np.uint16]] = {}

        def work(part: slice) -> None:
            """Look up the colours of the patterned hits of some receivers, and count these hits."""
            here = hits.starts[part.start : part.stop + 1]
            packed = hits.packed[here[0] : here[-1]]
            triangle = corners(packed) // 3
            patterned = self._is_patterned.take(triangle)
            count = np.concatenate([[0], np.cumsum(patterned)])
            starts[part.start + 1 : part.stop + 1] = np.diff(count[here - here[0]])
            u_here, v_here = (np.divide(x, ONE, dtype=np.float32) for x in barycentrics(packed[patterned]))
            colour = albedo.at(triangle[patterned], u_here, v_here)
            chunks[part.start] = np.rint(colour[:, : self.channels] * np.float32(ONE)).astype(np.uint16)

        self._workers.run(len(hits), self._chunk, work)
        return np.cumsum(starts), np.concatenate([chunks[first] for first in sorted(chunks)])


def _run_sums(returned_light: Float32, source: Int64, starts: Int64, tint: Float32 | None, block: int) -> Float32:
    """(n, C * 9) sums over what runs of sources return.

    Args:
        returned_light: (M, C * 9) what the sources return.
        source: (H,) which.
        starts: (n + 1,) where the run of each receiver starts.
        tint: (H, C) what the channels are multiplied by; 1 if None.
        block: receivers that are summed at a time, which changes no result.
    """
    filled = np.flatnonzero(np.diff(starts))  # `reduceat` cannot sum empty runs
    begins = starts[filled]
    bounds = np.append(begins[::block], len(source))
    begins -= np.repeat(bounds[:-1], block)[: len(begins)]
    rows = np.empty((np.diff(bounds).max(initial=0), returned_light.shape[1]), dtype=np.float32)
    sums = np.empty((len(filled), returned_light.shape[1]), dtype=np.float32)
    for first, (begin, end) in zip(range(0, len(filled), block), pairwise(bounds.tolist()), strict=True):
        returned = rows[: end - begin]
        returned_light.take(source[begin:end], axis=0, out=returned, mode="clip")
        _tinted(returned, None if tint is None else tint[begin:end])
        np.add.reduceat(returned, begins[first : first + block], axis=0, out=sums[first : first + block])
    out = np.zeros((len(starts) - 1, returned_light.shape[1]), dtype=np.float32)
    out[filled] = sums
    return out


def _thinned(packed: Packed, starts: Int64, number: int) -> tuple[Int64, Int64]:
    """Where the hits that a thin bounce reads lie, (h,), and where those of each run start, (n + 1,).

    About every fourth, evenly spaced, and one at least. The first is random, made of the first hit of the run, and moves
    on by the golden ratio with the number of the bounce. Measured: half the noise of a random choice of as many.
    """
    count = np.diff(starts)
    taken = -(-count // THIN)
    thin_starts = np.concatenate([[0], np.cumsum(taken)])
    random = (packed.take(starts[:-1], mode="clip") & _STEADY_MASK) + np.uint64(number)
    first = (random * np.uint64(0x9E3779B97F4A7C15) >> np.uint64(48)).astype(np.int64)
    place = np.arange(thin_starts[-1]) - np.repeat(thin_starts[:-1], taken)
    at = ((place << 16) + np.repeat(first, taken)) * np.repeat(count, taken) // np.repeat(taken << 16, taken)
    return at + np.repeat(starts[:-1], taken), thin_starts


def _tinted(returned: Float32, tint: Float32 | None) -> None:
    """Multiply (H, C * 9) in place by (H, C), or by nothing."""
    if tint is not None:
        by_channel = returned.reshape(*tint.shape, -1)
        by_channel *= tint[:, :, None]
