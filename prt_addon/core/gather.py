# SPDX-License-Identifier: GPL-3.0-or-later
"""One bounce of light as a sparse matrix: what each receiver gets from the surfaces its rays hit.

`(G T)(x) = 1/S sum over hits h of x: albedo(h) sum over corners k: b_k(h) T(receiver at corner k)`. Rays are cosine-weighted,
so the weight is albedo / S with no further cosine, 1/pi or 4pi (Sloan, Kautz & Snyder 2002, section 4.2, with their
integral over the hemisphere sampled by its own cosine). Every row sums to at most the largest albedo.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from . import sh
from .albedo import Albedo
from .hits import ONE, HitStore, KeptHits, unpacked
from .parallel import ALL_CORES, Workers
from .spill import Spill, memory_of

Float32 = npt.NDArray[np.float32]
Int64 = npt.NDArray[np.int64]

_COEFFICIENTS = sh.coefficient_count(sh.ORDER)
_HITS_AT_A_TIME = 1 << 14  # measured: fewer pay for the calls, more leave the cache
_BLOCK = 8  # hits summed by one call of the inner loop; rows are padded to a multiple of it


@dataclass(frozen=True)
class Sources:
    """The distinct (receiver, colour) pairs at the corners of triangles: what a bounce reads from.

    Light is tinted here, once per pair and not once per hit, wherever a triangle has one colour.

    receiver: (M,) int64.
    tint: (M, C) float32; black where the corner shows no receiver.
    corner: (T, 3) int64, the source at each corner.
    """

    receiver: Int64
    tint: Float32
    corner: Int64

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
        return cls(np.maximum(receiver, 0), tint, inverse.reshape(-1, 3))

    def lit(self, transport: Float32) -> Float32:
        """(M, C * 9) what each source returns of (N, C, 9)."""
        lit: Float32 = transport[self.receiver] * self.tint[:, :, None]
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
    """`gather(T)` is G T. The weights are made from the kept hits as they are needed: eight bytes a hit, not sixteen."""

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
        self._chunk = max(1, int(_HITS_AT_A_TIME * len(store) / max(1, store.count)))
        self._is_patterned = albedo.is_patterned
        self._pieces = list(self._looked_up(store, albedo))

    @property
    def nbytes(self) -> int:
        """Memory that grows with the rays: the kept hits and the colours looked up for them."""
        return sum(piece.hits.nbytes + memory_of(piece.pattern_starts, piece.pattern_colours) for piece in self._pieces)

    def __call__(self, transport: Float32) -> Float32:
        """One bounce: (M, C, 9) float32 from (N, C, 9)."""
        lit = self.sources.lit(transport)
        out = np.zeros((self._receivers, lit.shape[1]), dtype=np.float32)
        for piece in self._pieces:
            self._gather_piece(out[piece.receivers], piece, lit)
        out *= np.float32(1.0 / (ONE * self._samples))
        return out.reshape(len(out), *transport.shape[1:])

    def _gather_piece(self, out: Float32, piece: _Piece, lit: Float32) -> None:
        def work(part: slice) -> int:
            self._gather_into(out[part], piece, part, lit)
            return part.stop - part.start

        self._workers.run(len(out), self._chunk, work)

    def _gather_into(self, out: Float32, piece: _Piece, part: slice, lit: Float32) -> None:
        """Add up what some receivers of a piece get, times `ONE` and the samples."""
        starts = piece.hits.starts[part.start : part.stop + 1]
        triangle, u, v = unpacked(piece.hits.packed[starts[0] : starts[-1]])
        if not len(triangle):
            return
        colours = piece.pattern_colours[piece.pattern_starts[part.start] : piece.pattern_starts[part.stop]]
        patterned = self._is_patterned[triangle] if len(colours) else None
        first, entry_starts = _entries(triangle, starts - starts[0], patterned)
        entry, block_starts = _padded(entry_starts)
        corners = np.append(triangle[first], 0).take(entry)
        source = self.sources.corner.take(corners, axis=0, mode="clip")
        weights = _summed_weights(u, v, first).take(entry, axis=0, mode="clip")
        rows = lit.take(source, axis=0, mode="clip").reshape(-1, 3 * _BLOCK, lit.shape[1])
        if patterned is None:
            sums = np.einsum("nj,njc->nc", weights.reshape(rows.shape[:2]), rows)
        else:
            tint = np.ones((len(first) + 1, self.channels), dtype=np.float32)
            tint[:-1][patterned[first]] = colours / np.float32(ONE)
            sums = _tinted_sums(weights, tint.take(entry, axis=0), rows)
        filled = np.flatnonzero(np.diff(block_starts))
        out[filled] = np.add.reduceat(sums, block_starts[filled], axis=0)

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
            patterned = self._is_patterned[triangle]
            count = np.concatenate([[0], np.cumsum(patterned)])
            starts[part.start + 1 : part.stop + 1] = np.diff(count[here - here[0]])
            u_here, v_here = (np.divide(x[patterned], ONE, dtype=np.float32) for x in (u, v))
            colour = albedo.at(triangle[patterned], u_here, v_here)[:, : self.channels]
            chunks[part.start] = np.rint(colour * np.float32(ONE)).astype(np.uint16)
            return 0

        self._workers.run(len(hits), 8 * self._chunk, work)
        return np.cumsum(starts), np.concatenate([chunks[first] for first in sorted(chunks)])


def _entries(triangle: Int64, starts: Int64, patterned: npt.NDArray[np.bool_] | None) -> tuple[Int64, Int64]:
    """Join a receiver's hits on one triangle, unless a pattern gives each its own colour.

    Returns:
        The first hit of each entry (E,), and where each receiver's entries start (n + 1,).
    """
    is_first = np.empty(len(triangle) + 1, dtype=np.bool_)
    np.not_equal(triangle[1:], triangle[:-1], out=is_first[1:-1])
    is_first[starts] = True  # the last one stands past the end
    if patterned is not None:
        is_first[:-1] |= patterned
    first = np.flatnonzero(is_first[:-1])
    return first, np.searchsorted(first, starts)


def _summed_weights(u: Int64, v: Int64, first: Int64) -> Float32:
    """(E + 1, 3) barycentrics of the corners, summed over the hits of each entry, times `ONE`; the last row is zero."""
    hits = len(u)
    both = np.add.reduceat((u << 32) | v, first)  # one pass for two sums
    u, v = both >> 32, both & 0xFFFFFFFF
    weights = np.zeros((len(first) + 1, 3), dtype=np.float32)
    weights[:-1, 0] = ONE * np.diff(first, append=hits) - u - v
    weights[:-1, 1] = u
    weights[:-1, 2] = v
    return weights


def _padded(entry_starts: Int64) -> tuple[Int64, Int64]:
    """Lay entries out in whole blocks per receiver, so that most of a sum is taken over rows of one length.

    Returns:
        The entry in each slot, E in the slots left over; and where each receiver's blocks start (n + 1,).
    """
    count = np.diff(entry_starts)
    block_starts = np.concatenate([[0], np.cumsum(-(-count // _BLOCK))])
    entry = np.full(block_starts[-1] * _BLOCK, entry_starts[-1])
    shift = np.repeat(block_starts[:-1] * _BLOCK - entry_starts[:-1], count)
    entry[np.arange(len(shift)) + shift] = np.arange(len(shift))
    return entry, block_starts


def _tinted_sums(weights: Float32, tint: Float32, rows: Float32) -> Float32:
    """(n, C * 9) sums of rows (n, 3 * _BLOCK, C * 9), weighted, each channel by its tint (slots, C) as well."""
    sums = np.empty((len(rows), rows.shape[2]), dtype=np.float32)
    for channel, shade in enumerate(tint.T):
        columns = slice(channel * _COEFFICIENTS, (channel + 1) * _COEFFICIENTS)
        tinted = (weights * shade[:, None]).reshape(rows.shape[:2])
        sums[:, columns] = np.einsum("nj,njc->nc", tinted, rows[:, :, columns])
    return sums


def _row_ids(rows: Float32) -> Int64:
    """(T,) a number for each row (T, C), the same for equal rows."""
    ids = np.zeros(len(rows), dtype=np.int64)
    for column in rows.T:
        values = np.unique(column, return_inverse=True)[1]
        ids = np.unique(ids * (values.max() + 1) + values, return_inverse=True)[1]
    return ids
