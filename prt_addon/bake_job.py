# SPDX-License-Identifier: GPL-3.0-or-later
"""A bake in a thread of its own: started, watched and stopped from Blender's main thread, without touching bpy.

The state of a running bake lives here and not in the file, so that no file can be stuck in a bake.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, Generic, TypeVar

import numpy as np
import numpy.typing as npt

from .core.bake import bake_all, bounce_work, ray_count
from .core.errors import Cancelled, PRTError
from .core.inputs import BakeSettings, Occluders, ReceiverGroup
from .core.kept import KeptTraces
from .core.parallel import Workers
from .core.run import PLAINLY, Run

Result = TypeVar("Result")

_RECENT = 5.0  # seconds that the speed is measured over
_MOMENT = 0.1  # seconds between two measurements


class BakeJob(Generic[Result]):
    """One bake, or a part of one: `start`, look at `progress` until not `running`, then take `result`."""

    def __init__(
        self, work: Callable[[Run], Result], rays: int, threads: int, bounces: int = 0, run: Run = PLAINLY
    ) -> None:
        """
        Args:
            work: the bake.
            rays: that it will tell to the run's workers.
            threads: that it may use.
            bounces: what it will tell to the run of bounces, about.
            run: how else it is carried out.
        """
        self.total = rays
        self.done = 0
        self.findings: list[tuple[ReceiverGroup, str]] = []
        self._bounces, self._bounced = bounces, 0
        self._speeds = deque([(time.monotonic(), 0, 0)])
        self._stop, self._finished = threading.Event(), threading.Event()
        self._result: Result
        self._error: BaseException | None = None
        run = replace(
            run, workers=Workers(threads, self._advance), tell=self._tell, kept=_kept, bounced=self._advance_bounces
        )
        self._thread = threading.Thread(target=self._work, args=(work, run), name="prt-bake", daemon=True)

    def start(self) -> None:
        """Begin; this is now the `running_job`.

        Raises:
            PRTError: if another one runs.
        """
        global _current
        if _current:
            raise PRTError("A bake is running: wait for it, or cancel it.")
        _current = self
        self._speeds = deque([(time.monotonic(), 0, 0)])
        self._thread.start()

    @property
    def running(self) -> bool:
        """Whether the thread still works."""
        return self._thread.ident is not None and not self._finished.is_set()

    @property
    def progress(self) -> float:
        """Share of the work that is done, 0..1."""
        total = self.total + self._bounces
        return min(1.0, (self.done + self._bounced) / total) if total else 0.0

    @property
    def text(self) -> str:
        """One line for panel and status bar."""
        (then, rays_then, work_then), (now, rays, work) = self._speeds[0], self._speeds[-1]
        seconds = max(now - then, 1e-9)
        left = max(0, self.total + self._bounces - work) * seconds / max(work - work_then, 1)
        doing = "bouncing light" if self.done == self.total else f"{(rays - rays_then) / seconds / 1e6:.1f} Mrays/s"
        return f"{self.progress:.0%}  {doing}  {_spoken(left)} left" if work else "preparing the rays"

    def wait(self, seconds: float | None = None) -> None:
        """Wait for the end, or for some seconds."""
        if self._finished.wait(seconds):  # Python 3.11 takes a thread for ended when Ctrl-C breaks into its join()
            self._thread.join()

    def cancel(self) -> None:
        """Ask the thread to stop; it does within a chunk of rays per core."""
        self._stop.set()

    def result(self) -> Result:
        """What the work came to.

        Raises:
            Cancelled: if the bake was stopped.
            PRTError, or any other error: what went wrong in the thread.
        """
        self.wait()
        if self._error is not None:
            raise self._error
        return self._result

    def _work(self, work: Callable[[Run], Result], run: Run) -> None:
        global _current
        try:
            self._advance(0)
            self._result = work(run)
        except BaseException as error:  # handed to the main thread by result()
            self._error = error
        finally:
            _current = None
            self._finished.set()

    def _tell(self, group: ReceiverGroup, sentence: str) -> None:
        self.findings.append((group, sentence))

    def _advance(self, rays: int) -> None:
        self.done += rays
        now = time.monotonic()
        if now > self._speeds[-1][0] + _MOMENT:
            self._speeds.append((now, self.done, self.done + self._bounced))
            while len(self._speeds) > 2 and self._speeds[0][0] < now - _RECENT:
                self._speeds.popleft()
        if self._stop.is_set():
            raise Cancelled("The bake was cancelled; nothing was changed.")

    def _advance_bounces(self, rays: int) -> None:
        self._bounced += rays


def _spoken(seconds: float) -> str:
    """A time to wait for, as precise as one cares to know."""
    hours, minutes = divmod(round(seconds / 60), 60)
    if hours:
        return f"{hours} h {minutes} min"
    return "{} min {} s".format(*divmod(round(seconds), 60)) if seconds > 120 else f"{seconds:.0f} s"


def whole_bake(
    groups: Sequence[ReceiverGroup], occluders: Occluders, settings: BakeSettings, threads: int, run: Run = PLAINLY
) -> BakeJob[list[npt.NDArray[np.float32]]]:
    """The job of `core.bake.bake_all`."""
    return BakeJob(
        lambda run: bake_all(groups, occluders, settings, run),
        ray_count(groups, settings),
        threads,
        bounce_work(groups, settings),
        run,
    )


_current: BakeJob[Any] | None = None
_kept = KeptTraces()


def running_job() -> BakeJob[Any] | None:
    """The bake that runs now, if one does."""
    return _current


def unregister() -> None:
    """Stop a bake that runs while the extension is disabled, and free what was kept."""
    job = running_job()
    if job:
        job.cancel()
        job.wait()
    _kept.clear()
