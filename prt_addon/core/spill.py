# SPDX-License-Identifier: GPL-3.0-or-later
"""Arrays that stay in memory up to a budget: beyond it, work slows down to the disk's speed instead of dying."""

from __future__ import annotations

import tempfile
from typing import Any, TypeVar, cast

import numpy as np
import numpy.typing as npt

from .errors import NoRoom

Array = TypeVar("Array", bound=npt.NDArray[Any])


class Spill:
    """Keeps arrays, those past the budget in temporary files that are mapped into memory.

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
        """The same numbers, in memory if they fit. What already lies in a file stays there and costs nothing.

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
    """Bytes of memory that arrays occupy."""
    return sum(array.nbytes for array in arrays if not in_file(array))


def _mapped(array: Array) -> Array:
    with tempfile.TemporaryFile(prefix="prt-") as file:
        file.write(np.ascontiguousarray(array).reshape(-1).view(np.uint8).data)
        file.flush()
        return cast(Array, np.memmap(file, dtype=array.dtype, mode="r", shape=array.shape))
