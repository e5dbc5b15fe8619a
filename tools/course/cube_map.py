# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes a cube map for the course: six JPEG faces of a photographic HDRI that Blender ships, named as OpenGL names them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from headless import bpy
from PIL import Image

SIZE = 256
_FACES = {
    # which way the picture's right, its bottom and its middle lie, y up (OpenGL 4.6, table 8.19)
    "posx": ((0, 0, -1), (0, -1, 0), (1, 0, 0)),
    "negx": ((0, 0, 1), (0, -1, 0), (-1, 0, 0)),
    "posy": ((1, 0, 0), (0, 0, 1), (0, 1, 0)),
    "negy": ((1, 0, 0), (0, 0, -1), (0, -1, 0)),
    "posz": ((1, 0, 0), (0, -1, 0), (0, 0, 1)),
    "negz": ((-1, 0, 0), (0, -1, 0), (0, 0, -1)),
}


def write_faces(hdri: Path, folder: Path) -> None:
    """Write the six faces; what is brighter than 1 is white, as in all pictures of eight bits."""
    image = bpy.data.images.load(str(hdri))
    texels = np.empty(image.size[0] * image.size[1] * 4, dtype=np.float32)
    image.pixels.foreach_get(texels)
    texels = texels.reshape(image.size[1], image.size[0], 4)[..., :3]
    bpy.data.images.remove(image)
    folder.mkdir(parents=True, exist_ok=True)
    for name, frame in _FACES.items():
        encoded = _encoded(_look_up(texels, _directions(frame)))
        Image.fromarray(encoded).save(folder / f"{name}.jpg", quality=90)


def _directions(frame: tuple[tuple[int, int, int], ...]) -> npt.NDArray[Any]:
    """(SIZE, SIZE, 3) unit vectors through the middles of a face's texels, top row first, z up."""
    right, down, middle = np.array(frame, dtype=np.float64)
    line = (2.0 * np.arange(SIZE) + 1.0) / SIZE - 1.0
    rays = line[None, :, None] * right + line[:, None, None] * down + middle
    x, y, z = np.moveaxis(rays / np.linalg.norm(rays, axis=-1, keepdims=True), -1, 0)
    return np.stack([x, -z, y], axis=-1)


def _look_up(texels: npt.NDArray[Any], directions: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """A panorama of Blender's, row 0 at the bottom, between its four nearest texels."""
    height, width = texels.shape[:2]
    column = (0.5 - np.arctan2(directions[..., 1], directions[..., 0]) / (2.0 * np.pi)) * width - 0.5
    row = np.clip((0.5 + np.arcsin(directions[..., 2]) / np.pi) * height - 0.5, 0.0, height - 1.001)
    left, below = np.floor(column).astype(int), np.floor(row).astype(int)
    across, up = (column - left)[..., None], (row - below)[..., None]
    lower = texels[below, left % width] * (1.0 - across) + texels[below, (left + 1) % width] * across
    upper = texels[below + 1, left % width] * (1.0 - across) + texels[below + 1, (left + 1) % width] * across
    return lower * (1.0 - up) + upper * up


def _encoded(linear: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Eight bits by the sRGB curve."""
    linear = np.clip(linear, 0.0, 1.0)
    curve = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1.0 / 2.4) - 0.055)
    return np.rint(255.0 * curve).astype(np.uint8)
