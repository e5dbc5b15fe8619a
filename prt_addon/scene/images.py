# SPDX-License-Identifier: GPL-3.0-or-later
"""Texels of Blender's images, in linear light."""

from __future__ import annotations

import bpy
import numpy as np
import numpy.typing as npt

from ..core.envmap import srgb_to_linear
from ..core.errors import PictureError

LINEAR_COLOURSPACES = {"Non-Color", "Linear Rec.709", "Linear", "scene_linear", "Raw"}


def linear_pixels(image: bpy.types.Image) -> npt.NDArray[np.float32]:
    """(height, width, 3) float32 linear radiance of an image, row 0 at the bottom.

    Blender hands out float images (.exr, .hdr) in scene-linear light, and byte images as they are encoded.

    Raises:
        PictureError: if the file is missing or unreadable, or its colour space is not one we can decode.
    """
    if image.source not in {"FILE", "GENERATED"}:
        raise PictureError(f"Image '{image.name}' is a {image.source.lower()} image: use a single picture.")
    width, height = image.size  # reading the size loads the file
    if not width or not height:
        raise PictureError(
            f"Image '{image.name}' cannot be read from '{image.filepath}': find the missing file or open another."
        )
    channels = image.channels
    flat = np.empty(width * height * channels, dtype=np.float32)
    image.pixels.foreach_get(flat)
    pixels = flat.reshape(height, width, channels)
    rgb = pixels[..., :3] if channels >= 3 else np.repeat(pixels[..., :1], 3, axis=-1)
    if image.is_float or image.colorspace_settings.name in LINEAR_COLOURSPACES:
        return rgb
    if image.colorspace_settings.name == "sRGB":
        return srgb_to_linear(rgb)
    raise PictureError(
        f"Image '{image.name}' has colour space '{image.colorspace_settings.name}': use a float image (.exr, .hdr), "
        "or set it to sRGB or Non-Color."
    )
