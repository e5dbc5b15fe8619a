# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads texels of Blender's images in linear light, and writes float images."""

from __future__ import annotations

import bpy
import numpy as np
import numpy.typing as npt
from mathutils import Color

from ...core.errors import PictureError
from ...core.sky.projection import srgb_to_linear

LINEAR_COLOURSPACES = {"Linear Rec.709", "Linear", "scene_linear", "Raw"}
_ROWS_AT_A_TIME = 64


class Undecodable(PictureError):
    """A picture that is there, but that Blender alone can decode."""


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
    _require_single(image)
    encoding, is_data = image.colorspace_settings.name, image.colorspace_settings.is_data
    linear = image.is_float or is_data or encoding in LINEAR_COLOURSPACES
    if not linear and encoding != "sRGB":
        raise Undecodable(
            f"Image '{image.name}' has colour space '{encoding}': use a float image (.exr, .hdr), or set it to sRGB or "
            "Non-Color."
        )
    pixels = _stored_pixels(image)
    height, _, channels = pixels.shape
    if opaque and not image.is_float and channels == 4 and pixels[..., 3].min() < 1.0:
        raise Undecodable(f"Image '{image.name}' is transparent in places: use an opaque picture.")
    rgb = pixels[..., :3] if channels >= 3 else np.repeat(pixels[..., :1], 3, axis=2)
    if image.is_float or is_data:
        return rgb
    for first in range(0, height, _ROWS_AT_A_TIME):  # in place: copies of a whole large picture do not fit
        rows = rgb[first : first + _ROWS_AT_A_TIME]
        rows[:] = to_scene_linear(rows if linear else srgb_to_linear(rows))
    return rgb


def alpha_pixels(image: bpy.types.Image) -> npt.NDArray[np.float32]:
    """(height, width, 1) float32 alpha of an image, row 0 at the bottom; 1 where it has none, or it is to be ignored.

    Args:
        image: a single picture.

    Raises:
        PictureError: if the file is missing or unreadable.
        Undecodable: if it is not a single picture.
    """
    _require_single(image)
    if image.channels < 4 or image.alpha_mode == "NONE":
        width, height = image.size
        return np.ones((height, width, 1), dtype=np.float32)
    return np.ascontiguousarray(_stored_pixels(image)[..., 3:])


def _require_single(image: bpy.types.Image) -> None:
    """Raises PictureError unless an image is a single picture whose pixels are there."""
    if image.source not in {"FILE", "GENERATED"}:
        raise Undecodable(f"Image '{image.name}' is a {image.source.lower()} image: use a single picture.")
    if not all(image.size):  # reading the size loads the file
        raise missing(image)


def _stored_pixels(image: bpy.types.Image) -> npt.NDArray[np.float32]:
    """(height, width, channels) as Blender hands them out."""
    width, height = image.size
    flat = np.empty(width * height * image.channels, dtype=np.float32)
    image.pixels.foreach_get(flat)
    return flat.reshape(height, width, image.channels)


def to_scene_linear(rec709: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    """(..., 3) linear light with Rec.709's primaries, as sRGB has, in those of the file: since 5.0 a file has its own."""
    basis = np.array([Color(axis).from_rec709_linear_to_scene_linear()[:] for axis in np.eye(3)], dtype=np.float32)
    return rec709 if np.allclose(basis, np.eye(3), atol=1e-4) else rec709 @ basis


def write_pixels(image: bpy.types.Image, pixels: npt.NDArray[np.float32]) -> None:
    """Fill a float image of the same size with (height, width, 3 or 4) float32, row 0 at the bottom; opaque without alpha."""
    rgba = np.ones((*pixels.shape[:2], 4), dtype=np.float32)
    rgba[..., : pixels.shape[2]] = pixels
    image.pixels.foreach_set(rgba.reshape(-1))
    image.update()


def float_image(name: str, pixels: npt.NDArray[np.float32]) -> bpy.types.Image:
    """Make an image of such pixels."""
    height, width, channels = pixels.shape
    image = bpy.data.images.new(name, width, height, alpha=channels == 4, float_buffer=True)
    write_pixels(image, pixels)
    return image


def missing(image: bpy.types.Image) -> PictureError:
    """Make the error about an image that has no pixels."""
    return PictureError(
        f"Image '{image.name}' cannot be read from '{image.filepath}': find the missing file or open another."
    )
