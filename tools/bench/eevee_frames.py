# SPDX-License-Identifier: GPL-3.0-or-later
"""Times EEVEE's frames of relit materials beside the user's own alone, by turns, and the first frames of a process, which wait for
shaders to be compiled. Import `headless` first.

A third material has EEVEE light the user's surface and, in *Shader to RGB*, a white one more: no way to tell lamps from the sky in
a shader costs less.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import asdict
from functools import partial
from math import radians
from pathlib import Path
from typing import Any

import blender_scene
import bpy
import headless
import numpy as np
from measure import Seconds, by_turns, median, ratio, timed

_SIZE = 256  # pixels of a side
_SAMPLES = 4


def eevee_frames(lamps: int, turns: int, folder: Path) -> dict[str, Any]:
    """Ratios to a frame of the user's material alone: of the relit material, and of that with a second surface.

    Args:
        lamps: suns in the scene.
        turns: of all three.
        folder: where frames are written.
    """
    objects = blender_scene.court(20_000, sides="AUTO")
    _surroundings(lamps)
    own = {ob: ob.data.materials[0] for ob in objects}
    second = {ob: _lit_twice(material) for ob, material in own.items()}
    relit = {ob: material.copy() for ob, material in own.items()}
    _wear(relit)
    bpy.ops.prt.bake(mode="SHADOWED", samples=16)
    runs = [_frames(worn, folder / "frame.png") for worn in (own, relit, second)]
    for run in runs:
        run()  # compiles
    times = by_turns(runs, turns)
    ratios = {name: asdict(ratio(times, number, 0)) for name, number in (("relit", 1), ("second", 2))}
    return {"lamps": lamps, "alone": asdict(median([turn[0] for turn in times])), **ratios}


def first_frames(lamps: int, turns: int, folder: Path) -> dict[str, Any]:
    """Ratio to the first frame of a process that shows the user's material alone: of one that shows the relit one, nothing kept by the driver.

    Args:
        lamps: suns in the scene.
        turns: of both.
        folder: where files and frames are written.
    """
    objects = blender_scene.court(20_000, sides="AUTO")
    _surroundings(lamps)
    bpy.context.scene.render.filepath = str(folder / "frame.png")
    paths = [folder / "own.blend", folder / "relit.blend"]
    bpy.ops.wm.save_as_mainfile(filepath=str(paths[0]), copy=True)
    bpy.ops.prt.bake(mode="SHADOWED", samples=16)
    bpy.ops.wm.save_as_mainfile(filepath=str(paths[1]), copy=True)
    times = by_turns([partial(_in_a_process, path) for path in paths], turns)
    alone = asdict(median([turn[0] for turn in times]))
    return {"lamps": lamps, "materials": len(objects), "alone": alone, "relit": asdict(ratio(times, 1, 0))}


def _in_a_process(path: Path) -> Seconds:
    """A process that opens a file, renders a frame and ends."""
    script = "import sys, bpy; bpy.ops.wm.open_mainfile(filepath=sys.argv[1]); bpy.ops.render.render()"
    command = [sys.executable, "-c", script, str(path)]
    environment = os.environ | {"MESA_SHADER_CACHE_DISABLE": "true"}
    return timed(lambda: subprocess.run(command, env=environment, check=True, stdout=subprocess.DEVNULL))


def _frames(worn: dict[bpy.types.Object, bpy.types.Material], path: Path) -> Callable[[], Seconds]:
    def run() -> Seconds:
        _wear(worn)
        bpy.context.scene.render.filepath = str(path)
        return timed(lambda: bpy.ops.render.render(write_still=True))

    return run


def _wear(worn: dict[bpy.types.Object, bpy.types.Material]) -> None:
    for ob, material in worn.items():
        ob.data.materials[0] = material


def _lit_twice(material: bpy.types.Material) -> bpy.types.Material:
    """The material, and what a white surface gets in the colour of an emission too faint to be seen."""
    copy = material.copy()
    tree = copy.node_tree
    white, light, glow, both = (
        tree.nodes.new(f"ShaderNode{kind}") for kind in ("BsdfDiffuse", "ShaderToRGB", "Emission", "AddShader")
    )
    glow.inputs["Strength"].default_value = 1e-4
    tree.links.new(white.outputs[0], light.inputs[0])
    tree.links.new(light.outputs["Color"], glow.inputs["Color"])
    tree.links.new(tree.nodes["Principled BSDF"].outputs[0], both.inputs[0])
    tree.links.new(glow.outputs[0], both.inputs[1])
    tree.links.new(both.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
    return copy


def _surroundings(lamps: int) -> None:
    """A grey sky, suns, and a camera that sees the court."""
    scene = bpy.context.scene
    scene.world = bpy.data.worlds.new("Sky")
    headless.use_nodes(scene.world)
    for number in range(lamps):
        sun = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
        sun.rotation_euler = (radians(40.0), 0.0, radians(80.0 * number))
        scene.collection.objects.link(sun)
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    scene.collection.objects.link(camera)
    scene.camera, camera.rotation_euler = camera, (radians(55.0), 0.0, 0.0)
    bpy.context.view_layer.update()
    corners = [corner for ob in scene.objects if ob.type == "MESH" for corner in _corners(ob)]
    camera.location, _ = camera.camera_fit_coords(bpy.context.evaluated_depsgraph_get(), corners)
    scene.render.engine = headless.eevee_engine()
    scene.render.resolution_x = scene.render.resolution_y = _SIZE
    scene.eevee.taa_render_samples = _SAMPLES


def _corners(ob: bpy.types.Object) -> list[float]:
    matrix = np.array(ob.matrix_world)
    return (np.array(ob.bound_box) @ matrix[:3, :3].T + matrix[:3, 3]).ravel().tolist()
