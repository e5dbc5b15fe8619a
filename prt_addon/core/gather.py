# SPDX-License-Identifier: GPL-3.0-or-later
"""One bounce of light as a sparse matrix: what each receiver gets from the surfaces its rays hit.

`(G T)(x) = 1/S sum over hits h of x: albedo(h) sum over corners k: b_k(h) T(receiver at corner k)`. Rays are cosine-weighted,
so the weight is albedo / S with no further cosine, 1/pi or 4pi (Sloan, Kautz & Snyder 2002, section 5, with their
integral over the hemisphere sampled by its own cosine). Every row sums to at most the largest albedo.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from .albedo import Albedo
from .hits import ONE, HitStore, KeptHits, unpacked
from .parallel import ALL_CORES, Workers
from .spill import Spill, memory_of

Float32 = npt.NDArray[np.float32]
Int64 = npt.NDArray[np.int64]
UInt32 = npt.NDArray[np.uint32]
Bools = npt.NDArray[np.bool_]

_RECEIVERS_AT_A_TIME = 1 << 10  # measured: fewer pay for the calls, more leave the cache
_HITS_AT_A_TIME = 1 << 19  # bounds the memory of bakes with many samples
_PLACES_AT_A_TIME = 32
_COARSE_AT_A_TIME = 1 << 11
_FINE = 0.03  # at 256 rays; see `Gather`
_TRIANGLES_AT_A_TIME = 1 << 13
_DULL = 6  # bits of a barycentric that play no part in a random choice


@dataclass(frozen=True)
class Sources:
    """The distinct (receiver, colour) pairs at the corners of triangles: what a bounce reads from.

    Light is tinted here, once per pair and not once per hit, wherever a triangle has one colour.

    receiver: (M,) int64.
    tint: (M, C) float32; black where the corner shows no receiver.
    corner: (T, 3) int32, the source at each corner.
    """

    receiver: Int64
    tint: Float32
    corner: npt.NDArray[np.int32]

    @classmethod
    def of(cls, albedo: Albedo, corner_receiver: npt.NDArray[np.integer[Any]], channels: int) -> Sources:
        """Sources of all triangles; patterned ones are left white, since each hit brings its own colour."""
        colours = albedo.colours[:, :channels].copy()
        colours[albedo.is_patterned] = 1.0
        colour = _row_ids(colours)
        key = np.where(corner_receiver < 0, -1, corner_receiver * np.int64(colour.max() + 1) + colour[:, None])
        _, example, inverse = np.unique(key, return_index=True, return_inverse=True)
        receiver = corner_receiver.ravel()[example].astype(np.int64)
        tint = np.where(receiver[:, None] < 0, np.float32(0.0), colours[example // 3])
        return cls(np.maximum(receiver, 0), tint, inverse.reshape(-1, 3).astype(np.int32))

    @property
    def black(self) -> int:
        """The number of a source that returns nothing."""
        return len(self.receiver)

    def lit(self, transport: Float32) -> Float32:
        """(M + 1, C * 9) what each source returns of (N, C, 9)."""
        lit = np.zeros((len(self.receiver) + 1, *transport.shape[1:]), dtype=np.float32)
        np.multiply(transport[self.receiver], self.tint[:, :, None], out=lit[:-1])
        return lit.reshape(len(lit), -1)


@dataclass(frozen=True)
class _Piece:
    """Hits of consecutive receivers, and what was looked up for them once.

    receivers: which.
    hits: theirs.
    pattern_starts: (n + 1,) where each receiver's hits on patterned triangles start in `pattern_colours`.
    pattern_colours: (P, C) uint16, fixed point.
    """

    receivers: slice
    hits: KeptHits
    pattern_starts: Int64
    pattern_colours: npt.NDArray[np.uint16]


class Gather:
    """`gather(T)` is G T, made from the kept hits as it is needed: eight bytes a hit and nothing else.

    Most of the time goes into fetching what the three corners of each hit return. Where these differ by less than can
    be seen, one of them stands for all, each as often as the hits lie towards it: a random choice by the barycentrics,
    which returns the same light on average, and always the same energy. `_FINE` is the largest difference of a
    coefficient that counts as none. The error that this adds is a small part of the noise that the rays have; as that falls
    faster with their number than the error of a random choice, the limit falls with the fourth root.
    """

    def __init__(
        self,
        hits: HitStore | KeptHits,
        albedo: Albedo,
        corner_receiver: npt.NDArray[np.integer[Any]],
        workers: Workers = ALL_CORES,
    ) -> None:
        """
        Args:
            hits: of M receivers, which need not be those that light bounces off.
            albedo: of the triangles that were hit.
            corner_receiver: (T, 3) the receiver at each corner of a triangle; one at -1 returns no light.
            workers: who does it, now and in each bounce; told the receivers that a bounce has reached.
        """
        store = HitStore.of(hits) if isinstance(hits, KeptHits) else hits
        self.channels = 1 if albedo.is_grey else 3
        self.sources = Sources.of(albedo, corner_receiver, self.channels)
        self._workers, self._samples, self._receivers = workers, store.samples, len(store)
        self._chunk = min(_RECEIVERS_AT_A_TIME, max(1, _HITS_AT_A_TIME // store.samples))
        self._fine = _FINE * (256.0 / store.samples) ** 0.25
        self._is_patterned = albedo.is_patterned
        self._pieces = list(self._looked_up(store, albedo))

    @property
    def nbytes(self) -> int:
        """Memory that grows with the rays: the kept hits and the colours looked up for them."""
        return sum(piece.hits.nbytes + memory_of(piece.pattern_starts, piece.pattern_colours) for piece in self._pieces)

    def __call__(self, transport: Float32) -> Float32:
        """One bounce: (M, C, 9) float32 from (N, C, 9)."""
        lit = self.sources.lit(transport)
        is_fine = self._is_fine(lit)
        out = np.empty((self._receivers, lit.shape[1]), dtype=np.float32)
        for piece in self._pieces:
            self._gather_piece(out[piece.receivers], piece, lit, is_fine)
        out *= np.float32(1.0 / self._samples)
        return out.reshape(len(out), *transport.shape[1:])

    def _is_fine(self, lit: Float32) -> Bools:
        """(T,) whether the corners of each triangle return so much the same that any may stand for all."""
        is_fine = np.empty(len(self.sources.corner), dtype=np.bool_)

        def work(part: slice) -> int:
            a, b, c = (lit.take(corner, axis=0) for corner in self.sources.corner[part].T)
            highest = np.maximum(a, b)
            np.maximum(highest, c, out=highest)
            np.minimum(a, b, out=a)
            np.minimum(a, c, out=a)
            highest -= a
            is_fine[part] = highest.max(axis=1) < self._fine
            return 0

        self._workers.run(len(is_fine), _TRIANGLES_AT_A_TIME, work)
        return is_fine

    def _gather_piece(self, out: Float32, piece: _Piece, lit: Float32, is_fine: Bools) -> None:
        def work(part: slice) -> int:
            out[part] = self._gathered(piece, part, lit, is_fine)
            return part.stop - part.start

        self._workers.run(len(out), self._chunk, work)

    def _gathered(self, piece: _Piece, part: slice, lit: Float32, is_fine: Bools) -> Float32:
        """What some receivers of a piece get, times the samples."""
        starts = piece.hits.starts[part.start : part.stop + 1]
        triangle, u, v = unpacked(piece.hits.packed[starts[0] : starts[-1]])
        starts = starts - starts[0]
        colours = piece.pattern_colours[piece.pattern_starts[part.start] : piece.pattern_starts[part.stop]]
        tint = self._tint(triangle, colours) if len(colours) else None
        source = self._chosen(triangle, u, v)
        coarse = np.flatnonzero(~is_fine.take(triangle))
        if not len(coarse):
            return _sums(lit, source, starts, tint)
        source[coarse] = self.sources.black
        out = _sums(lit, source, starts, tint)
        returned = self._interpolated(lit, triangle[coarse], u[coarse], v[coarse])
        if tint is not None:
            by_channel = returned.reshape(len(coarse), self.channels, -1)
            by_channel *= tint[coarse, :, None]
        coarse_starts = np.searchsorted(coarse, starts)
        filled = np.flatnonzero(np.diff(coarse_starts))
        out[filled] += np.add.reduceat(returned, coarse_starts[filled], axis=0)
        return out

    def _interpolated(self, lit: Float32, triangle: UInt32, u: UInt32, v: UInt32) -> Float32:
        """(H, C * 9) what hits return, between all three corners."""
        returned = np.empty((len(triangle), lit.shape[1]), dtype=np.float32)
        shares = np.stack([ONE - u - v, u, v], axis=1).astype(np.float32) / np.float32(ONE)
        for first in range(0, len(triangle), _COARSE_AT_A_TIME):
            part = slice(first, first + _COARSE_AT_A_TIME)
            corners = lit.take(self.sources.corner.take(triangle[part], axis=0), axis=0)
            np.einsum("hk,hkc->hc", shares[part], corners, out=returned[part])
        return returned

    def _tint(self, triangle: UInt32, colours: npt.NDArray[np.uint16]) -> Float32:
        """(H, C) the colours that patterns give to hits on them; white elsewhere, where the sources are coloured."""
        tint = np.ones((len(triangle), self.channels), dtype=np.float32)
        tint[self._is_patterned.take(triangle)] = colours / np.float32(ONE)
        return tint

    def _chosen(self, triangle: UInt32, u: UInt32, v: UInt32) -> npt.NDArray[np.intp]:
        """(H,) a source for each hit: one of the corners, each with the probability of its barycentric.

        The random number is made of the barycentrics themselves: it depends on nothing but the hit, and on no more of
        their bits than it takes, so that the rounding of a ray seldom makes another choice.
        """
        number = (u >> _DULL << 16 | v >> _DULL) * np.uint32(0x9E3779B1) >> 16
        not_first = number < u + v
        corner = np.multiply(triangle, 3, dtype=np.intp)
        corner += not_first
        corner += not_first & (number >= u)
        return self.sources.corner.reshape(-1).take(corner).astype(np.intp)

    def _looked_up(self, store: HitStore, albedo: Albedo) -> Iterator[_Piece]:
        stop, spill = 0, Spill(store.spill.left)
        for hits in store.pieces:
            start, stop = stop, stop + len(hits)
            pattern_starts, colours = self._pattern_colours(hits, albedo)
            yield _Piece(slice(start, stop), hits, pattern_starts, spill.keep(colours))

    def _pattern_colours(self, hits: KeptHits, albedo: Albedo) -> tuple[Int64, npt.NDArray[np.uint16]]:
        """Where each receiver's hits on patterned triangles start, (N + 1,), and their colours in fixed point."""
        starts = np.zeros(len(hits) + 1, dtype=np.int64)
        if not albedo.patterns or not len(hits):
            return starts, np.empty((0, self.channels), dtype=np.uint16)
        chunks: dict[int, npt.NDArray[np.uint16]] = {}

        def work(part: slice) -> int:
            here = hits.starts[part.start : part.stop + 1]
            triangle, u, v = unpacked(hits.packed[here[0] : here[-1]])
            patterned = self._is_patterned.take(triangle)
            count = np.concatenate([[0], np.cumsum(patterned)])
            starts[part.start + 1 : part.stop + 1] = np.diff(count[here - here[0]])
            u_here, v_here = (np.divide(x[patterned], ONE, dtype=np.float32) for x in (u, v))
            colour = albedo.at(triangle[patterned], u_here, v_here)
            chunks[part.start] = np.rint(colour[:, : self.channels] * np.float32(ONE)).astype(np.uint16)
            return 0

        self._workers.run(len(hits), self._chunk, work)
        return np.cumsum(starts), np.concatenate([chunks[first] for first in sorted(chunks)])


def _sums(lit: Float32, source: npt.NDArray[np.intp], starts: Int64, weights: Float32 | None = None) -> Float32:
    """(n, C * 9) sums over runs of sources: the first of all runs, then the second of all that have one, and so on.

    So each receiver's sum is taken in the order of its own rays, whoever else is summed with it.

    Args:
        lit: (M, C * 9) what the sources return.
        source: (H,) which.
        starts: (n + 1,) where the run of each receiver starts.
        weights: (H, C) of the channels; 1 if None.
    """
    counts = np.diff(starts)
    longest_first = np.argsort(-counts, kind="stable")
    start = starts[:-1][longest_first]
    longer = len(counts) - np.cumsum(np.bincount(counts, minlength=1))  # runs that have a first, a second, ...
    sums = np.zeros((len(counts), lit.shape[1]), dtype=np.float32)
    rows = np.empty_like(sums)
    for first in range(0, len(longer) - 1, _PLACES_AT_A_TIME):
        places = np.arange(first, min(first + _PLACES_AT_A_TIME, len(longer) - 1))
        at = places[:, None] + start  # past the end of a run there are others' sources, which are left out below
        sources = source.take(at, mode="clip")
        for place, runs in enumerate(longer[places]):
            part = rows[:runs]
            lit.take(sources[place, :runs], axis=0, out=part, mode="clip")
            if weights is not None:
                by_channel = part.reshape(runs, weights.shape[1], -1)
                by_channel *= weights.take(at[place, :runs], axis=0)[:, :, None]
            sums[:runs] += part
    out = np.empty_like(sums)
    out[longest_first] = sums
    return out


def _row_ids(rows: Float32) -> Int64:
    """(T,) a number for each row (T, C), the same for equal rows."""
    ids = np.zeros(len(rows), dtype=np.int64)
    for column in rows.T:
        values = np.unique(column, return_inverse=True)[1]
        ids = np.unique(ids * (values.max() + 1) + values, return_inverse=True)[1]
    return ids
