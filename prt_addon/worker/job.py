# SPDX-License-Identifier: GPL-3.0-or-later
"""Starts, watches and cancels one piece of work for the engine, and takes its result. One at a time.

What runs lives here and not in the file, so that no file can be stuck in a bake.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from typing import Any, Generic, TypeVar

from ..core.bake.bake import BakeResult
from ..core.bake.run import DEFAULT_RUN, Run
from ..core.errors import CANCELLED, Cancelled, EngineError, PRTError
from ..core.monitor import Work
from ..core.problem import BakeProblem
from ..session import session
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
        work: Work,
        run: Run = DEFAULT_RUN,
        threads: int = 0,
        patience: float = PATIENCE,
        doing: str = "",
        unit: str = "ray",
    ) -> None:
        """
        Args:
            task: one of `tasks`.
            arguments: of it, all but the last.
            work: all that its monitor will see done.
            run: how else it is carried out.
            threads: that it may use; all cores if 0.
            patience: seconds that the engine is kept afterwards.
            doing: what it is doing, in a word, and
            unit: what it counts, if it counts something else than rays.
        """
        self.shows = ""  # what there is to see of it, in words
        self.work, self.done, self.unit = work, Work(), unit
        self._shown: Any = None
        self._is_new = self._keeps_shown = False
        self._doing = doing
        self._order = serve.Order(task, arguments, run, threads, patience)
        self._speeds = deque([(time.monotonic(), Work())])
        self._cancelled: float | None = None
        self._outcome: serve.Success | serve.Failure | None = None

    def start(self) -> None:
        """Begin the work; this job is now the `running_job`.

        Raises:
            PRTError: if another one runs, or the engine cannot be started.
        """
        if session.job:
            raise PRTError("A bake is running: wait for it, or cancel it.")
        wake_engine().send(self._order)
        session.job = self
        self._speeds = deque([(time.monotonic(), Work())])

    @property
    def running(self) -> bool:
        """Whether the engine works on this job, as far as was seen."""
        return session.job is self

    @property
    def progress(self) -> float:
        """The share of the work that is done, 0..1."""
        return min(1.0, self.done.total / self.work.total) if self.work.total else 0.0

    @property
    def text(self) -> str:
        """One line on the progress, for panel and status bar."""
        (then, before), (now, done) = self._speeds[0], self._speeds[-1]
        if not done.total:
            return self._doing or self.shows or "preparing the rays"
        seconds = max(now - then, 1e-9)
        left = max(0, self.work.total - done.total) * seconds / max(done.total - before.total, 1)
        rate = f"{(done.rays - before.rays) / seconds / 1e6:.1f} Mrays/s"
        doing = self.shows or ("bouncing light" if self.done.rays == self.work.rays else rate)
        return f"{self.progress:.0%}  {self._doing or doing}, {spoken(left)} left"

    def step(self, wait: float = 0.0) -> None:
        """Read what the engine has sent; wait some seconds for it."""
        if not self.running:
            return
        assert session.engine
        if self._cancelled is not None and time.monotonic() > self._cancelled + _GRACE:
            end_engine()
            return
        try:
            for word in session.engine.receive(wait):
                self._hear(word)
        except EngineError as error:
            end_engine(error)

    def wait(self, seconds: float | None = None) -> None:
        """Wait for the end, or for some seconds."""
        until = float("inf") if seconds is None else time.monotonic() + seconds
        while self.running and (left := until - time.monotonic()) > 0.0:
            self.step(min(left, _NOTICE))

    def cancel(self) -> None:
        """Request that the engine stops. If it does not within a moment, the next `step` kills it."""
        if self.running and self._cancelled is None:
            assert session.engine
            self._cancelled = time.monotonic()
            session.engine.send(serve.Cancel())
            self.step()

    def show(self, value: Any) -> None:
        """Show something of the result that is there before the engine shows any."""
        self._shown, self._is_new = value, True

    def take_shown(self) -> Any:
        """Take the latest that was shown since the last call, if anything."""
        is_new, self._is_new = self._is_new, False
        return self._shown if is_new else None

    def keep(self) -> None:
        """Request that the engine stops and the latest that was shown is the result."""
        self._keeps_shown = self._shown is not None
        self.cancel()

    def result(self) -> Value:
        """Wait for the result of the work, or for what was kept of it.

        Raises:
            Cancelled: if it was stopped.
            EngineError: if the engine came to an end.
            PRTError, OSError: what went wrong in it.
        """
        self.wait()
        if isinstance(self._outcome, serve.Failure):
            if self._keeps_shown and isinstance(self._outcome.error, Cancelled):
                kept: Value = self._shown
                return kept
            raise self._outcome.error
        assert self._outcome, "never started"
        value: Value = self._outcome.value
        return value

    def _hear(self, word: Any) -> None:
        assert session.engine
        if isinstance(word, serve.Progress):
            self._advance(word.done)
            session.engine.send(serve.Continue())
            return
        if isinstance(word, serve.Shown):
            self.show(word.value)
            return
        if isinstance(word, serve.Success):
            self._advance(word.done)
        elif not isinstance(word, serve.Failure):
            raise EngineError("The engine answered something that has no meaning. Nothing was changed: try again.")
        self._outcome = word
        _release(self._order.patience)

    def _advance(self, done: Work) -> None:
        self.done = done
        now = time.monotonic()
        if now > self._speeds[-1][0] + _MOMENT:
            self._speeds.append((now, done))
            while len(self._speeds) > 2 and self._speeds[0][0] < now - _RECENT:
                self._speeds.popleft()


def bake_job(
    problem: BakeProblem,
    run: Run = DEFAULT_RUN,
    threads: int = 0,
    patience: float = PATIENCE,
    previews: bool = False,
) -> Job[BakeResult]:
    """The job of a whole bake, which may show a `Preview` or several before it is done."""
    task = tasks.bake_with_previews if previews else tasks.bake
    return Job(task, problem, work=problem.work, run=run, threads=threads, patience=patience)


def running_job() -> Job[Any] | None:
    """The job that the engine works on, if it does."""
    return session.job


def end_engine(error: PRTError | None = None) -> None:
    """End the engine and what it keeps. A job that runs fails: of the error, or because it was cancelled."""
    engine, job = session.engine, session.job
    session.engine = session.job = None
    if job:
        job._outcome = serve.Failure(error or Cancelled(CANCELLED))
    if engine:
        engine.end()


def wake_engine() -> Engine:
    """The engine, a new one if there is none that will last. It starts while the caller goes on.

    Raises:
        EngineError: if the process cannot be started.
    """
    if session.engine and not (session.job or session.engine.usable):
        end_engine()
    session.engine = session.engine or Engine(_FIRST_PATIENCE)
    return session.engine


def _release(patience: float) -> None:
    """The engine has answered."""
    assert session.engine
    session.job = None
    session.engine.rest(patience)
    if not patience:
        end_engine()


def spoken(seconds: float) -> str:
    """A time to wait for, as precise as one cares to know."""
    hours, minutes = divmod(round(seconds / 60), 60)
    if hours:
        return f"{hours} h {minutes} min"
    return "{} min {} s".format(*divmod(round(seconds), 60)) if seconds > 120 else f"{seconds:.0f} s"
