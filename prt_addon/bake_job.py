# SPDX-License-Identifier: GPL-3.0-or-later
"""A bake in a thread of its own: started, watched and stopped from Blender's main thread, without touching bpy.

The state of a running bake lives here and not in the file, so that no file can be stuck in a bake.
"""

from __future__ import annotations

import threading
import time

import numpy as np
import numpy.typing as npt

from .core.bake import BakeSettings, Occluders, ReceiverGroup, Run, bake_all, ray_count
from .core.errors import Cancelled
from .core.kept import KeptTraces
from .core.parallel import Workers


class BakeJob:
    """One bake: `start`, look at `progress` until not `running`, then take `result`."""

    def __init__(self, groups: list[ReceiverGroup], occluders: Occluders, settings: BakeSettings, threads: int) -> None:
        self.total = ray_count(groups, settings)
        self.done = 0
        self.settings = settings
        self.findings: list[tuple[ReceiverGroup, str]] = []
        self._begun = time.monotonic()
        self._stop = threading.Event()
        self._result: list[npt.NDArray[np.float32]] = []
        self._error: BaseException | None = None
        self._thread = threading.Thread(
            target=self._work, args=(groups, occluders, threads), name="prt-bake", daemon=True
        )

    def start(self) -> None:
        """Begin; this is now the `running_job`."""
        global _current
        _current = self
        self._begun = time.monotonic()
        self._thread.start()

    @property
    def running(self) -> bool:
        """Whether the thread still works."""
        return self._thread.is_alive()

    @property
    def progress(self) -> float:
        """Share of the rays that are cast, 0..1."""
        return self.done / self.total if self.total else 0.0

    @property
    def rays_per_second(self) -> float:
        """Mean speed since the start."""
        return self.done / max(time.monotonic() - self._begun, 1e-9)

    @property
    def seconds_left(self) -> float:
        """Time to go at the mean speed."""
        return (self.total - self.done) / max(self.rays_per_second, 1.0)

    def wait(self, seconds: float | None = None) -> None:
        """Wait for the end, or for some seconds."""
        self._thread.join(seconds)

    def cancel(self) -> None:
        """Ask the thread to stop; it does within a chunk of rays per core."""
        self._stop.set()

    def result(self) -> list[npt.NDArray[np.float32]]:
        """Transport per group.

        Raises:
            Cancelled: if the bake was stopped.
            PRTError, or any other error: what went wrong in the thread.
        """
        self._thread.join()
        if self._error is not None:
            raise self._error
        return self._result

    def _work(self, groups: list[ReceiverGroup], occluders: Occluders, threads: int) -> None:
        global _current
        run = Run(Workers(threads, self._advance), self._tell, _kept)
        try:
            self._result = bake_all(groups, occluders, self.settings, run)
        except BaseException as error:  # handed to the main thread by result()
            self._error = error
        finally:
            _current = None

    def _tell(self, group: ReceiverGroup, sentence: str) -> None:
        self.findings.append((group, sentence))

    def _advance(self, rays: int) -> None:
        self.done += rays
        if self._stop.is_set():
            raise Cancelled("The bake was cancelled; nothing was changed.")


_current: BakeJob | None = None
_kept = KeptTraces()


def running_job() -> BakeJob | None:
    """The bake that runs now, if one does."""
    return _current


def unregister() -> None:
    """Stop a bake that runs while the extension is disabled, and free what was kept."""
    job = running_job()
    if job:
        job.cancel()
        job.wait()
    _kept.clear()
