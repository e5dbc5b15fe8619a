# SPDX-License-Identifier: GPL-3.0-or-later
"""Workers run each chunk once, on all threads, and stop within a chunk."""

import threading
import time

import numpy as np
import pytest

from prt_addon.core.errors import Cancelled
from prt_addon.core.monitor import Work
from prt_addon.core.workers import Workers
from tests.core.baking import Noting


@pytest.mark.parametrize("threads", [1, 2, 5, None])
@pytest.mark.parametrize(("count", "chunk"), [(0, 4), (1, 4), (4, 4), (101, 7), (7, 1000)])
def test_every_item_once(count, chunk, threads):
    """Slices cover the range without gap or overlap, and the monitor sees all that was done."""
    visits, monitor = np.zeros(count, dtype=int), Noting()

    def work(part):
        assert 0 < part.stop - part.start <= chunk
        visits[part] += 1
        return Work(rays=3 * (part.stop - part.start))

    Workers(threads, monitor).run(count, chunk, work)
    assert (visits == 1).all()
    assert monitor.done == Work(rays=3 * count)
    assert monitor.calls == -(-count // chunk)


def test_progress_is_told_in_the_calling_thread():
    """It belongs to the caller, whose code need not be safe for threads; work is done elsewhere."""
    seen, workers = set(), set()

    def work(part):
        workers.add(threading.get_ident())

    Workers(2, Noting(lambda: seen.add(threading.get_ident()))).run(20, 1, work)
    assert seen == {threading.get_ident()}
    assert workers and not workers & seen


def test_cancel_stops_soon_and_comes_out():
    """Esc during an hour's bake: at most what was already queued still runs, and the reason is what was raised."""
    ran = []
    cancelled = Cancelled("stop")

    def work(part):
        ran.append(part.start)
        time.sleep(0.001)

    def stop():
        raise cancelled

    with pytest.raises(Cancelled) as caught:
        Workers(2, Noting(stop)).run(10_000, 1, work)
    assert caught.value is cancelled
    assert 1 <= len(ran) <= 4
    after = len(ran)
    time.sleep(0.01)
    assert len(ran) == after  # no thread is left behind


def test_cancel_drops_what_is_queued():
    """Chunks that no thread has begun are never begun: here both threads are busy with 1 and 2 when the end of 0 raises."""
    ran, release = [], threading.Event()

    def work(part):
        ran.append(part.start)
        if part.start:
            release.wait(10)

    def stop():
        threading.Timer(0.2, release.set).start()
        raise Cancelled("stop")

    with pytest.raises(Cancelled):
        Workers(2, Noting(stop)).run(10_000, 1, work)
    assert set(ran) <= {0, 1, 2}


def test_worker_exception_comes_out():
    """A failure in a thread must not pass for a finished bake, nor go on for long after it."""
    ran = []

    def work(part):
        ran.append(part.start)
        if part.start == 3:
            raise ZeroDivisionError("in chunk 3")

    with pytest.raises(ZeroDivisionError, match="in chunk 3"):
        Workers(2).run(10_000, 1, work)
    assert len(ran) < 20


def test_threads_run_at_once():
    """Two workers that wait for each other get past the barrier only together."""
    barrier = threading.Barrier(2, timeout=10)

    def work(part):
        barrier.wait()

    Workers(2).run(2, 1, work)
