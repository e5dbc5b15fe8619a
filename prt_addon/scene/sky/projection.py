# SPDX-License-Identifier: GPL-3.0-or-later
"""Projects a sky to its SH light: the texels of its picture, or what Blender makes of its nodes; then windows it and
finds lamps.
"""

from __future__ import annotations

from dataclasses import dataclass

from ...core.arrays import Float32, Float64
from ...core.sky.find_lamps import ENOUGH, find_lamps
from ...core.sky.lamps import Lamps
from ...core.sky.texels import SkyTexels
from ...core.sphere import sh, windowing
from ..blender.images import Undecodable, linear_pixels
from .identity import SkyIdentity, sky_identity
from .panorama import panorama
from .sky import Sky


@dataclass(frozen=True)
class LightSettings:
    """How a sky is projected.

    window: against ringing: NONE, HANN, LANCZOS, or AUTO: the mildest Hann window that leaves no negative light.
    cutoff: the first band that is gone; AUTO finds its own.
    lamps: which spots are taken out: NONE, ONE, FOUR or EIGHT at most, or AUTO: the fewest up to four that bring the truncation low enough.
    """

    window: str = "NONE"
    cutoff: float = sh.ORDER + 1.0
    lamps: str = "NONE"


_UNIFORM_HEIGHT = 32  # texels of a sky that looks the same in all directions
MOST_LAMPS = {"NONE": 0, "ONE": 1, "AUTO": 4, "FOUR": 4, "EIGHT": 8}


@dataclass(frozen=True)
class Projection:
    """A sky as an SH light, unturned and at strength 1 where these are followed; and how it came about.

    light: (9, 3), windowed, with all that lamps stand for.
    lamps: what is shown by lamps instead.
    factors: (3,), what the window left of each band.
    negative: share of the sphere, in [0, 1], on which a channel of the light is negative, before and after it.
    way: a sentence for the user.
    """

    light: Float64
    lamps: Lamps
    settings: LightSettings
    factors: Float64
    negative: tuple[float, float]
    identity: SkyIdentity
    way: str

    @property
    def sentences(self) -> list[str]:
        """For the user: which way was taken, what is followed, which lamps were found, and what the window did."""
        sentences = [self.way]
        if count := len(self.lamps.lamps):
            sentences.append(
                f"{count} lamp{'s show' if count > 1 else ' shows'} {self.lamps.share:.0%} of the sky's light, shadows and all."
            )
        if self.settings.window != "NONE":
            kept = " and ".join(f"{factor:.0%}" for factor in self.factors[1:])
            before, after = (f"{share:.1%}" for share in self.negative)
            sentences.append(f"The window keeps {kept} of bands 1 and 2: {before} of the sky was negative, {after} is.")
        return sentences


def project(sky: Sky, settings: LightSettings) -> Projection:
    """Project a sky: all texels of a picture, or what Blender makes of the nodes.

    Raises:
        PictureError, LightError: if a picture cannot be read, or the world not be evaluated.
    """
    if sky.texture and (texels := _picture(sky)):
        way = f"Projected '{sky.texture.image.name}' into the light of world '{sky.world.name}'"
    else:
        texels = _rendered(sky)
        way = f"Rendered world '{sky.world.name}' to a panorama and projected it"
    return projected(sky, texels.project(), way + _left_out(texels) + _stretched(texels), settings, texels)


def projected(
    sky: Sky, light: Float64, by: str, settings: LightSettings, texels: SkyTexels | None = None
) -> Projection:
    """A light (9, 3) that was made of a sky, by what the sentence says, once windowed and its lamps are found.

    Args:
        sky: that the light was made of.
        light: (9, 3), as it was projected.
        by: how it was made, to begin the sentence with.
        settings: of the projection.
        texels: what lamps are looked for in, if they are equirectangular; otherwise the sky is looked at anew.
    """
    if settings.window == "AUTO":
        deringed = windowing.dering(light)
        kept, factors, negative = deringed.light, deringed.factors, (deringed.negative_before, deringed.negative_after)
    else:
        factors = windowing.band_factors(settings.window, settings.cutoff)  # type: ignore[arg-type]
        kept = windowing.windowed(light, factors)
        negative = (windowing.negative_share(light), windowing.negative_share(kept))
    return Projection(
        kept, _lamps(sky, settings, texels), settings, factors, negative, sky_identity(sky), f"{by}; {sky.following}."
    )


def _lamps(sky: Sky, settings: LightSettings, texels: SkyTexels | None) -> Lamps:
    if not MOST_LAMPS[settings.lamps] or sky.is_uniform:
        return Lamps()
    picture = texels.pixels if texels and texels.is_equirectangular else sky_picture(sky)
    if not sky.has_sun_disc:
        return lamps_in(picture, settings.lamps)
    found = find_lamps(picture, *lamp_rule(settings.lamps), wide=False)  # EEVEE's own light lacks the disc alone
    return found if found.lamps else find_lamps(picture, 1, wide=False)


def lamps_in(picture: Float32, wanted: str) -> Lamps:
    """The lamps of an equirectangular picture (H, W, 3), as many as `LightSettings.lamps` says."""
    return find_lamps(picture, *lamp_rule(wanted))


def lamp_rule(wanted: str) -> tuple[int, float]:
    """So many lamps at most, and under which truncation no more are looked for: 0 where all that are found are taken."""
    return MOST_LAMPS[wanted], ENOUGH if wanted == "AUTO" else 0.0


def sky_picture(sky: Sky) -> Float32:
    """(height, 2 height, 3) the sky at its best resolution, unturned and at strength 1 where these are followed.

    Raises:
        PictureError, LightError: as `project`.
    """
    texels = _picture(sky)
    return texels.pixels if texels and texels.is_equirectangular else _rendered(sky).pixels


def _picture(sky: Sky) -> SkyTexels | None:
    """The picture that a sky is; None if it is more than that, or Blender alone can decode it."""
    if sky.texture is None:
        return None
    try:
        pixels = linear_pixels(sky.texture.image, opaque=True)
    except Undecodable:
        return None
    return SkyTexels.of(pixels, sky.texture.projection, sky.texture.interpolation != "Closest")


def _rendered(sky: Sky) -> SkyTexels:
    """What Blender makes of a sky's nodes, each texel the mean over it: few of them where all look the same."""
    return SkyTexels.of(panorama(sky, _UNIFORM_HEIGHT) if sky.is_uniform else panorama(sky))


def _left_out(texels: SkyTexels) -> str:
    """What to say of texels that are no numbers; nothing if there are none."""
    if not texels.left_out:
        return ""
    return f", without {texels.left_out:,} of {texels.count:,} texels, which are not finite"


def _stretched(texels: SkyTexels) -> str:
    """What to say of a picture that shows no whole sky at its own proportions."""
    if not texels.is_stretched:
        return ""
    height, width = texels.pixels.shape[:2]
    return f" (it is {width} x {height} and no 2:1 panorama, so that it is shown stretched)"
