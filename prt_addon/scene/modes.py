# SPDX-License-Identifier: GPL-3.0-or-later
"""Working in Object Mode whatever mode the person is in, and leaving them where they were."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import bpy


@contextmanager
def object_mode(context: bpy.types.Context) -> Iterator[None]:
    """Object Mode inside, the mode before outside: meshes in Edit Mode hide their attributes."""
    active = context.view_layer.objects.active
    mode = active.mode if active else "OBJECT"
    if mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")
    try:
        yield
    finally:
        if mode != "OBJECT":
            bpy.ops.object.mode_set(mode=mode)
