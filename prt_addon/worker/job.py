# SPDX-License-Identifier: GPL-3.0-or-later
"""One piece of work for the engine: started, watched, cancelled, and its result taken. One at a time.

What runs lives here and not in the file, so that no file can be stuck in a bake.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Sequence
from typing import Any, Generic, TypeVar

from ..core.bake import bounce_work, ray_count
from ..core.errors import CANCELLED, Cancelled, EngineError, PRTError
from ..core.inputs import BakeSettings, Occluders, ReceiverGroup
from ..core.run import PLAINLY, Run
from . import serve, tasks
from .engine import Engine

Value = TypeVar("Value")

PATIENCE = 600.0
"""Seconds without a job after which the engine ends, unless a job says otherwise."""

_FIRST_PATIENCE = 300.0  # seconds that a new engine waits while a scene is read
_RECENT = 5.0  # seconds that the speed is measured over
_MOMENT = 0.1  # seconds between two measurements
_GRACE = 0.1  # seconds that the engine has to answer a cancel before it is killed
_NOTICE = 0.05  # seconds between two looks while a script waits


class Job(Generic[Value]):
    """Work of the engine: `start`, `step` until not `running`, then take the `result`."""

    def __init__(
        self,
        task: Callable[..., Value],
        *arguments: Any,
        total: int,
        bounces: int = 0,
        run: Run = PLAINLY,
        threads: int = 0,
        patience: float = PATIENCE,
        doing: str = "",
    ) -> None:
        """
        Args:
            task: one of `tasks`.
            arguments: of it, all but the last.
            total: rays that it will count.
            bounces: what it will count of bounces, about.
            run: how else it is carried out.
            threads: that it may use; all cores if 0.
            patience: seconds that the engine is kept afterwards.
            doing: what it is doing, in a word, if it counts something else than rays.
        """
        self.total = total
        self.done = self.bounced = 0
        self._bounces, self._doing = bounces, doing
        self._order = serve.Job(task, arguments, run, threads, patience)
        self._speeds = deque([(time.monotonic(), 0, 0)])
        self._cancelled: float | None = None
        self._outcome: serve.Result | serve.Failure | None = None

    def start(self) -> None:
        """Begin; this is now the `running_job`.

        Raises:
            PRTError: if another one runs, or the engine cannot be started.
        """
        global _current
        if _current:
            raise PRTError("A bake is running: wait for it, or cancel it.")
        wake_engine().send(self._order)
        _current = self
        self._speeds = deque([(time.monotonic(), 0, 0)])

    @property
    def running(self) -> bool:
        """Whether the engine works on it, as far as was seen."""
        return _current is self

    @property
    def progress(self) -> float:
        """Share of the work that is done, 0..1."""
        total = self.total + self._bounces
        return min(1.0, (self.done + self.bounced) / total) if total else 0.0

    @property
    def text(self) -> str:
        """One line for panel and status bar."""
        (then, rays_then, work_then), (now, rays, work) = self._speeds[0], self._speeds[-1]
        if not work:
            return self._doing or "preparing the rays"
        seconds = max(now - then, 1e-9)
        left = max(0, self.total + self._bounces - work) * seconds / max(work - work_then, 1)
        doing = "bouncing light" if self.done == self.total else f"{(rays - rays_then) / seconds / 1e6:.1f} Mrays/s"
        return f"{self.progress:.0%}  {self._doing or doing}  {_spoken(left)} left"

    def step(self, wait: float = 0.0) -> None:
        """Look at what the engine has to say; wait some seconds for it."""
        if not self.running:
            return
        assert _engine
        if self._cancelled is not None and time.monotonic() > self._cancelled + _GRACE:
            end_engine()
            return
        try:
            for word in _engine.receive(wait):
                self._hear(word)
        except EngineError as error:
            end_engine(error)

    def wait(self, seconds: float | None = None) -> None:
        """Wait for the end, or for some seconds."""
        until = float("inf") if seconds is None else time.monotonic() + seconds
        while self.running and (left := until - time.monotonic()) > 0.0:
            self.step(min(left, _NOTICE))

    def cancel(self) -> None:
        """Ask the engine to stop. If it does not within a moment, the next `step` kills it."""
        if self.running and self._cancelled is None:
            assert _engine
            self._cancelled = time.monotonic()
            _engine.send(serve.Cancel())
            self.step()

    def result(self) -> Value:
        """What the work came to; waits for it.

        Raises:
            Cancelled: if it was stopped.
            EngineError: if the engine came to an end.
            PRTError, OSError: what went wrong in it.
        """
        self.wait()
        if isinstance(self._outcome, serve.Failure):
            raise self._outcome.error
        assert self._outcome, "never started"
        value: Value = self._outcome.value
        return value

    def _hear(self, word: Any) -> None:
        assert _engine
        if isinstance(word, serve.Progress):
            self._advance(word)
            _engine.send(serve.Continue())
            return
        if isinstance(word, serve.Result):
            self._advance(word.progress)
        elif not isinstance(word, serve.Failure):
            raise EngineError("The engine answered something that has no meaning. Nothing was changed: try again.")
        self._outcome = word
        _release(self._order.patience)

    def _advance(self, progress: serve.Progress) -> None:
        self.done, self.bounced = progress.rays, progress.bounced
        now = time.monotonic()
        if now > self._speeds[-1][0] + _MOMENT:
            self._speeds.append((now, self.done, self.done + self.bounced))
            while len(self._speeds) > 2 and self._speeds[0][0] < now - _RECENT:
                self._speeds.popleft()


def whole_bake(
    groups: Sequence[ReceiverGroup],
    occluders: Occluders,
    settings: BakeSettings,
    run: Run = PLAINLY,
    threads: int = 0,
    patience: float = PATIENCE,
) -> Job[tasks.Baked]:
    """The job of `core.bake.bake_all`."""
    return Job(
        tasks.bake,
        groups,
        occluders,
        settings,
        total=ray_count(groups, settings),
        bounces=bounce_work(groups, settings),
        run=run,
        threads=threads,
        patience=patience,
    )


_current: Job[Any] | None = None
_engine: Engine | None = None


def running_job() -> Job[Any] | None:
    """The job that the engine works on, if it does."""
    return _current


def end_engine(error: PRTError | None = None) -> None:
    """End the engine and what it keeps. A job that runs fails: of the error, or because it was cancelled."""
    global _engine, _current
    engine, job = _engine, _current
    _engine = _current = None
    if job:
        job._outcome = serve.Failure(error or Cancelled(CANCELLED))
    if engine:
        engine.end()


def wake_engine() -> Engine:
    """The engine, a new one if there is none that will last. It starts while the caller goes on.

    Raises:
        EngineError: if the process cannot be started.
    """
    global _engine
    if _engine and not (_current or _engine.usable):
        end_engine()
    _engine = _engine or Engine(_FIRST_PATIENCE)
    return _engine


def _release(patience: float) -> None:
    """The engine has answered."""
    global _current
    assert _engine
    _current = None
    _engine.rest(patience)
    if not patience:
        end_engine()


def _spoken(seconds: float) -> str:
    """A time to wait for, as precise as one cares to know."""
    hours, minutes = divmod(round(seconds / 60), 60)
    if hours:
        return f"{hours} h {minutes} min"
    return "{} min {} s".format(*divmod(round(seconds), 60)) if seconds > 120 else f"{seconds:.0f} s"
