# SPDX-License-Identifier: GPL-3.0-or-later
"""Switches to Object Mode, or to the scene that a job was begun in, and leaves users where they were."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import bpy

from ...core.errors import MeshError


@contextmanager
def object_mode(context: bpy.types.Context) -> Iterator[None]:
    """Work in Object Mode, and return to the mode before: meshes in Edit Mode hide their attributes."""
    active = context.view_layer.objects.active
    mode = active.mode if active else "OBJECT"
    if mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")
    try:
        yield
    finally:
        if mode != "OBJECT":
            bpy.ops.object.mode_set(mode=mode)


@dataclass(frozen=True)
class Place:
    """The scene and view layer that a job was begun in: by the time it ends, the window may show another."""

    scene: str
    layer: str

    @classmethod
    def of(cls, context: bpy.types.Context) -> Place:
        """The place that a context shows."""
        return cls(context.scene.name, context.view_layer.name)

    @contextmanager
    def again(self, context: bpy.types.Context) -> Iterator[None]:
        """Work in that place once more.

        Raises:
            MeshError: if it is gone.
        """
        scene = found_again(bpy.data.scenes, "Scene", self.scene)
        layer = found_again(scene.view_layers, "View layer", self.layer)
        if context.scene == scene and context.view_layer == layer:
            yield
            return
        with context.temp_override(scene=scene, view_layer=layer):
            yield


def by_uid(collection: Any, uid: int) -> Any:
    """Find a data-block of this session, whatever its name is by now; None if it is no more. Undo keeps it."""
    return next((block for block in collection if block.session_uid == uid), None)


def found_again(collection: Any, kind: str, name: str) -> Any:
    """Find a data-block again that was there when a job began.

    Raises:
        MeshError: if it is no more.
    """
    found = collection.get(name)
    if found is None:
        raise MeshError(f"{kind} '{name}' was removed or renamed meanwhile; nothing was changed.")
    return found
