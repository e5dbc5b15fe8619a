# SPDX-License-Identifier: GPL-3.0-or-later
"""Sets up Blender's own bake of a mesh, alone in a scene of its own: how Cycles evaluates colours and skies.

All of it is removed again: selection, engine and data-blocks of the file stay what they were.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import bpy

from .rna import plain_properties


@contextmanager
def cycles_scene(name: str) -> Iterator[bpy.types.Scene]:
    """An empty scene for Cycles, at the frame, and with the threads and the shading system, of the one that is open.

    Raises:
        TypeError: if Cycles is disabled.
    """
    here = bpy.context.scene
    scene = bpy.data.scenes.new(name)
    try:
        scene.render.engine = "CYCLES"
        scene.cycles.samples = 1  # colours are exact with one
        scene.cycles.device = "CPU"
        scene.cycles.shading_system = here.cycles.shading_system
        scene.render.threads_mode, scene.render.threads = here.render.threads_mode, here.render.threads
        scene.frame_current = here.frame_current
        for owner in (here.world, here, bpy.context.view_layer):  # as Attribute nodes look: the nearest last
            for key, value in plain_properties(owner).items() if owner else ():
                scene[key] = value
        yield scene
    finally:
        bpy.data.scenes.remove(scene)


@contextmanager
def selected_alone(scene: bpy.types.Scene, mesh: bpy.types.Mesh) -> Iterator[bpy.types.Object]:
    """An object with `mesh` as all that stands in a scene, selected and active in the context."""
    stand_in = bpy.data.objects.new(scene.name, mesh)
    try:
        scene.collection.objects.link(stand_in)
        layer = scene.view_layers[0]
        stand_in.select_set(True, view_layer=layer)
        layer.objects.active = stand_in
        chosen = {"selected_objects": [stand_in], "selected_editable_objects": [stand_in]}
        with bpy.context.temp_override(
            scene=scene, view_layer=layer, object=stand_in, active_object=stand_in, **chosen
        ):
            yield stand_in
    finally:
        bpy.data.objects.remove(stand_in)
