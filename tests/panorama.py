# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's own word on what a world shows where, and its integral by brute force. Used inside Blender only."""

import bpy
import numpy as np
import stage

from tests.core.references import order2


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


def integral(picture):
    """(9, 3) the light of a panorama, texel by texel."""
    height, width = picture.shape[:2]
    elevation = np.pi * ((np.arange(height) + 0.5) / height - 0.5)[:, None]
    azimuth = 2 * np.pi * (0.5 - (np.arange(width) + 0.5) / width)
    parts = np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)
    basis = order2(np.stack(np.broadcast_arrays(*parts), axis=-1))
    solid_angles = np.diff(np.sin(np.pi * (np.arange(height + 1) / height - 0.5))) * 2 * np.pi / width
    return np.einsum("hwi,h,hwc->ic", basis, solid_angles, picture.astype(np.float64), optimize=True)
