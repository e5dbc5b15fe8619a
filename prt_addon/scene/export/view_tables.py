# SPDX-License-Identifier: GPL-3.0-or-later
"""Tabulates Blender's view transforms, so that other programs show the colours that Blender shows."""

from __future__ import annotations

import tempfile
from pathlib import Path

import bpy
import numpy as np

from ..blender.images import float_image

SIZE = 33
"""Entries along each side."""
TOE, TOP = 0.18 * 2.0**-6, 0.18 * 2.0**8
"""Linear light where a table begins to be logarithmic, and where it ends; `web/packages/core/src/view.ts` has them, too."""


def entries() -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """(SIZE,) the linear light at which a table has values, along each channel."""
    share = np.linspace(0.0, 1.0, SIZE)
    return TOE * ((TOP / TOE + 1.0) ** share - 1.0)


def view_table(settings: bpy.types.ColorManagedViewSettings | None, transform: str = "AgX") -> bytes | None:
    """What a view transform makes of a lattice of colours: three bytes each, red fastest, then green.

    Args:
        settings: a scene's, with its look and curves but at exposure 0; without them a transform without a look.
        transform: the view transform's name, where there are no settings.

    Returns:
        None if this Blender has no such transform.
    """
    scene = bpy.data.scenes.new("PRT View")
    try:
        view = scene.view_settings
        try:
            view.view_transform = settings.view_transform if settings else transform
            view.look = settings.look if settings else "None"
        except TypeError:  # another configuration of colours
            return None
        view.exposure, view.gamma = 0.0, settings.gamma if settings else 1.0
        return _seen(scene)
    finally:
        bpy.data.scenes.remove(scene)


def _seen(scene: bpy.types.Scene) -> bytes:
    at = entries()
    blue, green, red = np.meshgrid(at, at, at, indexing="ij")
    lattice = np.stack([red, green, blue], axis=-1).reshape(SIZE * SIZE, SIZE, 3)
    image = float_image("PRT View", lattice.astype(np.float32))
    output = scene.render.image_settings
    output.file_format, output.color_mode, output.color_depth = "PNG", "RGB", "16"
    try:
        with tempfile.TemporaryDirectory(prefix="prt-view-") as folder:
            path = Path(folder) / "view.png"
            image.save_render(str(path), scene=scene)
            return _bytes_of(path)
    finally:
        bpy.data.images.remove(image)


def _bytes_of(path: Path) -> bytes:
    image = bpy.data.images.load(str(path), check_existing=False)
    try:
        image.colorspace_settings.is_data = True
        flat = np.empty(image.size[0] * image.size[1] * image.channels, dtype=np.float32)
        image.pixels.foreach_get(flat)
        colours = flat.reshape(-1, image.channels)[:, :3]
        return np.rint(np.clip(colours, 0.0, 1.0) * 255.0).astype(np.uint8).tobytes()
    finally:
        bpy.data.images.remove(image)
