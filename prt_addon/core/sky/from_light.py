# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws a picture of the sky that has a given light, where the sky itself is not known: blurred, but for its lamps."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ..arrays import Float32
from ..sphere.equirect import solid_angles, texel_directions
from .cube_map import with_light
from .lamps import Lamps
from .preview import light_picture


def sky_of(light: npt.NDArray[np.float64], lamps: Lamps, height: int) -> Float32:
    """What nine coefficients show of the sky, and discs for the lamps in it.

    Args:
        light: (9, 3) of the whole sky.
        lamps: those that are in it.
        height: rows of the picture.

    Returns:
        (height, 2 * height, 3) radiance, row 0 at the bottom, from 0; its own light is the given one.
    """
    rest = light - lamps.coloured_light()
    picture = np.maximum(light_picture(rest, height), 0.0)
    directions = texel_directions(height)
    angles = np.repeat(solid_angles(height, 2 * height)[:, None], 2 * height, axis=1)
    for lamp in lamps.lamps:
        cosines = directions @ lamp.direction
        disc = cosines >= min(np.cos(lamp.radius), cosines.max())  # one texel at least
        picture[disc] += (lamp.irradiance / angles[disc].sum() * np.array(lamps.colour)).astype(np.float32)
    return with_light(picture, light)
