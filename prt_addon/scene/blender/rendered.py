# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads the scene as its renders show it: modifiers at render level, what the viewport hides, instances, background
sets.

Blender hands that state of a scene to render engines only. So a render engine of ours renders a frame of 16 x 16
pixels (fewer are refused where the output is a movie), and reads instead of drawing: milliseconds, and the same on every
machine. Engine, resolution, camera, handlers, the last picture and values that are not keyed yet are afterwards what
they were.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from typing import Any, TypeVar

import bpy

from ...core.errors import RenderError
from .unkeyed import unkeyed_values

Value = TypeVar("Value")

_ENGINE = "PRT_READER"
_PICTURE = "Render Result"
_SLOT = "PRT"
_SETTINGS: dict[str, object] = {
    "engine": _ENGINE,
    "resolution_x": 16,
    "resolution_y": 16,
    "resolution_percentage": 100,
    "use_border": False,
    "use_compositing": False,
    "use_sequencer": False,
    "use_multiview": False,
    "use_freestyle": False,
}
_SILENT = ("frame_change_pre", "frame_change_post")
"""Handlers beside those of renders: they have done their work for this frame already."""


class _Reading:
    """One call of a function with a depsgraph: what came out of it."""

    def __init__(self, read: Callable[[bpy.types.Depsgraph], Any]) -> None:
        self.read = read
        self.found: list[Any] = []
        self.failed: BaseException | None = None


class _Reader(bpy.types.RenderEngine):
    """Reads and draws nothing. Registered while it reads, so that no menu shows it."""

    bl_idname = _ENGINE
    bl_label = "PRT Reader"

    reading: _Reading  # no ClassVar: registering evaluates it, and typing would remember what it was of
    """Here for as long as it is registered: Blender makes the engine, and gives it nothing but the depsgraph."""

    def render(self, depsgraph: bpy.types.Depsgraph) -> None:
        try:
            _Reader.reading.found.append(_Reader.reading.read(depsgraph))
        except BaseException as error:  # Blender would print it, and go on
            _Reader.reading.failed = error


def as_rendered(context: bpy.types.Context, read: Callable[[bpy.types.Depsgraph], Value]) -> Value:
    """Call a function with the depsgraph that renders of a context's scene and view layer see.

    Args:
        context: whose scene and view layer are rendered.
        read: gets the dependency graph, which is gone when it returns. It may add data-blocks, but must call no operator.

    Raises:
        RenderError: if Blender renders already.
        Exception: whatever `read` raises.
    """
    if bpy.app.is_job_running("RENDER"):
        raise RenderError("A render is running, and Blender runs one at a time: wait for it, then try again.")
    scene, layer = context.scene, context.view_layer
    reading = _Reading(read)
    with ExitStack() as meanwhile:
        for change in (_handlers_silenced(), picture_kept(), unkeyed_values(context), _registered(reading)):
            meanwhile.enter_context(change)
        meanwhile.enter_context(_with(scene.render, _SETTINGS))
        meanwhile.enter_context(_with(layer, {"use": True}))
        meanwhile.enter_context(_camera(scene))
        bpy.ops.render.render("EXEC_DEFAULT", scene=scene.name, layer=layer.name)
    if reading.failed:
        raise reading.failed
    if not reading.found:
        raise RenderError(f"Blender could not evaluate scene '{scene.name}' for rendering: render it once to see why.")
    found: Value = reading.found.pop()
    return found


@contextmanager
def _registered(reading: _Reading) -> Iterator[None]:
    _Reader.reading = reading
    bpy.utils.register_class(_Reader)
    try:
        yield
    finally:
        bpy.utils.unregister_class(_Reader)
        del _Reader.reading


@contextmanager
def _with(owner: bpy.types.bpy_struct, settings: dict[str, object]) -> Iterator[None]:
    """Other settings inside. What is set already is not set again: that would count as an edit."""
    before = {name: getattr(owner, name) for name in settings}
    changed = {name: value for name, value in settings.items() if before[name] != value}
    for name, value in changed.items():
        setattr(owner, name, value)
    try:
        yield
    finally:
        for name in reversed(changed):
            setattr(owner, name, before[name])


@contextmanager
def _camera(scene: bpy.types.Scene) -> Iterator[None]:
    """A scene without a camera gets one meanwhile. Markers may switch cameras on each frame: that is undone, too."""
    before, data = scene.camera, None
    if before is None:
        data = bpy.data.cameras.new("PRT")
        scene.camera = bpy.data.objects.new("PRT", data)
    try:
        yield
    finally:
        if data:
            bpy.data.objects.remove(scene.camera)
            bpy.data.cameras.remove(data)
        if scene.camera != before:
            scene.camera = before


@contextmanager
def _handlers_silenced() -> Iterator[None]:
    """Silence handlers: scripts take the frame for a real one otherwise."""
    names = [name for name in dir(bpy.app.handlers) if name.startswith("render_")]
    lists: Sequence[list[Any]] = [getattr(bpy.app.handlers, name) for name in (*names, *_SILENT)]
    before = [list(handlers) for handlers in lists]
    for handlers in lists:
        handlers.clear()
    try:
        yield
    finally:
        for handlers, former in zip(lists, before, strict=True):
            handlers.extend(former)


@contextmanager
def picture_kept() -> Iterator[None]:
    """Keep the user's last render: ours goes into a slot of its own, which can be found again but not removed."""
    picture = bpy.data.images.get(_PICTURE)
    slots = picture.render_slots if picture else None
    active = slots.active_index if slots else 0
    if slots:
        names = [slot.name for slot in slots]
        if _SLOT not in names:
            slots.new(name=_SLOT)
            names.append(_SLOT)
        slots.active_index = names.index(_SLOT)
    try:
        yield
    finally:
        if slots:
            slots.active_index = active
        elif made := bpy.data.images.get(_PICTURE):
            bpy.data.images.remove(made)
