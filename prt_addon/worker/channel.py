# SPDX-License-Identifier: GPL-3.0-or-later
"""Carries messages between Blender and the engine's process: pickles whose arrays travel beside them, a block at a
time.

An array is never copied into a pickle (protocol 5, PEP 574). Messages are cut into blocks, so that whoever must not wait can
send and receive for some milliseconds and go on later.
"""

from __future__ import annotations

import builtins
import io
import pickle
import struct
import time
from collections import deque
from collections.abc import Generator, Iterator
from multiprocessing.connection import Connection
from typing import Any

import numpy as np
import numpy.typing as npt

_BLOCK = 1 << 20
"""Bytes that are sent at once: a millisecond's work."""

_MOST = 1 << 40
"""Bytes of a message: more is a mistake."""

_PACKAGE = __name__.removesuffix(".worker.channel")
"""How `prt_addon` is called in this process: Blender puts the name of the extension before it."""

_OURS = ("core", "worker")
_NUMPY = ("numpy.core.multiarray", "numpy.core.numeric", "numpy._core.multiarray", "numpy._core.numeric")
_OTHERS = {
    ("numpy", "ndarray"),
    ("numpy", "dtype"),
    ("builtins", "slice"),
    *((module, name) for module in _NUMPY for name in ("_reconstruct", "_frombuffer", "scalar")),
    *(
        ("builtins", name)
        for name, value in vars(builtins).items()
        if isinstance(value, type) and issubclass(value, OSError)
    ),
    *(("pathlib", name) for name in ("Path", "PosixPath", "WindowsPath", "PurePosixPath", "PureWindowsPath")),
    *(("pathlib._local", name) for name in ("Path", "PosixPath", "WindowsPath")),
}
"""What messages may name beside the engine's own: a pickle can name any function, and call it."""


class BadMessage(Exception):
    """What arrived is no message."""


class Channel:
    """One end of the connection. Messages are any objects that pickle; they arrive in their order."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self._outgoing: deque[memoryview] = deque()
        self._incoming = _arriving()
        next(self._incoming)

    def post(self, message: Any) -> None:
        """Queue a message: `flush` sends it. Its arrays must stay as they are until then."""
        arrays: list[pickle.PickleBuffer] = []
        stream = io.BytesIO()
        pickle.Pickler(stream, protocol=5, buffer_callback=arrays.append).dump(message)
        parts = [memoryview(stream.getvalue()), *(array.raw() for array in arrays)]
        sizes = [part.nbytes for part in parts]
        self._outgoing.append(memoryview(struct.pack(f"<{len(sizes)}Q", *sizes)))
        for part in parts:
            self._outgoing.extend(part[first : first + _BLOCK] for first in range(0, part.nbytes, _BLOCK))

    def flush(self, seconds: float | None = None) -> bool:
        """Send what is queued, for some seconds at most; whether all is sent.

        Raises:
            OSError: if the other end is gone.
        """
        until = _deadline(seconds)
        while self._outgoing:
            self._connection.send_bytes(self._outgoing[0])
            self._outgoing.popleft()
            if time.monotonic() > until:
                break
        return not self._outgoing

    def poll(self, seconds: float) -> bool:
        """Wait some seconds for the other end; whether it has sent something, or is gone."""
        return self._connection.poll(seconds)

    def take(self, seconds: float) -> Iterator[Any]:
        """The messages that have arrived, without waiting for more. Reads for some seconds at most.

        Raises:
            EOFError, OSError: if the other end is gone.
            BadMessage: if what arrived is none.
        """
        until = _deadline(seconds)
        while self._connection.poll(0.0):
            message = self._incoming.send(self._connection.recv_bytes())
            if message is not _UNFINISHED:
                yield message
            if time.monotonic() > until:
                return

    def wait(self, seconds: float | None) -> Any:
        """The next message, or None if none begins to arrive within some seconds.

        Raises:
            EOFError, OSError, BadMessage: as `take`.
        """
        if not self._connection.poll(seconds):
            return None
        while (message := self._incoming.send(self._connection.recv_bytes())) is _UNFINISHED:
            pass
        return message

    def close(self) -> None:
        """Close the connection."""
        self._connection.close()


_UNFINISHED = object()


def _arriving() -> Generator[Any, bytes, None]:
    """A generator that is sent blocks; it yields each message with its last block, and `_UNFINISHED` with all others."""
    message: Any = _UNFINISHED
    while True:
        block = yield message
        sizes = _sizes(block)
        parts: list[npt.NDArray[np.uint8]] = []
        for size in sizes:
            part = np.empty(size, dtype=np.uint8)  # memory that is touched as blocks arrive, not all at once
            filled = 0
            while filled < size:
                block = yield _UNFINISHED
                if filled + len(block) > size:
                    raise BadMessage("a block is too long")
                part[filled : filled + len(block)] = np.frombuffer(block, dtype=np.uint8)
                filled += len(block)
            parts.append(part)
        message = _loaded(parts)


def _sizes(block: bytes) -> tuple[int, ...]:
    """The sizes of a message's parts: its pickle, then its arrays."""
    if not block or len(block) % 8:
        raise BadMessage("a message does not begin with its sizes")
    sizes = struct.unpack(f"<{len(block) // 8}Q", block)
    if sum(sizes) > _MOST:
        raise BadMessage("a message claims to be larger than any")
    return sizes


def _loaded(parts: list[npt.NDArray[np.uint8]]) -> Any:
    try:
        return _Unpickler(io.BytesIO(parts[0].tobytes()), buffers=parts[1:]).load()
    except Exception as error:
        raise BadMessage(f"a message cannot be read: {error}") from error


class _Unpickler(pickle.Unpickler):
    """Reads what the other process wrote, where `prt_addon` has another name; loads nothing that no message needs."""

    def find_class(self, module: str, name: str) -> Any:
        """The engine's own things by the name that they have here; of others, those in `_OTHERS`."""
        _, found, inside = f".{module}".rpartition(".prt_addon.")
        if found and inside.split(".")[0] in _OURS and "." not in name:
            return super().find_class(f"{_PACKAGE}.{inside}", name)
        if (module, name) in _OTHERS:
            return super().find_class(module, name)
        raise pickle.UnpicklingError(f"{module}.{name} has no place in a message")


def _deadline(seconds: float | None) -> float:
    return float("inf") if seconds is None else time.monotonic() + seconds
