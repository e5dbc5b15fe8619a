# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes files whole or not at all, digests data, and keeps arrays in temporary files where memory has no room."""

from __future__ import annotations

import hashlib
import os
import socket
import tempfile
import time
import zipfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, TypeVar, cast

import numpy as np
import numpy.typing as npt

from .errors import NoRoom

Array = TypeVar("Array", bound=npt.NDArray[Any])

_DIGEST_BYTES = 16


def digest(*parts: bytes | npt.NDArray[Any]) -> bytes:
    """Digest several things, each with its type and size, so that no two lists of things look alike."""
    whole = hashlib.blake2b(digest_size=_DIGEST_BYTES)
    for part in parts:
        array = np.frombuffer(part, dtype=np.uint8) if isinstance(part, bytes) else np.ascontiguousarray(part)
        whole.update(f"{array.dtype.str}{array.shape}".encode())
        whole.update(array.reshape(-1).data)
    return whole.digest()


_TEMPORARY = ".tmp"
_FORGOTTEN = 86400.0  # seconds after which a temporary file of another machine is taken for left behind


@contextmanager
def written(*paths: Path) -> Iterator[list[Path]]:
    """Write files that are there together and whole, or as they were before, whatever happens meanwhile.

    Temporary files lie beside them until all are complete. Those that killed processes have left there are removed.

    Args:
        paths: the files, replaced if they are there; their folders are made.

    Yields:
        A path for each, of an empty file, to write to instead.

    Raises:
        OSError: with the name of the file that cannot be written.
    """
    temporary = [_beside(path) for path in paths]
    try:
        for path, other in zip(paths, temporary, strict=True):
            path.parent.mkdir(parents=True, exist_ok=True)
            _sweep(path.parent)
            os.close(os.open(other, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))  # as open to others as any new file
        yield temporary
        for other in temporary:
            _flush(other)
        for path, other in zip(paths, temporary, strict=True):
            other.replace(path)
    except OSError as error:
        raise _named(error, paths) from error
    finally:
        for other in temporary:
            with suppress(OSError):
                other.unlink()


def write_arrays(path: Path, arrays: Mapping[str, npt.NDArray[Any]]) -> None:
    """Write arrays as `numpy.savez` does, without its second error on a full disk, which nothing can catch.

    Raises:
        OSError: if the file cannot be written.
    """
    archive = zipfile.ZipFile(path, "w")
    try:
        for name, array in arrays.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as entry:
                np.lib.format.write_array(entry, np.asanyarray(array), allow_pickle=False)  # type: ignore[no-untyped-call]
        archive.close()
    except BaseException:
        file, archive.fp = archive.fp, None  # nothing is left for it to do when it goes
        with suppress(OSError):
            if file:
                file.close()
        raise


def _beside(path: Path) -> Path:
    """A name that says whose the temporary file is."""
    return path.with_name(f".{path.name}~{socket.gethostname()}~{os.getpid()}{_TEMPORARY}")


def _sweep(folder: Path) -> None:
    """Remove what processes have left that are no more: on this machine they can be looked for, on others time decides."""
    for path in folder.glob(f".*~*~*{_TEMPORARY}"):
        host, process = path.name.removesuffix(_TEMPORARY).split("~")[-2:]
        with suppress(OSError):
            if host == socket.gethostname():
                gone = not process.isdecimal() or not _runs(int(process))
            else:
                gone = time.time() - path.stat().st_mtime > _FORGOTTEN
            if gone:
                path.unlink()


def _runs(process: int) -> bool:
    if os.name == "nt":  # where signal 0 would end it
        return True
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except OSError:  # somebody else's
        return True
    return True


def _flush(path: Path) -> None:
    with path.open("r+b") as file:
        os.fsync(file.fileno())


def _named(error: OSError, paths: tuple[Path, ...]) -> OSError:
    """The same error with the user's name of the file."""
    name = str(error.filename or "")
    if name and not name.endswith(_TEMPORARY):
        return error
    meant = next((path for path in paths if name == str(_beside(path))), paths[0])
    return OSError(error.errno, error.strerror or str(error), str(meant))


class Spill:
    """Keeps arrays: in memory up to a budget, beyond it in temporary files that are mapped into memory.

    The files have no name where the system allows it, and are gone with their arrays, however the process ends. They lie
    in Python's temporary folder (`TMPDIR` moves it); nothing is gained if that is itself in memory.

    left: bytes that may still be kept in memory.
    """

    def __init__(self, budget: int) -> None:
        """
        Args:
            budget: bytes that may stay in memory.
        """
        self.left = budget

    def keep(self, array: Array) -> Array:
        """Keep an array's numbers, in memory if they fit. What already lies in a file stays there and costs nothing.

        Raises:
            NoRoom: if the temporary folder is full, or cannot be written to.
        """
        if in_file(array):
            return array
        if array.nbytes <= self.left:
            self.left -= array.nbytes
            return array
        try:
            return _mapped(array)
        except OSError as error:
            raise NoRoom(
                f"The bake needs more memory than it may take, and its temporary folder cannot hold the rest ({error}): "
                "free some space there, let TMPDIR name another folder, or bake with fewer samples."
            ) from error


def in_file(array: npt.NDArray[Any]) -> bool:
    """Whether an array lies in a file and not in memory."""
    return isinstance(array, np.memmap)


def memory_of(*arrays: npt.NDArray[Any]) -> int:
    """The bytes of memory that arrays occupy."""
    return sum(array.nbytes for array in arrays if not in_file(array))


def _mapped(array: Array) -> Array:
    with tempfile.TemporaryFile(prefix="prt-") as file:
        file.write(np.ascontiguousarray(array).reshape(-1).view(np.uint8).data)
        file.flush()
        return cast(Array, np.memmap(file, dtype=array.dtype, mode="r", shape=array.shape))
