# SPDX-License-Identifier: GPL-3.0-or-later
"""Shows how far work is that a script or the command line waits for, and has Ctrl-C end it."""

from __future__ import annotations

import signal
import sys
from collections.abc import Generator, Iterator
from contextlib import closing, contextmanager
from typing import Any

import bpy

from ..prt_addon.core.errors import Interrupted


@contextmanager
def interruptible(work: Generator[None], count: int, unit: str) -> Iterator[Iterator[None]]:
    """Hold an iterator over the steps of some work: it shows the share that is done, at the cursor or on the terminal.

    In background Ctrl-C ends the work after the step at hand, with `Interrupted`; whatever ends it, it is closed.
    """
    manager, bar = bpy.context.window_manager, terminal_bar(count, unit)
    pressed: list[int] = []  # signals of Ctrl-C

    def passing() -> Iterator[None]:
        for number, _ in enumerate(work):
            manager.progress_update(number)
            if bar is not None:
                bar.update()
            if pressed:
                raise Interrupted("Interrupted; nothing was changed.")
            yield

    manager.progress_begin(0, count)
    try:
        with closing(work), ctrl_c(lambda number, _frame: pressed.append(number)):
            yield passing()
    finally:
        manager.progress_end()
        if bar is not None:
            bar.close()


@contextmanager
def ctrl_c(handler: Any) -> Iterator[None]:
    """How Ctrl-C is answered in background, where the Blender application has an answer that Python never hears of."""
    if not bpy.app.background:
        yield
        return
    try:
        before = signal.signal(signal.SIGINT, handler)
    except ValueError:  # a script's own thread, which no signal reaches
        yield
        return
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before or signal.SIG_DFL)


def interrupt_once(_signal: int, _frame: Any) -> None:
    """A handler: a second Ctrl-C must not break what the first one began."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    raise KeyboardInterrupt


def terminal_bar(total: int, unit: str) -> Any:
    """A progress bar where someone can see it: on a terminal, in background. None elsewhere."""
    if not bpy.app.background:
        return None
    try:
        from tqdm import tqdm
    except ImportError:  # run from a checkout by a Blender without it: work all the same
        return None

    class Bar(tqdm):  # type: ignore[type-arg]
        monitor_interval = 0  # or it starts a thread that outlives the work

    return Bar(total=total, unit=unit, unit_scale=True, desc="PRT", file=sys.stderr, disable=None)
