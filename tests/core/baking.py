# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes one island, for tests of a bake's settings and its run; a monitor that notes what it sees."""

from prt_addon.core.bake import bake as engine
from prt_addon.core.bake.run import DEFAULT_RUN
from prt_addon.core.bake.trace import trace_island
from prt_addon.core.monitor import Monitor, Work
from prt_addon.core.problem import BakeProblem, Island


def bake(groups, occluders, settings, run=DEFAULT_RUN):
    """The transport of each group."""
    return engine.bake(BakeProblem.of(groups, occluders, settings), run).transport


def trace_all(groups, occluders, settings, run=DEFAULT_RUN):
    """What their rays find."""
    return trace_island(Island(groups, occluders), settings, run)


class Noting(Monitor):
    """Adds up the work that is done, and may do something whenever it is called."""

    def __init__(self, act=lambda: None):
        self.done, self.calls, self._act = Work(), 0, act

    def advance(self, work):
        self.done += work
        self.calls += 1
        self._act()

    def check_cancelled(self):
        self.calls += 1
        self._act()
