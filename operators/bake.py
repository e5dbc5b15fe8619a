# SPDX-License-Identifier: GPL-3.0-or-later
"""The bake: transport of the chosen meshes, the world's light and the shading, in one go."""

import sys
from typing import Any

import bpy
from bpy.props import BoolProperty

from ..prt_addon.bake_job import BakeJob, running_job
from ..prt_addon.core import raycast
from ..prt_addon.core.errors import MeshError
from ..prt_addon.scene import gather, light, prepare, projection, shading, sky, transport_layers
from ..prt_addon.scene.modes import object_mode
from ..prt_addon.scene.settings import (
    BakeProperties,
    LightProperties,
    PrepareProperties,
    bake_settings,
    preparation,
    windowing,
)
from .reporting import reports_errors


class PRT_OT_bake(BakeProperties, PrepareProperties, LightProperties, bpy.types.Operator):
    """Bake how light travels over the selected meshes (all render-visible ones if none is selected), so that any sky can relight them"""

    bl_idname = "prt.bake"
    bl_label = "Bake PRT"
    bl_options = {"REGISTER", "UNDO"}

    update_light: BoolProperty(  # type: ignore[valid-type]
        name="Project World", description="Also project the world's sky into the SH light", default=True
    )
    update_shading: BoolProperty(  # type: ignore[valid-type]
        name="Add Shading", description="Also relight the materials in EEVEE", default=True
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if running_job():
            cls.poll_message_set("A bake is running: wait for it, or cancel it")
            return False
        return True

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        """Bake to the end: for scripts and background."""
        self._prepare(context)
        self._job.start()
        try:
            _watch_on_terminal(self._job)
        except KeyboardInterrupt:
            self._job.cancel()
        return self._finish(context)

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        """Bake behind a live window: for the button."""
        return self.execute(context) if bpy.app.background else self._begin_modal(context)

    @reports_errors
    def _begin_modal(self, context: bpy.types.Context) -> set[str]:
        self._prepare(context)
        manager = context.window_manager
        self._timer = manager.event_timer_add(0.1, window=context.window)
        manager.modal_handler_add(self)
        self._job.start()
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Look after the job: draw its progress, stop it on Esc, take its result."""
        if event.type == "ESC" and event.value == "PRESS":
            self._job.cancel()
            return {"RUNNING_MODAL"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        _show_progress(context, self._job)
        if self._job.running:
            return {"RUNNING_MODAL"}
        self._stop_watching(context)
        return self._finish(context)

    def cancel(self, context: bpy.types.Context) -> None:
        """Blender ends the operator itself: another file is loaded, or the window closes."""
        self._job.cancel()
        self._job.wait()
        self._stop_watching(context)

    def _prepare(self, context: bpy.types.Context) -> None:
        """Check everything and read the scene; whatever is wrong is said before any work."""
        settings = bake_settings(context.scene, self)
        if settings.mode != "UNSHADOWED":
            raycast.require()
        objects = gather.objects_to_bake(context)
        if self.update_shading:
            shading.check_materials(objects)
        self._light = None
        if self.update_light:
            self._light = projection.project(sky.read_sky(context.scene), windowing(context.scene, self))
        self._allowed = preparation(context.scene, self)
        with object_mode(context):
            plan = gather.gather(context, objects, settings.mode == "INTERREFLECTED", self._allowed)
        for warning in plan.warnings:
            self.report({"WARNING"}, warning)
        self._names = [ob.name_full for ob in objects]
        self._receivers, self._evidence = plan.receivers, plan.evidence
        self._job = BakeJob(plan.groups, plan.occluders, settings, context.scene.render.threads)

    @reports_errors
    def _finish(self, context: bpy.types.Context) -> set[str]:
        """Write everything, now that the whole bake is there."""
        results = self._job.result()
        objects = [_still_there(name) for name in self._names]
        environment = sky.read_sky(context.scene) if self._light is not None else None  # refuses before writing
        with object_mode(context):
            with prepare.own_meshes(context, objects, self._allowed) as own:
                for ob, receivers in zip(objects, self._receivers, strict=True):
                    gather.check_unchanged(ob, own.mesh_of(ob), receivers)
            for ob, receivers, transport, evidence in zip(
                objects, self._receivers, results, self._evidence, strict=False
            ):
                transport_layers.write(
                    ob.data,
                    receivers.domain,
                    transport,
                    receivers.element_receiver,
                    self._job.settings,
                    "OBJECT" if receivers.group.own else "SCENE",
                    evidence,
                )
        if environment and self._light is not None:
            light.write_light(environment, self._light)
            for sentence in self._light.sentences:
                self.report({"INFO"}, sentence)
        if self.update_shading:
            for warning in shading.add_shading(objects):
                self.report({"WARNING"}, warning)
        for group, finding in self._job.findings:
            if any(group is receivers.group for receivers in self._receivers):  # not of those that only bounce light
                self.report({"INFO"}, finding)
        for note in own.notes:
            self.report({"INFO"}, note)
        count = sum(len(receivers.group) for receivers in self._receivers)
        self.report({"INFO"}, f"Baked {len(objects)} object(s), {count:,} receivers, {self._job.total:,} rays.")
        return {"FINISHED"}

    def _stop_watching(self, context: bpy.types.Context) -> None:
        context.window_manager.event_timer_remove(self._timer)
        context.workspace.status_text_set(None)
        _redraw(context)


class PRT_OT_cancel(bpy.types.Operator):
    """Stop the bake that runs; meshes, materials and world stay as they are"""

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


def progress_text(job: BakeJob) -> str:
    """One line for panel and status bar."""
    if job.done == job.total:
        return "100%  bouncing light"
    return f"{job.progress:.0%}  {job.rays_per_second / 1e6:.1f} Mrays/s  {job.seconds_left:.0f} s left"


def _still_there(name: str) -> bpy.types.Object:
    ob = bpy.data.objects.get(name)
    if ob is None:
        raise MeshError(f"Object '{name}' was removed or renamed during the bake; nothing was changed.")
    return ob


def _show_progress(context: bpy.types.Context, job: BakeJob) -> None:
    context.workspace.status_text_set(f"Baking PRT: {progress_text(job)}  (Esc cancels)")
    _redraw(context)


def _redraw(context: bpy.types.Context) -> None:
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()


def _watch_on_terminal(job: BakeJob) -> None:
    """A progress bar where someone can see it: on a terminal, in background."""
    bar = _progress_bar(job.total) if bpy.app.background else None
    while job.running:
        job.wait(0.1)
        if bar is not None:
            bar.update(job.done - bar.n)
    if bar is not None:
        bar.close()


def _progress_bar(total: int) -> Any:
    try:
        from tqdm import tqdm
    except ImportError:  # run from a checkout by a Blender without it: bake all the same
        return None
    return tqdm(total=total, unit="ray", unit_scale=True, desc="PRT", file=sys.stderr, disable=None)


CLASSES = (PRT_OT_bake, PRT_OT_cancel)
