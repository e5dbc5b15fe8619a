# SPDX-License-Identifier: GPL-3.0-or-later
"""The only owner of `bpy.app.handlers`. What the light follows needs none; these keep pace with what cannot be driven."""

from __future__ import annotations

import bpy
from bpy.app.handlers import persistent

from .scene.shading import follow_base_colour


@persistent
def _on_edit(_scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    """A base colour that is a plain number was edited: the relit surface takes it over."""
    for update in depsgraph.updates:
        if isinstance(update.id, bpy.types.Material):
            follow_base_colour(update.id.original)


@persistent
def _on_frame(_scene: bpy.types.Scene, _depsgraph: bpy.types.Depsgraph) -> None:
    """The same for one that is keyframed: changing the frame reports no single updates."""
    for material in bpy.data.materials:
        if material.node_tree and material.node_tree.animation_data:
            follow_base_colour(material)


_HANDLERS = ((bpy.app.handlers.depsgraph_update_post, _on_edit), (bpy.app.handlers.frame_change_post, _on_frame))


def register() -> None:
    for handlers, handler in _HANDLERS:
        handlers.append(handler)


def unregister() -> None:
    for handlers, handler in _HANDLERS:
        handlers.remove(handler)
