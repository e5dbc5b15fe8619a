# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs the jobs of operators that bake: to the end from a script, behind a live window from the button."""

import signal
import time
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

import bpy

from ..prt_addon.core.errors import Interrupted
from ..prt_addon.core.notices import Notice, counted
from ..prt_addon.scene.blender.areas import redraw_panels
from ..prt_addon.session import session
from ..prt_addon.worker.job import Job, end_engine, running_job, wake_engine
from .progress import ctrl_c, interrupt_once, terminal_bar
from .reporting import reports_errors

TICK = 0.02
"""Seconds between two looks at a job: a scene goes to the engine, and a preview comes back, a piece at each."""

_PAUSE = 0.1  # seconds between two words about progress


class WhenIdle:
    """Mixin of operators that are refused while a bake runs."""

    if TYPE_CHECKING:  # what every operator has
        poll_message_set: Any

    @classmethod
    def poll(cls, _context: bpy.types.Context) -> bool:
        if running_job() or session.timer:
            cls.poll_message_set("A bake is running: wait for it, or cancel it")
            return False
        return True


class JobOperator(WhenIdle):
    """Mixin of operators that work in a `Job` of the engine. They say how it begins and what is done with its result.

    They are not for the redo panel (no REGISTER): it shows their defaults in place of the scene's settings, and bakes again,
    while the window waits, whenever it is touched.
    """

    _activity = "Baking PRT"
    """What the status bar calls it."""
    _job: Job[Any] | None = None
    _warnings = 0
    _told = 0.0
    _is_watched = False
    """Whether someone looks at the window meanwhile."""
    if TYPE_CHECKING:  # what every operator has
        report: Any

    def _begin(self, context: bpy.types.Context) -> Job[Any] | None:
        """Read all that the job needs; whatever is wrong is said before any work. None if there is nothing to do."""
        raise NotImplementedError

    def _end(self, context: bpy.types.Context, result: Any) -> None:
        """Use the result of the job."""
        raise NotImplementedError

    def _look(self, context: bpy.types.Context) -> None:
        """Do what there is to be done while the job goes on; whatever this raises ends it."""

    def _abandon(self) -> None:
        """End the job without a result, and leave nothing of it behind."""
        if self._job and self._job.running:
            end_engine()

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Work to the end: for scripts and background."""
        with ctrl_c(interrupt_once):
            state = self._run(context)
        with ctrl_c(signal.SIG_IGN):  # too late: half a result must not stay
            if state == {"RUNNING_MODAL"}:
                state = self._finish(context)
            if state == {"CANCELLED"}:
                self._abandon()
        return state

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        """Work behind a live window: for the button. The scene is read when the window says so."""
        if bpy.app.background:
            return self.execute(context)
        self._is_watched = True
        context.workspace.status_text_set("PRT: reading the scene")
        session.timer = context.window_manager.event_timer_add(TICK, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Look after the job: begin it, draw its progress, stop it on Esc, take its result."""
        if event.type == "ESC" and event.value == "PRESS" and self._job:
            self._job.cancel()
            return {"RUNNING_MODAL"}  # the next tick ends it
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        state = {"CANCELLED"}
        try:
            state = self._step(context)
        finally:
            if state == {"CANCELLED"}:
                self._abandon()
            if state != {"RUNNING_MODAL"}:
                stop_watching(context)
        return state

    def cancel(self, context: bpy.types.Context) -> None:
        """Blender ends the operator itself: another file is loaded, or the window closes."""
        self._abandon()
        stop_watching(context)

    def _warn(self, warnings: Iterable[str]) -> None:
        """Report them, and remember that there were some."""
        for warning in warnings:
            self._warnings += 1
            self.report({"WARNING"}, warning)

    def _say(self, context: bpy.types.Context, notices: Iterable[Notice]) -> None:
        """Report notices, counted by kind, and keep them for the panel."""
        session.notices[context.scene.session_uid] = found = counted(notices)
        self._warn(one.sentence for one in found if one.kind.level == "WARNING")
        for one in found:
            if one.kind.level == "INFO":
                self.report({"INFO"}, one.sentence)

    def _conclude(self, sentence: str) -> None:
        """The last word, which the status bar shows in place of all before it."""
        if self._warnings:
            sentence += f" {self._warnings} warning{'s' * (self._warnings > 1)}: see the Info editor."
        self.report({"INFO"}, sentence)

    def _step(self, context: bpy.types.Context) -> set[str]:
        """What is to be done at each tick."""
        if self._job:
            self._job.step()
            if not self._job.running:
                return self._finish(context)
        state = self._watch(context) if self._job else self._start(context)
        if self._job and time.monotonic() > self._told + _PAUSE:
            self._told = time.monotonic()
            context.workspace.status_text_set(f"{self._activity}: {self._job.text}  (Esc cancels)")
            redraw_panels()
        return state

    @reports_errors
    def _start(self, context: bpy.types.Context) -> set[str]:
        wake_engine()  # meanwhile the scene is read
        job = self._begin(context)
        if job is None:
            return {"CANCELLED"}
        job.start()
        self._job = job
        return {"RUNNING_MODAL"}

    @reports_errors
    def _watch(self, context: bpy.types.Context) -> set[str]:
        self._look(context)
        return {"RUNNING_MODAL"}

    @reports_errors
    def _run(self, context: bpy.types.Context) -> set[str]:
        """Start and wait for the end."""
        try:
            started = self._start(context)
            if self._job:
                _watch_on_terminal(self._job, lambda: self._look(context))
        except KeyboardInterrupt:
            end_engine()  # whatever it receives or sends is cut off
            raise Interrupted("Interrupted; nothing was changed.") from None
        return started

    @reports_errors
    def _finish(self, context: bpy.types.Context) -> set[str]:
        assert self._job
        self._end(context, self._job.result())
        return {"FINISHED"}


class PRT_OT_cancel(bpy.types.Operator):
    """Stop the bake or report that runs; meshes, materials and world stay as they are"""

    bl_idname = "prt.cancel"
    bl_label = "Cancel Bake"
    bl_options = {"INTERNAL"}

    @classmethod
    def poll(cls, _context: bpy.types.Context) -> bool:
        if running_job():
            return True
        cls.poll_message_set("No bake is running")
        return False

    def execute(self, _context: bpy.types.Context) -> set[str]:
        job = running_job()
        if job:
            job.cancel()
        return {"FINISHED"}


def stop_watching(context: bpy.types.Context) -> None:
    """Remove the timer and the status bar's text, if an operator watches a job."""
    if session.timer is None:
        return
    context.window_manager.event_timer_remove(session.timer)
    session.timer = None
    if context.workspace:
        context.workspace.status_text_set(None)
    redraw_panels()


def redraw_views(context: bpy.types.Context) -> None:
    """Redraw the views, as there is something new to see in them."""
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()


def _watch_on_terminal(job: Job[Any], look: Callable[[], None]) -> None:
    """Wait for the end, looking now and then; with a progress bar where someone can see it: on a terminal, in background."""
    bar = terminal_bar(job.work.rays, job.unit)
    while job.running:
        job.wait(_PAUSE)
        if job.running:
            look()
        if bar is not None:
            bar.set_postfix_str(
                "bouncing light" if job.done.rays == job.work.rays and job.running else "", refresh=False
            )
            bar.update(job.done.rays - bar.n)
    if bar is not None:
        bar.close()


CLASSES = (PRT_OT_cancel,)
