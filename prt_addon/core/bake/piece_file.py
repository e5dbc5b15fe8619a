# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes a piece of a bake to a file, and reads it back with all that the file claims checked.

The file is an archive of arrays as `numpy.savez` writes them, uncompressed. Sizes, types and shapes are looked at before
anything is read, so that no file takes more memory than it is large.
"""

from __future__ import annotations

import json
import os
import stat
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ..files import write_arrays, written
from ..sphere import sh
from ..transport.hits import PackedHits, corners

_BROKEN = (
    OSError,
    ValueError,
    TypeError,
    KeyError,
    EOFError,
    RecursionError,  # JSON within JSON
    NotImplementedError,  # compressed in an unknown way
    RuntimeError,  # encrypted
    zipfile.BadZipFile,
    zlib.error,
)
_LONGEST_HEADER = 1 << 16
_NAMES = {"header.npy", "direct.npy", "starts.npy", "packed.npy"}
_HITS = {"starts.npy", "packed.npy"}
_COEFFICIENTS = sh.coefficient_count(sh.ORDER)


@dataclass(frozen=True)
class PieceFile:
    """A file whose header was read and is consistent: which receivers it holds, and of which bake.

    Attributes:
        start: its first receiver, counted through all islands.
        stop: the one after its last.
        shard: index and count of the shard it belongs to; None if it is a checkpoint's.
        header: all that it says.
    """

    path: Path
    start: int
    stop: int
    shard: tuple[int, int] | None
    header: dict[str, Any]


def write_piece(path: Path, header: dict[str, Any], direct: npt.NDArray[np.float32], hits: PackedHits | None) -> None:
    """Write a piece to a file, whole or not at all.

    Raises:
        OSError: if it cannot be written.
    """
    arrays: dict[str, npt.NDArray[Any]] = {"header": np.array(json.dumps(header)), "direct": direct}
    if hits:
        arrays |= {"starts": hits.starts, "packed": hits.packed}
    with written(path) as (temporary,):
        write_arrays(temporary, arrays)


def read_header(path: Path) -> PieceFile | None:
    """Read the header of a file; None if it is no piece of ours, or damaged."""
    try:
        with _opened(path) as archive:
            return _header(path, archive)
    except _BROKEN:
        return None


def read_piece(
    file: PieceFile, samples: int, bounces: bool, corner_count: int
) -> tuple[npt.NDArray[np.float32], PackedHits | None] | None:
    """Read the direct transport (n, 9) and the hits of a piece; None if it is damaged, or not what its header says.

    Args:
        file: which, as its header has it.
        samples: rays per receiver.
        bounces: whether it has to have hits.
        corner_count: corners of all triangles that hits may lie on.
    """
    try:
        with _opened(file.path) as archive:
            if _header(file.path, archive) != file or (archive.namelist().count("packed.npy") > 0) != bounces:
                return None
            count = file.stop - file.start
            direct = _array(archive, "direct.npy", "<f4", (count, _COEFFICIENTS))
            if not np.isfinite(direct).all():
                return None
            if not bounces:
                return direct, None
            starts = _array(archive, "starts.npy", "<i8", (count + 1,))
            if starts[0] != 0 or (np.diff(starts) < 0).any() or (np.diff(starts) > samples).any():
                return None
            packed = _array(archive, "packed.npy", "<u8", (int(starts[-1]),))
            if len(packed) and int(corners(packed).max()) >= corner_count:
                return None
            return direct, PackedHits(samples, starts, packed)
    except _BROKEN:
        return None


@contextmanager
def _opened(path: Path) -> Iterator[zipfile.ZipFile]:
    """A regular file whose parts are ours, uncompressed, and not larger than the file itself."""
    if not stat.S_ISREG(path.stat().st_mode):  # a pipe would be waited for
        raise ValueError("no regular file")
    with path.open("rb") as opened, zipfile.ZipFile(opened) as archive:
        size, names = os.fstat(opened.fileno()).st_size, archive.namelist()
        parts = archive.infolist()
        plain = all(part.compress_type == zipfile.ZIP_STORED and not part.flag_bits & 1 for part in parts)
        if not plain or sum(part.file_size for part in parts) > size or len(set(names)) != len(names):
            raise ValueError("not as we write them")
        if not {"header.npy", "direct.npy"} <= set(names) <= _NAMES or len(_HITS & set(names)) == 1:
            raise ValueError("other parts than ours")
        yield archive


def _header(path: Path, archive: zipfile.ZipFile) -> PieceFile:
    if archive.getinfo("header.npy").file_size > _LONGEST_HEADER:
        raise ValueError("too long a header")
    with archive.open("header.npy") as entry:
        header = json.loads(np.lib.format.read_array(entry, allow_pickle=False).item())  # type: ignore[no-untyped-call]
    start, stop, shard = header["start"], header["stop"], header.get("shard")
    if not (_whole(start) and _whole(stop) and 0 <= start < stop):
        raise ValueError("no receivers")
    if shard is not None and not (len(shard) == 2 and all(map(_whole, shard)) and 0 <= shard[0] < shard[1]):
        raise ValueError("no shard")
    return PieceFile(path, start, stop, tuple(shard) if shard else None, header)


def _whole(value: object) -> bool:
    return isinstance(value, int) and not isinstance(value, bool)


def _array(archive: zipfile.ZipFile, name: str, kind: str, shape: tuple[int, ...]) -> npt.NDArray[Any]:
    """An array of a type and shape; whatever else it says it is, is not read."""
    with archive.open(name) as entry:
        version = np.lib.format.read_magic(entry)  # type: ignore[no-untyped-call]
        if version != (1, 0):
            raise ValueError("another format")
        found, _, dtype = np.lib.format.read_array_header_1_0(entry)  # type: ignore[no-untyped-call]
        if found != shape or dtype.str != kind:
            raise ValueError(f"{name} is {dtype.str} {found} instead of {kind} {shape}")
    with archive.open(name) as entry:
        return np.lib.format.read_array(entry, allow_pickle=False)  # type: ignore[no-untyped-call]
