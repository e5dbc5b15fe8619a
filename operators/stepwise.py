# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs work that is done inside Blender, step by step: behind a live window once a dialog is confirmed, to the end from
a script.
"""

from __future__ import annotations

import time
from collections.abc import Generator
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import bpy

from ..prt_addon.core.errors import CANCELLED
from ..prt_addon.scene.settings import begin_with_settings
from ..prt_addon.session import session
from .job import WhenIdle, stop_watching
from .progress import interruptible
from .reporting import reports_errors

_TICK = 0.02  # seconds between two turns
_TURN = 0.1  # seconds of work at a time: then the window is drawn


@dataclass
class Steps:
    """Work that has come to a step at each `yield`, and writes after the last one.

    Closed early, it leaves everything as it was.
    """

    work: Generator[None]
    count: int
    done: int = 0

    def go_on(self, seconds: float) -> bool:
        """Work for so long, one step at least; returns whether there is more to do."""
        end = time.monotonic() + seconds
        while True:
            try:
                next(self.work)
            except StopIteration:
                return False
            self.done += 1
            if time.monotonic() >= end:
                return True


class StepwiseOperator(WhenIdle):
    """Mixin of operators that work in `Steps`. In the window nothing can be edited meanwhile: the work reads the scene."""

    _activity = ""
    """What the status bar calls it."""
    _unit = "step"
    _confirmed_in_window = False
    _steps: Steps
    if TYPE_CHECKING:  # what every operator has
        report: Any

    def _begin(self, context: bpy.types.Context) -> Steps:
        """Check what can be checked before any work."""
        raise NotImplementedError

    def _end(self, context: bpy.types.Context) -> None:
        """Say what was done."""
        raise NotImplementedError

    def _open_dialog(self, context: bpy.types.Context) -> set[str]:
        """Open the operator's dialog; once it is confirmed the work goes on behind a live window."""
        begin_with_settings(self, context.scene)
        self._confirmed_in_window = not bpy.app.background
        return set(context.window_manager.invoke_props_dialog(self))

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        """Begin, and from a script go on to the end."""
        self._steps = steps = self._begin(context)
        if self._confirmed_in_window:
            session.timer = context.window_manager.event_timer_add(_TICK, window=context.window)
            context.window_manager.modal_handler_add(self)
            return {"RUNNING_MODAL"}
        with interruptible(steps.work, steps.count, f" {self._unit}s") as passing:
            for _ in passing:
                pass
        self._end(context)
        return {"FINISHED"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Work at each tick, draw the progress, stop on Esc. All other events end here."""
        if event.type == "ESC" and event.value == "PRESS":
            self.cancel(context)
            self.report({"WARNING"}, CANCELLED)
            return {"CANCELLED"}
        if event.type != "TIMER":
            return {"RUNNING_MODAL"}
        state = {"CANCELLED"}
        try:
            state = self._go_on(context)
        finally:
            if state != {"RUNNING_MODAL"}:
                self.cancel(context)
        return state

    def cancel(self, context: bpy.types.Context) -> None:
        """Release everything; also called by Blender, when it ends the operator itself."""
        with suppress(ReferenceError):  # another file: what would be put back has gone
            self._steps.work.close()
        stop_watching(context)

    @reports_errors
    def _go_on(self, context: bpy.types.Context) -> set[str]:
        if self._steps.go_on(_TURN):
            done = f"{self._unit} {self._steps.done} of {self._steps.count}"
            context.workspace.status_text_set(f"{self._activity}: {done}  (Esc cancels)")
            return {"RUNNING_MODAL"}
        self._end(context)
        return {"FINISHED"}
