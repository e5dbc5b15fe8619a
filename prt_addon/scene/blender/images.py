# SPDX-License-Identifier: GPL-3.0-or-later
"""Texels of Blender's images, read in linear light, and written into float images."""

from __future__ import annotations

import bpy
import numpy as np
import numpy.typing as npt

from ...core.errors import PictureError
from ...core.sky.projection import srgb_to_linear

LINEAR_COLOURSPACES = {"Non-Color", "Linear Rec.709", "Linear", "scene_linear", "Raw"}
_ROWS_AT_A_TIME = 64


class Undecodable(PictureError):
    """A picture that is there, but that only Blender knows how to decode."""


def linear_pixels(image: bpy.types.Image, opaque: bool = False) -> npt.NDArray[np.float32]:
    """(height, width, 3) float32 linear radiance of an image, row 0 at the bottom.

    Blender hands out float images (.exr, .hdr) in scene-linear light, and byte images as they are encoded. What it hands
    out is the only copy that is made: 512 MiB for 8192 x 4096 texels.

    Args:
        image: a single picture.
        opaque: refuse byte images with transparent texels, as renderers darken these by their alpha.

    Raises:
        PictureError: if the file is missing or unreadable.
        Undecodable: if its colour space, or its alpha, is not one we can decode.
    """
    if image.source not in {"FILE", "GENERATED"}:
        raise Undecodable(f"Image '{image.name}' is a {image.source.lower()} image: use a single picture.")
    width, height = image.size  # reading the size loads the file
    if not width or not height:
        raise missing(image)
    encoding = image.colorspace_settings.name
    linear = image.is_float or encoding in LINEAR_COLOURSPACES
    known = linear or encoding == "sRGB"
    in_rec709 = not image.is_float and encoding != "Non-Color"
    if not known or (in_rec709 and not _works_in_rec709()):
        raise Undecodable(
            f"Image '{image.name}' has colour space '{encoding}': use a float image (.exr, .hdr), or set it to sRGB or "
            "Non-Color."
        )
    channels = image.channels
    flat = np.empty(width * height * channels, dtype=np.float32)
    image.pixels.foreach_get(flat)
    pixels = flat.reshape(height, width, channels)
    if opaque and not image.is_float and channels == 4 and pixels[..., 3].min() < 1.0:
        raise Undecodable(f"Image '{image.name}' is transparent in places: use an opaque picture.")
    rgb = pixels[..., :3] if channels >= 3 else np.broadcast_to(pixels[..., :1], (height, width, 3))
    if linear:
        return rgb
    if channels < 3:
        return srgb_to_linear(rgb)
    for first in range(0, height, _ROWS_AT_A_TIME):  # in place: copies of a whole large picture do not fit
        rows = rgb[first : first + _ROWS_AT_A_TIME]
        rows[:] = srgb_to_linear(rows)
    return rgb


def write_pixels(image: bpy.types.Image, pixels: npt.NDArray[np.float32]) -> None:
    """Fill a float image of the same size with (height, width, 3 or 4) float32, row 0 at the bottom; opaque without alpha."""
    rgba = np.ones((*pixels.shape[:2], 4), dtype=np.float32)
    rgba[..., : pixels.shape[2]] = pixels
    image.pixels.foreach_set(rgba.reshape(-1))
    image.update()


def float_image(name: str, pixels: npt.NDArray[np.float32]) -> bpy.types.Image:
    """A new image of such pixels."""
    height, width, channels = pixels.shape
    image = bpy.data.images.new(name, width, height, alpha=channels == 4, float_buffer=True)
    write_pixels(image, pixels)
    return image


def missing(image: bpy.types.Image) -> PictureError:
    """What to say of an image that has no pixels."""
    return PictureError(
        f"Image '{image.name}' cannot be read from '{image.filepath}': find the missing file or open another."
    )


def _works_in_rec709() -> bool:
    """Whether scene-linear light has Rec.709's primaries, as sRGB has; before 5.0 it always has."""
    colorspace = getattr(bpy.data, "colorspace", None)
    return colorspace is None or colorspace.working_space == "Linear Rec.709"
