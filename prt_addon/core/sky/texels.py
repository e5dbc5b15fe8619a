# SPDX-License-Identifier: GPL-3.0-or-later
"""Holds a sky as the texels of a picture: where they lie, what is seen between them; and projects all of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from ..arrays import Float32, Float64
from ..sphere import sh
from .projection import project_equirect, project_mirror_ball, without_broken

Layout = Literal["EQUIRECTANGULAR", "MIRROR_BALL"]
"""How a picture lies around the world, by the names of Blender's Environment Texture."""


@dataclass(frozen=True)
class SkyTexels:
    """A picture of the whole sky.

    Attributes:
        pixels: (H, W, 3) linear radiance, row 0 at the bottom, finite.
        layout: where its texels lie.
        interpolated: whether radiance goes linearly from the centre of a texel to the next; a mirror ball's is flat.
        left_out: how many texels were not finite, and are black.
    """

    pixels: Float32
    layout: Layout = "EQUIRECTANGULAR"
    interpolated: bool = False
    left_out: int = 0

    @classmethod
    def of(cls, pixels: Float32, layout: Layout = "EQUIRECTANGULAR", interpolated: bool = False) -> SkyTexels:
        """Leave the texels of a picture (H, W, 3) out that are not finite; the picture is changed where it can be."""
        finite, left_out = without_broken(pixels)
        return cls(finite, layout, interpolated, left_out)

    @property
    def count(self) -> int:
        """The number of texels."""
        height, width = self.pixels.shape[:2]
        return height * width

    @property
    def is_equirectangular(self) -> bool:
        """Whether rows are circles of latitude: lamps are looked for in such pictures, and pages and reports show them."""
        return self.layout == "EQUIRECTANGULAR"

    @property
    def is_stretched(self) -> bool:
        """Whether an equirectangular picture is not twice as wide as high, so that it shows no sky at its own proportions."""
        height, width = self.pixels.shape[:2]
        return self.is_equirectangular and abs(width - 2 * height) > 1

    def project(self, order: int = sh.ORDER) -> Float64:
        """((order + 1)**2, 3) the SH light of all texels, `L_i = integral L(w) Y_i(w) dw`.

        Raises:
            PictureError: if the picture is empty.
        """
        if self.is_equirectangular:
            return project_equirect(self.pixels, order, self.interpolated)
        return project_mirror_ball(self.pixels, order)
