# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws the SH light beside the sky it was projected from, and small for the panel; says how much energy it kept."""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import bpy.utils.previews
import numpy as np
import numpy.typing as npt

from ...core.errors import PRTError
from ...core.files import digest
from ...core.sky import preview
from ...core.sphere.windowing import energy_shares
from ...session import session
from ..blender.images import write_pixels
from ..sky.projection import sky_picture
from ..sky.sky import read_sky
from . import light

_HEIGHT = 256
_ICON_HEIGHT = 64


@dataclass(frozen=True)
class BandEnergy:
    """How the energy of a light, the integral of its square over the sphere, is spread over its bands.

    bands: share of each band.
    of_sky: whether shares are of the sky's energy, which says what was lost; else of the light's own.
    """

    bands: npt.NDArray[np.float64]
    of_sky: bool


def make_picture(scene: bpy.types.Scene) -> tuple[bpy.types.Image, bool]:
    """Draw what the world's light shows, as it is turned now, into the image "PRT Light of X", right of the sky itself.

    The image is float, in the same units left and right, and packed.

    Returns:
        The image, and whether the sky is in it: not if the light follows no nodes, as an imported one.

    Raises:
        LightError: if the world carries no light.
    """
    shown = light.shown_light(scene.world)
    parts = [preview.light_picture(shown, _HEIGHT)]
    sky = _sky_picture(scene)
    if sky is not None:
        session.sky_energies[digest(light.read_light(scene.world))] = preview.energy(sky)
        strength = np.float32(light.strength_of(scene.world))
        parts.insert(0, strength * preview.turned_picture(sky, light.read_turn(scene.world), _HEIGHT))
    return _written(f"PRT Light of {scene.world.name}", np.concatenate(parts, axis=1)), sky is not None


def band_energy(world: bpy.types.World) -> BandEnergy:
    """Measure how much of the energy lies in each band of the light of a world that has one; cheap."""
    stored = light.read_light(world)
    total = session.sky_energies.get(digest(stored))
    return BandEnergy(energy_shares(stored, total), total is not None)


def icon(world: bpy.types.World) -> int:
    """Identifier of a small picture of the light as it is turned now, for drawing; 0 where Blender has no window.

    It lives in memory, not in the file, and is drawn again when the light has changed.
    """
    shown = light.shown_light(world, update=False)
    if session.icons is None:
        session.icons = bpy.utils.previews.new()
        session.icons.new("light").image_size = (2 * _ICON_HEIGHT, _ICON_HEIGHT)
    if session.icon_shows != (found := digest(shown)):
        pixels = preview.display(preview.light_picture(shown, _ICON_HEIGHT))
        session.icons["light"].image_pixels_float.foreach_set(pixels.reshape(-1))
        session.icon_shows = found
    return int(session.icons["light"].icon_id)


def unregister() -> None:
    """Free the small picture."""
    if session.icons is not None:
        bpy.utils.previews.remove(session.icons)
        session.icons, session.icon_shows = None, b""


def _sky_picture(scene: bpy.types.Scene) -> npt.NDArray[np.float32] | None:
    """The sky that the light follows, unturned and at strength 1."""
    if not light.is_projected(scene.world):
        return None
    try:
        return sky_picture(read_sky(scene))
    except PRTError:  # the light was made from another
        return None


def _written(name: str, picture: npt.NDArray[np.float32]) -> bpy.types.Image:
    """The image of that name, made or changed to show the picture."""
    height, width = picture.shape[:2]
    image = bpy.data.images.get(name) or bpy.data.images.new(name, width, height, float_buffer=True)
    if tuple(image.size) != (width, height):
        image.scale(width, height)
    write_pixels(image, picture)
    image.pack()
    return image
