# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures time, fairly: things that are compared run by turns, and their ratio is the median of the turns'.

Both clocks are given. On a machine with other work the ratio of processor seconds is the steadier one; what a thread waits
for shows on the wall clock alone.
"""

from __future__ import annotations

import resource
import statistics
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Seconds:
    """Of the wall clock, and of all cores together."""

    wall: float
    cpu: float

    def __add__(self, other: Seconds) -> Seconds:
        return Seconds(self.wall + other.wall, self.cpu + other.cpu)

    def __sub__(self, other: Seconds) -> Seconds:
        return Seconds(self.wall - other.wall, self.cpu - other.cpu)

    def over(self, other: Seconds) -> Seconds:
        """Ratio of each clock."""
        return Seconds(self.wall / other.wall, self.cpu / other.cpu)


NOTHING = Seconds(0.0, 0.0)


def now() -> Seconds:
    """Both clocks; that of the cores with the processes that this one has started and seen the end of."""
    ended = resource.getrusage(resource.RUSAGE_CHILDREN)
    return Seconds(time.perf_counter(), time.process_time() + ended.ru_utime + ended.ru_stime)


def timed(run: Callable[[], object]) -> Seconds:
    """What a call takes."""
    begun = now()
    run()
    return now() - begun


def by_turns(runs: Sequence[Callable[[], Seconds]], turns: int) -> list[list[Seconds]]:
    """Each turn's times of all runs, in their order; every second turn runs them backwards."""
    results = []
    for turn in range(turns):
        order = range(len(runs)) if turn % 2 == 0 else reversed(range(len(runs)))
        times = {k: runs[k]() for k in order}
        results.append([times[k] for k in range(len(runs))])
    return results


def median(times: Sequence[Seconds]) -> Seconds:
    """Of each clock."""
    return Seconds(statistics.median(t.wall for t in times), statistics.median(t.cpu for t in times))


def ratio(turns: list[list[Seconds]], one: int, other: int) -> Seconds:
    """Median over the turns of one run's time over another's."""
    return median([times[one].over(times[other]) for times in turns])


def exponent(sizes: Sequence[float], times: Sequence[float]) -> float:
    """The power of the size that time grows with: the slope of the line fitted through the logarithms."""
    return float(np.polyfit(np.log(sizes), np.log(times), 1)[0])
