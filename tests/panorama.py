# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders what a world shows where, by Blender itself, and integrates it by brute force. Used inside Blender only."""

import bpy
import headless
import numpy as np
import numpy.typing as npt

from tests import stage
from tests.core.references import order2

_harmonics: dict[int, npt.NDArray[np.float64]] = {}


def render_world(path, height):
    """(height, 2 * height, 3) radiance that Cycles shows of the scene's world, row 0 at the bottom, +x in the middle.

    One sample at the middle of each pixel; nothing else may be in the scene.
    """
    scene = bpy.context.scene
    if scene.camera is None:
        scene.camera = bpy.data.objects.new("Panorama", bpy.data.cameras.new("Panorama"))
        scene.collection.objects.link(scene.camera)
    camera = scene.camera.data
    scene.camera.rotation_euler = (np.pi / 2, 0, -np.pi / 2)
    camera.type = "PANO"
    owner = camera if hasattr(camera, "panorama_type") else camera.cycles  # 5.0 moved it
    owner.panorama_type = "EQUIRECTANGULAR"
    scene.world.cycles.sampling_method = "NONE"  # seconds are saved where nothing is lit
    scene.render.resolution_x, scene.render.resolution_y = 2 * height, height
    scene.cycles.filter_width = 0.01
    scene.cycles.use_denoising = False
    scene.view_settings.view_transform = "Raw"
    return stage.render(path, "CYCLES", samples=1)[..., :3]


def light_of_world(path, height):
    """(9, 3) the light of the scene's world, pixel by pixel; where a pixel looks, Cycles says too."""
    if height not in _harmonics:
        _harmonics[height] = order2(_render_directions(path, height))
    solid_angles = np.diff(np.sin(np.pi * (np.arange(height + 1) / height - 0.5))) * np.pi / height
    picture = render_world(path, height).astype(np.float64)
    return np.einsum("hwi,h,hwc->ic", _harmonics[height], solid_angles, picture, optimize=True)


def _render_directions(path, height):
    """(height, 2 * height, 3) unit vectors: what a world shows whose colour is the direction."""
    scene, world = bpy.context.scene, bpy.data.worlds.new("Directions")
    headless.use_nodes(world)
    tree = world.node_tree
    background = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeBackground")
    tree.links.new(tree.nodes.new("ShaderNodeTexCoord").outputs["Generated"], background.inputs["Color"])
    before, scene.world = scene.world, world
    directions = render_world(path, height).astype(np.float64)
    scene.world = before
    bpy.data.worlds.remove(world)
    return directions / np.linalg.norm(directions, axis=-1, keepdims=True)
