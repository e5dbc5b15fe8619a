# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds suns in a picture of the sky: texels so bright that nine coefficients smear them into a glow without a shadow."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Float32
from ..sphere.equirect import solid_angles

BRIGHTNESS = 1000.0
"""Times the sky's mean: the sun is above, a window, a lamp shade or a lit cloud is below."""

WORTH_A_LAMP = 0.01
"""Share of the light from which on it is worth a word."""


@dataclass(frozen=True)
class Suns:
    """The suns of a sky.

    Attributes:
        share: of the sky's light, integrated over the sphere, in [0, 1].
        without: (H, W, 3) the picture with the sky's mean in their place.
    """

    share: float
    without: Float32

    @property
    def matter(self) -> bool:
        """Whether the suns carry enough of the light to be mentioned."""
        return self.share >= WORTH_A_LAMP


def find_suns(picture: Float32) -> Suns:
    """Find the suns of an equirectangular picture (H, W, 3), row 0 at the bottom."""
    ring = solid_angles(*picture.shape[:2])[:, None]
    brightness = np.maximum(picture.mean(axis=-1, dtype=np.float64), 0.0)
    flux = brightness * ring
    whole = float(flux.sum())
    is_sun = brightness > BRIGHTNESS * whole / float(ring.sum() * picture.shape[1])
    if not is_sun.any():
        return Suns(0.0, picture)
    rest = np.where(is_sun[..., None], 0.0, picture * ring[..., None]).sum(axis=(0, 1), dtype=np.float64)
    mean = rest / (np.where(is_sun, 0.0, ring).sum())
    return Suns(float(flux[is_sun].sum() / whole), np.where(is_sun[..., None], mean, picture).astype(np.float32))
