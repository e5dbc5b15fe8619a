# SPDX-License-Identifier: GPL-3.0-or-later
"""Stores traced pieces of a bake in a folder: a bake that was stopped resumes from them, and shards are merged from
them.

A piece is what the rays of consecutive receivers found. That is a function of the scene, the samples, the seed and the
receivers alone, so that pieces join to the same bits wherever they are cut. So do those of several machines with the same
kind of processor and the same versions; others may round differently in the last bit. Each lies in a file of its
own, written under another name and then renamed: a file is there as a whole or not at all, and whoever is killed while
writing it may do it again.

Receivers are numbered through the whole bake, island by island (see `problem`).
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from ..arrays import Float32
from ..errors import ShardError
from ..files import digest
from ..problem import BOUNCING, TraceKey
from ..transport.hits import PackedHits
from .piece_file import PieceFile, read_header, read_piece, write_piece

_SUFFIX = ".npz"
_MADE_WITH = "numpy"  # in the header: the version of what may round otherwise
_ANY_CORNER = 1 << 32  # as many as a hit can name


@dataclass(frozen=True)
class Shard:
    """One of `count` equal shares of a bake; they are numbered from 0."""

    index: int
    count: int

    def __post_init__(self) -> None:
        if not 0 <= self.index < self.count:
            raise ShardError(
                f"There is no shard {self.index} of {self.count}: they are numbered 0 to {self.count - 1}."
            )

    def span(self, receivers: int) -> slice:
        """The receivers of this shard, of so many in all."""
        return slice(receivers * self.index // self.count, receivers * (self.index + 1) // self.count)


@dataclass(frozen=True)
class Piece:
    """What the rays of some receivers found.

    Attributes:
        receivers: which.
        direct: (n, 9) their transport without bounces.
        hits: what light may bounce off; None in a bake without bounces.
        found: whether it lay in the folder.
    """

    receivers: slice
    direct: Float32
    hits: PackedHits | None
    found: bool = False


@dataclass(frozen=True)
class PieceFolder:
    """The pieces of one bake in a folder, which may hold others.

    Attributes:
        key: of all its pieces.
        shard: what is saved belongs to it.
        first: number of the receiver that callers count as 0.
    """

    folder: Path
    key: TraceKey
    shard: Shard | None = None
    first: int = 0

    def counted_from(self, first: int) -> PieceFolder:
        """The same folder for a caller that counts its receivers from `first`."""
        return replace(self, first=first)

    def cover(
        self, span: slice, size: int, trace: Callable[[slice], Piece], corner_count: int = _ANY_CORNER
    ) -> Iterator[Piece]:
        """Pieces that cover `span` in order: those in the folder, and between them what `trace` makes, which is saved.

        Args:
            span: of receivers, as the caller counts them (`counted_from`).
            size: of pieces that are traced, at most.
            trace: makes the piece of some receivers.
            corner_count: corners of all triangles that rays may hit.

        Raises:
            OSError: if the folder cannot be written.
        """
        done = span.start
        for file in sorted(self._usable(), key=lambda file: (file.start, -file.stop)):
            start, stop = file.start - self.first, file.stop - self.first
            piece = self._load(file, corner_count) if done <= start and stop <= span.stop else None
            if piece:
                yield from self._traced(slice(done, start), size, trace)
                yield piece
                done = stop
        yield from self._traced(slice(done, span.stop), size, trace)

    def check_complete(self) -> list[str]:
        """Check whether the folder holds all shards of this bake, once each, and nothing else.

        Returns:
            Sentences for the user: what is unusual about them.

        Raises:
            ShardError: if not; the message says what is wrong with which.
        """
        files = []
        for path in self._paths():
            file = read_header(path)
            different = self.key.differences(file.header) if file else ""
            if file is None or (not different and self._load(file, _ANY_CORNER) is None):
                raise ShardError(f"'{path}' is damaged: delete it, bake its shard again, then merge.")
            if different or not file.shard:
                raise ShardError(
                    f"'{path}' does not belong to this bake ({different or 'it is of no shard'}): merge with the scene and "
                    "settings of the shards, or delete the file and bake its shard again."
                )
            files.append(file)
        if not files:
            raise ShardError(f"There are no shards in '{self.folder}': bake them with prt.bake_shard first.")
        files.sort(key=lambda file: file.start)
        self._check_once(files)
        self._check_missing(files)
        made_with = sorted({str(file.header.get(_MADE_WITH)) for file in files if file.header.get(_MADE_WITH)})
        if len(made_with) < 2:
            return []
        return [
            f"The shards were made with different versions of NumPy ({', '.join(made_with)}): their transport may differ in "
            "its last bits from a bake on one machine."
        ]

    def _check_once(self, files: Sequence[PieceFile]) -> None:
        counts = sorted({file.shard[1] for file in files if file.shard})
        if len(counts) > 1:
            raise ShardError(
                f"'{self.folder}' mixes shards of bakes in {' and '.join(map(str, counts))} shards: delete those of all "
                "but one, then merge."
            )
        for one, other in pairwise(files):
            if other.start < one.stop:
                raise ShardError(f"'{one.path}' and '{other.path}' hold the same receivers: delete one, then merge.")

    def _check_missing(self, files: Sequence[PieceFile]) -> None:
        assert files[0].shard, "checked before"
        count = files[0].shard[1]
        ends = [0, *(end for file in files for end in (file.start, file.stop)), self.key.receivers]
        gaps = [(start, stop) for start, stop in zip(ends[::2], ends[1::2], strict=True) if start < stop]
        spans = [Shard(index, count).span(self.key.receivers) for index in range(count)]
        missing = [
            index
            for index, span in enumerate(spans)
            if any(start < span.stop and span.start < stop for start, stop in gaps)
        ]
        if missing:
            names = ", ".join(map(str, missing))
            raise ShardError(
                f"Of {count} shards, these are missing or unfinished: {names}. Bake each with prt.bake_shard("
                f"index=..., count={count}, directory=...), then merge."
            )

    def _traced(self, span: slice, size: int, trace: Callable[[slice], Piece]) -> Iterator[Piece]:
        for part in cut(span, size):
            piece = trace(part)
            self._save(piece)
            yield piece

    def _paths(self) -> list[Path]:
        return sorted(self.folder.glob(f"*{_SUFFIX}"))

    def _usable(self) -> Iterator[PieceFile]:
        for path in self._paths():
            file = read_header(path)
            if file and file.stop <= self.key.receivers and not self.key.differences(file.header):
                yield file

    def _load(self, file: PieceFile, corner_count: int) -> Piece | None:
        """None if it is damaged: then it is traced again."""
        found = read_piece(file, self.key.samples, self.key.mode in BOUNCING, corner_count)
        if found is None or file.stop > self.key.receivers:
            return None
        direct, hits = found
        return Piece(slice(file.start - self.first, file.stop - self.first), direct, hits, found=True)

    def _save(self, piece: Piece) -> None:
        start, stop = piece.receivers.start + self.first, piece.receivers.stop + self.first
        shard = self.shard and (self.shard.index, self.shard.count)
        header = {**asdict(self.key), "start": start, "stop": stop, "shard": shard, _MADE_WITH: np.__version__}
        belongs = f"shard-{self.shard.index}-of-{self.shard.count}" if self.shard else "piece"
        name = digest(json.dumps(asdict(self.key)).encode()).hex()[:8]
        path = self.folder / f"{belongs}-{name}-{start}-{stop}{_SUFFIX}"
        write_piece(path, header, piece.direct, piece.hits)


def cut(span: slice, size: int) -> Iterator[slice]:
    """Cut a span into pieces of some size; the last may be smaller."""
    for start in range(span.start, span.stop, size):
        yield slice(start, min(start + size, span.stop))
