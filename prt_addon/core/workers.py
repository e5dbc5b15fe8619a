# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs chunks of work on a thread pool that reports to a monitor and stops within a chunk."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from .monitor import UNWATCHED, Monitor, Work

if TYPE_CHECKING:
    from concurrent.futures import Future


@dataclass(frozen=True)
class Workers:
    """Threads that share the work, and the monitor that watches them: nothing that a result depends on.

    Attributes:
        threads: how many; all cores if None or 0. One works in the thread that gives the work.
        monitor: called in the thread that gives the work; what it raises stops the work and comes out there.
    """

    threads: int | None = None
    monitor: Monitor = UNWATCHED

    def run(self, count: int, chunk: int, work: Callable[[slice], Work | None]) -> None:
        """Run `work` over slices that cover range(count).

        Chunks write to places of their own, so the result does not depend on their size, order or thread. The ray
        caster and NumPy release the GIL: threads scale.

        Args:
            count: number of items.
            chunk: items per call.
            work: called with a slice, in any of the threads; returns what of the monitored work it did, if any.
        """
        threads = self.threads or os.cpu_count() or 1
        starts = iter(range(0, count, chunk))
        if threads == 1:
            for start in starts:
                self._note(work(slice(start, min(start + chunk, count))))
            return
        from concurrent.futures import (
            ThreadPoolExecutor,  # not in Blender's process, where no thread of ours has a place
        )

        pending: deque[Future[Work | None]] = deque()
        with ThreadPoolExecutor(threads, thread_name_prefix="prt-bake") as pool:

            def submit_next() -> None:
                """Give the pool one more chunk, if one is left."""
                for start in starts:
                    pending.append(pool.submit(work, slice(start, min(start + chunk, count))))
                    return

            for _ in range(2 * threads):  # enough to keep the pool fed, few enough to stop soon
                submit_next()
            try:
                while pending:
                    self._note(pending.popleft().result())
                    submit_next()
            finally:
                for future in pending:
                    future.cancel()

    def _note(self, done: Work | None) -> None:
        if done:
            self.monitor.advance(done)
        else:
            self.monitor.check_cancelled()


class _Uncounted(Monitor):
    """Passes a wish to stop on, and no work."""

    def __init__(self, monitor: Monitor) -> None:
        self._monitor = monitor

    def advance(self, _work: Work) -> None:
        """Pass a wish to stop on; the work is not counted."""
        self._monitor.check_cancelled()

    def check_cancelled(self) -> None:
        """Pass a wish to stop on."""
        self._monitor.check_cancelled()


def uncounted(workers: Workers) -> Workers:
    """The same workers for work that the total of what is monitored does not hold."""
    return Workers(workers.threads, _Uncounted(workers.monitor))


ALL_CORES = Workers()
"""All cores, unwatched."""

IN_LINE = Workers(1)
"""For work in Blender's own process, where the extension starts no thread."""
