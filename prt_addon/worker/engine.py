# SPDX-License-Identifier: GPL-3.0-or-later
"""Starts the engine's process when a job needs it, and ends it: a child of Blender's own Python, one at most."""

from __future__ import annotations

import importlib.util
import os
import signal
import subprocess
import sys
import tempfile
import time
from contextlib import nullcontext, suppress
from multiprocessing.connection import Connection, Pipe
from pathlib import Path
from typing import IO, Any

from ..core.errors import EngineError
from .channel import BadMessage, Channel
from .serve import READY

_CHILD = Path(__file__).with_name("child.py")
_PACKAGES = ("embreex", "numpy")
_SLICE = 0.008  # seconds for each of sending and reading
_SECONDS_TO_START = 60.0  # on a machine that is busy, from a network drive
_MARGIN = 1.0  # seconds: an engine that is about to end for want of work gets none
_SINGLE_THREADED = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
"""A BLAS that starts threads of its own fights with ours, and sums in an order that depends on the machine."""


class Engine:
    """A running engine, from when this is made until `end`. It ends by itself when this process does."""

    def __init__(self, patience: float) -> None:
        """
        Args:
            patience: seconds that it waits for a first job.

        Raises:
            EngineError: if the process cannot be started.
        """
        self._log: IO[bytes] = tempfile.TemporaryFile(prefix="prt-")  # noqa: SIM115 - lives as long as the process
        ours, theirs = Pipe()
        try:
            self._process = _started(theirs, patience, self._log)
        except OSError as error:
            ours.close()
            self._log.close()
            raise EngineError(
                f"The engine could not be started with Blender's own Python, '{sys.executable}': {error.strerror or error}."
            ) from error
        finally:
            theirs.close()
        self._channel = Channel(ours)
        self._ready, self._sent = False, True
        self._began = time.monotonic()
        self._ends = self._began + patience

    @property
    def process(self) -> int:
        """The process's number."""
        return self._process.pid

    @property
    def usable(self) -> bool:
        """Whether the engine waits for a job, and will for a while."""
        return self._process.poll() is None and time.monotonic() < self._ends - _MARGIN

    def send(self, message: Any) -> None:
        """Queue a message; what does not go out at once does while `receive` is called."""
        self._channel.post(message)
        self._sent = False
        with suppress(OSError):  # `receive` will say what has become of it
            self._flush()

    def receive(self, wait: float = 0.0) -> list[Any]:
        """What has arrived; waits some seconds for it. Sends and reads for 16 ms at most, so that a window stays live.

        Raises:
            EngineError: if the engine came to an end, does not start, or answers what is no message.
        """
        try:
            if self._sent:
                self._channel.poll(wait)
            arrived = self._taken()
            if not self._ready:
                arrived = self._greeted(arrived)
            with suppress(OSError) if arrived else nullcontext():  # what has arrived counts
                self._flush()
        except (EOFError, OSError) as error:
            raise EngineError(self._epitaph()) from error
        except (BadMessage, MemoryError) as error:
            self.end()
            raise EngineError(
                f"The engine's answer could not be read ({error}). Nothing was changed: try again."
            ) from error
        return arrived

    def rest(self, patience: float) -> None:
        """Let the engine wait for another job, after this one, and end if none comes within some seconds."""
        self._ends = time.monotonic() + patience

    def end(self) -> None:
        """End the engine now, whatever it does; harmless if it has ended."""
        self._process.kill()
        self._process.wait()
        self._channel.close()
        self._log.close()

    def _taken(self) -> list[Any]:
        """What has arrived; also what arrived just before the engine hung up, which the next look raises."""
        arrived: list[Any] = []
        try:
            for message in self._channel.take(_SLICE):
                arrived.append(message)
        except (EOFError, OSError):
            if not arrived:
                raise
        return arrived

    def _flush(self) -> None:
        if self._ready:
            self._sent = self._channel.flush(_SLICE)

    def _greeted(self, arrived: list[Any]) -> list[Any]:
        """What has arrived, less the first word, which says that the engine is ready."""
        if arrived and arrived[0] != READY:
            raise BadMessage("it does not begin as the engine does")
        self._ready = bool(arrived)
        if not arrived and time.monotonic() > self._began + _SECONDS_TO_START:
            self.end()
            raise EngineError(f"The engine did not start within {_SECONDS_TO_START:.0f} seconds. Nothing was changed.")
        return arrived[1:]

    def _epitaph(self) -> str:
        """What to say of an engine that came to an end; what it printed goes to the console."""
        try:
            code = self._process.wait(1.0)
        except subprocess.TimeoutExpired:  # it hung up and lives on
            self._process.kill()
            code = self._process.wait()
        self._log.seek(0)
        said = self._log.read().decode("utf-8", "replace").strip()
        self.end()
        if said:
            print(said, file=sys.stderr)
        if not self._ready:
            last = said.splitlines()[-1] if said else f"exit code {code}"
            return f"The engine could not be started with Blender's own Python, '{sys.executable}': {last}."
        if sys.platform != "win32" and code == -signal.SIGKILL:
            return (
                "The engine was killed by the system, as happens when memory runs out. Nothing was changed: set a lower "
                "Memory limit, close other programs, or bake fewer objects at once."
            )
        return f"The engine came to an unexpected end (exit code {code}). Nothing was changed: try again."


def _started(theirs: Connection, patience: float, log: IO[bytes]) -> subprocess.Popen[bytes]:
    """Start the process with its end of the connection.

    It is in a process group of its own, without a console: Ctrl-C is for Blender.
    """
    handle = theirs.fileno()
    options: dict[str, Any] = {"pass_fds": [handle], "process_group": 0}
    if sys.platform == "win32":
        os.set_handle_inheritable(handle, True)
        startup = subprocess.STARTUPINFO(lpAttributeList={"handle_list": [handle]})
        options = {"startupinfo": startup, "creationflags": subprocess.CREATE_NO_WINDOW}
    return subprocess.Popen(
        [sys.executable, "-I", "-B", "-X", "faulthandler", str(_CHILD), str(handle), str(patience), *_folders()],
        stdin=subprocess.DEVNULL,
        stdout=log,
        stderr=log,
        env=os.environ | dict.fromkeys(_SINGLE_THREADED, "1"),
        **options,
    )


def _folders() -> list[str]:
    """Where the child finds `prt_addon` and what it imports."""
    found = [str(_CHILD.parents[2])]
    for package in _PACKAGES:
        spec = importlib.util.find_spec(package)
        if spec and spec.origin:
            found.append(str(Path(spec.origin).parents[1]))
    return list(dict.fromkeys(found))
