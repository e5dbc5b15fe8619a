# SPDX-License-Identifier: GPL-3.0-or-later
"""Chunks of work on a thread pool, with progress, and a stop that takes effect within a chunk."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from concurrent.futures import Future

Progress = Callable[[int], None]
"""Called in the baking thread with the number of rays done since the last call; may raise Cancelled."""


def ignore_progress(_rays: int) -> None:
    """The progress of someone who does not watch."""


@dataclass(frozen=True)
class Workers:
    """Threads that share the work, and who watches them: nothing that a result depends on.

    threads: how many; all cores if None or 0. One works in the thread that gives the work.
    progress: called in the thread that gives the work; what it raises stops the work and comes out there.
    """

    threads: int | None = None
    progress: Progress = ignore_progress

    def run(self, count: int, chunk: int, work: Callable[[slice], int]) -> None:
        """Run `work` over slices that cover range(count).

        Chunks write to places of their own, so the result does not depend on their size, order or thread. The ray
        caster and NumPy release the GIL: threads scale.

        Args:
            count: number of items.
            chunk: items per call.
            work: called with a slice, in any thread of these; returns the rays it cast, which `progress` is told.
        """
        threads = self.threads or os.cpu_count() or 1
        starts = iter(range(0, count, chunk))
        if threads == 1:
            for start in starts:
                self.progress(work(slice(start, min(start + chunk, count))))
            return
        from concurrent.futures import (
            ThreadPoolExecutor,  # not in Blender's process, where no thread of ours has a place
        )

        pending: deque[Future[int]] = deque()
        with ThreadPoolExecutor(threads, thread_name_prefix="prt-bake") as pool:

            def submit_next() -> None:
                for start in starts:
                    pending.append(pool.submit(work, slice(start, min(start + chunk, count))))
                    return

            for _ in range(2 * threads):  # enough to keep the pool fed, few enough to stop soon
                submit_next()
            try:
                while pending:
                    self.progress(pending.popleft().result())
                    submit_next()
            finally:
                for future in pending:
                    future.cancel()


ALL_CORES = Workers()
"""All cores, and nobody who watches."""

IN_LINE = Workers(1)
"""For work in Blender's own process, where the extension starts no thread."""
