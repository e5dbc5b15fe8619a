# SPDX-License-Identifier: GPL-3.0-or-later
"""Serves jobs in the engine's process: reads one, carries it out, answers; ends when Blender does, or has sent nothing
for a while.

Blender sends `Order`s, one at a time, and while one is carried out `Continue` and `Cancel`. The engine answers `READY` once, then to
each job `Progress` now and then, perhaps something `Shown`, and last `Success` or `Failure`. A `Progress` is sent once the
one before was answered by `Continue`, and what is shown goes out in a thread of its own: Blender may be away for minutes, and
a full pipe would hold up the bake.
"""

from __future__ import annotations

import os
import sys
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass, replace
from multiprocessing.connection import Connection
from typing import TYPE_CHECKING, Any, NoReturn

from ..core.bake.cache import TraceCache
from ..core.bake.run import Run
from ..core.errors import CANCELLED, Cancelled, EngineError, NoRoom, PRTError
from ..core.monitor import Monitor, Work
from ..core.workers import Workers
from .channel import Channel

if TYPE_CHECKING:
    from concurrent.futures import Future

READY = "ready"

_LONGER = 1.0
"""Seconds that the engine waits beyond its patience: Blender, which gives no job to one that is about to end, is sure to be right."""

_PAUSE = 0.05
"""Seconds between two words about progress."""


@dataclass(frozen=True)
class Order:
    """Blender orders a job: a task and its arguments.

    task: one of `tasks`, called with the arguments and the run.
    run: what of it is plain data; who watches and what is kept is the engine's business.
    threads: that may be used; all cores if 0.
    patience: seconds that the engine waits for another job afterwards before it ends.
    """

    task: Callable[..., Any]
    arguments: tuple[Any, ...]
    run: Run
    threads: int
    patience: float


@dataclass(frozen=True)
class Progress:
    """The engine sends what is done of a job."""

    done: Work


@dataclass(frozen=True)
class Shown:
    """The engine sends a preview, though the job goes on."""

    value: Any


class Continue:
    """Blender has taken the progress."""


class Cancel:
    """The user has cancelled."""


@dataclass(frozen=True)
class Success:
    """The engine sends the result of a job, and the last word about its progress."""

    value: Any
    done: Work


@dataclass(frozen=True)
class Failure:
    """The engine sends why a job failed."""

    error: Exception


def serve(handle: int, patience: float) -> None:
    """Serve the Blender at the other end of the connection until it hangs up, or sends nothing for some seconds."""
    channel = Channel(_connection(handle))
    traces = TraceCache()
    try:
        channel.post(READY)
        channel.flush()
        while order := channel.wait(patience):
            if isinstance(order, Order):  # a word to a job that has just ended comes too late
                aside = _Aside(channel)
                answer = _answer(order, channel, traces, aside)
                aside.finish()
                channel.post(answer)
                channel.flush()
                patience = order.patience + _LONGER
        _end("no job came")
    except (EOFError, OSError) as error:
        _end(f"Blender is gone: {error!r}")


def _end(why: str) -> NoReturn:
    """At once: threads that cast rays are not waited for. The reason is for whoever reads the log of an end that comes amiss."""
    print(why, file=sys.stderr, flush=True)
    os._exit(0)


def _connection(handle: int) -> Connection:
    if sys.platform == "win32":
        from multiprocessing.connection import PipeConnection

        return PipeConnection(handle)
    return Connection(handle)


def _answer(order: Order, channel: Channel, traces: TraceCache, aside: _Aside) -> Success | Failure:
    """Carry out a job."""
    monitor = _SendingMonitor(channel, aside)
    try:
        monitor.check_cancelled()
        run = replace(order.run, workers=Workers(order.threads, monitor), traces=traces)
        return Success(order.task(*order.arguments, run), monitor.done)
    except (PRTError, OSError) as error:
        if isinstance(error, OSError) and error.filename is None:
            return Failure(EngineError(f"The engine failed: {error.strerror or error}. Nothing was changed."))
        return Failure(error)
    except MemoryError:
        traces.clear()
        return Failure(
            NoRoom(
                "Memory ran out; nothing was changed. Set a lower Memory limit, or bake with fewer samples or objects."
            )
        )
    except Exception as error:  # a mistake of ours: the console gets all of it, the user a sentence
        traceback.print_exc()
        return Failure(EngineError(f"The engine failed: {type(error).__name__}: {error}. Nothing was changed."))


class _Aside:
    """Sends large messages beside the work. While it is busy nothing else may be sent."""

    def __init__(self, channel: Channel) -> None:
        self._channel = channel
        self._sending: Future[bool] | None = None

    @property
    def busy(self) -> bool:
        """Whether a message is on its way."""
        return self._sending is not None and not self._sending.done()

    def send(self, message: Any) -> None:
        """Send one, and return before it is sent."""
        from concurrent.futures import ThreadPoolExecutor  # in the engine's process alone

        self.finish()
        self._channel.post(message)
        pool = ThreadPoolExecutor(1)
        self._sending = pool.submit(self._channel.flush)
        pool.shutdown(wait=False)

    def finish(self) -> None:
        """Wait until all is sent.

        Raises:
            OSError: if Blender is gone.
        """
        if self._sending:
            self._sending.result()


class _SendingMonitor(Monitor):
    """Sends a job's progress to Blender, and reads whether it is to go on."""

    def __init__(self, channel: Channel, aside: _Aside) -> None:
        self.done = Work()
        self._channel, self._aside = channel, aside
        self._next, self._answered = 0.0, True
        self._waiting: Shown | None = None

    def advance(self, work: Work) -> None:
        """Count it; see `Monitor`."""
        self.done += work
        self.check_cancelled()

    def check_cancelled(self) -> None:
        """See `Monitor`. Talks to Blender only now and then."""
        if time.monotonic() < self._next:
            return
        try:
            self._talk()
        except (EOFError, OSError) as error:
            _end(f"Blender is gone: {error!r}")
        self._next = time.monotonic() + _PAUSE

    def show(self, preview: object) -> None:
        """See `Monitor`. Until Blender has taken what came before it waits, and the latest of those that wait is sent."""
        self._waiting = Shown(preview)
        self._send_waiting()

    def _send_waiting(self) -> None:
        if self._waiting and not self._aside.busy:
            self._aside.send(self._waiting)
            self._waiting = None

    def _talk(self) -> None:
        for word in self._channel.take(_PAUSE):
            if isinstance(word, Cancel):
                raise Cancelled(CANCELLED)
            self._answered = True
        self._send_waiting()
        if self._answered and not self._aside.busy:
            self._channel.post(Progress(self.done))
            self._channel.flush()
            self._answered = False
