# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders frames of the active scene by EEVEE and Cycles, of the same light, and makes pictures of them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import demo_scene
import headless
import numpy as np
import numpy.typing as npt
from headless import bpy
from PIL import Image

CYCLES_SAMPLES = 64


def set_up_render(scene: bpy.types.Scene) -> None:
    """EEVEE, about 640 pixels wide, with few samples: each costs as much, and a sun's shadow is smooth with four."""
    render_settings = scene.render
    render_settings.engine = headless.eevee_engine()
    render_settings.resolution_percentage = max(1, min(100, round(640 / render_settings.resolution_x * 100)))
    scene.eevee.taa_render_samples = 4


def use_cycles(scene: bpy.types.Scene) -> None:
    """Cycles of the same light: as many diffuse bounces as were baked, and no glossy ones."""
    scene.render.engine = "CYCLES"
    scene.cycles.samples = CYCLES_SAMPLES
    scene.cycles.use_denoising = True
    scene.cycles.max_bounces = scene.cycles.diffuse_bounces = demo_scene.diffuse_bounces(scene)


def turning_rotation(scene: bpy.types.Scene) -> bpy.types.bpy_prop_array:
    """The Euler angles of the world's Mapping node, which the bake made sure of."""
    mapping = next(node for node in scene.world.node_tree.nodes if node.bl_idname == "ShaderNodeMapping")
    return mapping.inputs["Rotation"].default_value


def render(scene: bpy.types.Scene, path: Path) -> Path:
    """One frame as it is displayed, with the sky behind it."""
    scene.render.film_transparent = False
    scene.render.image_settings.file_format = "PNG"
    scene.render.filepath = str(path)
    with headless.quiet():
        bpy.ops.render.render(write_still=True)
    return path


def render_linear(scene: bpy.types.Scene, path: Path) -> npt.NDArray[Any]:
    """One frame in linear light, (height, width, 4), transparent where there is only sky."""
    scene.render.film_transparent = True
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.render.filepath = str(path)
    with headless.quiet():
        bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(str(path), check_existing=False)
    pixels = np.empty(image.size[0] * image.size[1] * 4, dtype=np.float32)
    image.pixels.foreach_get(pixels)
    return pixels.reshape(image.size[1], image.size[0], 4)


def relative_rms(ours: npt.NDArray[Any], truth: npt.NDArray[Any]) -> float:
    """RMS of the difference over the RMS of the truth, where both show a surface."""
    surface = np.minimum(ours[..., 3], truth[..., 3]) > 0.99
    difference = ours[surface][:, :3] - truth[surface][:, :3]
    return float(np.sqrt((difference**2).mean() / (truth[surface][:, :3] ** 2).mean()))


def side_by_side(pictures: Sequence[Image.Image]) -> Image.Image:
    """Pictures of one size in a row."""
    width, height = pictures[0].size
    row = Image.new("RGB", (width * len(pictures), height))
    for number, picture in enumerate(pictures):
        row.paste(picture.convert("RGB"), (width * number, 0))
    return row


def save_gif(path: Path, pictures: list[Image.Image]) -> None:
    """Pictures of one size as a film without end, twelve a second."""
    pictures[0].save(path, save_all=True, append_images=pictures[1:], duration=83, loop=0)
