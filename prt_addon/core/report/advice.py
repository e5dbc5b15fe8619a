# SPDX-License-Identifier: GPL-3.0-or-later
"""Says in one line what to do about each part of the error."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, hypot, log2, sqrt

from ..sky.lamps import Lamps
from .measures import Estimate, percent
from .picture import PictureDifference
from .sampling import Sampling
from .seams import Seams
from .tessellation import Tessellation
from .truncation import Truncation

ENOUGH = 0.01
"""An error too small to see, beside which nothing needs to be done."""

_DECAY = 0.79  # four times the samples leave a third of the noise
_WORTH_IT = 0.75  # what a remedy must leave of an error at most, to be named

_GLOSS = 0.1  # an error of pictures beyond what transport usually leaves


def about_sampling(part: Sampling, others: float, samples: int) -> str:
    """Say whether more samples would help, and how many.

    Args:
        part: the noise that was found.
        others: the largest of the other parts.
        samples: of the bake; 0 if it cast no rays.
    """
    if not part.relative_rms.is_known:
        return "No light reaches the surface."
    if not samples:
        return "Unshadowed transport has no noise."
    noise, goal = part.relative_rms.value, max(ENOUGH, others / 2.0)
    if noise <= goal:
        return f"{percent(noise)} of noise: more samples would not be seen."
    times = 2 ** ceil(log2((noise / goal) ** (1.0 / _DECAY)))
    left = percent(noise / times**_DECAY)
    return f"Bake with {times * samples} samples: about {left} of noise would be left of {percent(noise)}."


def about_truncation(part: Truncation, lamps: Lamps, shown: bool) -> str:
    """Say whether the order is to blame, or that lamps should show parts of the sky.

    Args:
        part: the truncation that was found.
        lamps: that were found in the sky.
        shown: whether they light in EEVEE.
    """
    if not part.relative_rms.is_known:
        return "No light reaches the surface."
    loss = part.relative_rms.value
    if loss <= ENOUGH:
        return f"{percent(loss)}: order 2 is enough for this light."
    if part.without_lamps and part.without_lamps.value <= _WORTH_IT * loss:
        left = f"{percent(part.without_lamps.value)} of {percent(loss)}"
        return f"{_carried(lamps, shown)}: {f'{left} is left' if shown else f'Extract Lamps would leave {left}'}."
    window = part.by_order[2].value
    if window <= _WORTH_IT * loss:
        return (
            f"The light on the world is not its sky's: project it again, unwindowed; {percent(window)} would be left."
        )
    higher = (
        f"Order 3 would leave {percent(part.by_order[3].value)} of {percent(loss)}{_halved(part.by_order[3], loss)}."
    )
    return f"{_carried(lamps, shown)}. {higher}" if part.without_lamps else higher


def _carried(lamps: Lamps, shown: bool) -> str:
    count, share = len(lamps.lamps), percent(lamps.share)
    if not shown:
        return f"{count} lamp{'s' if count > 1 else ''} would carry {share} of the light"
    carry, show = ("s carry", "show") if count > 1 else (" carries", "shows")
    return f"{count} lamp{carry} {share} of the light, and {show} it in EEVEE"


def about_tessellation(part: Tessellation, others: float) -> str:
    """Say whether the mesh is fine enough, and where it is not.

    Args:
        part: the error between vertices that was found.
        others: the largest of the other parts.
    """
    if not part.relative_rms.is_known:
        return "Not measured: no light reaches the surface, or all corners lie inside other geometry."
    error = part.relative_rms.value
    if error <= max(ENOUGH, others / 2.0):
        return f"{percent(error)} between vertices: a finer mesh would not be seen."
    name, share = max(part.shares.items(), key=lambda item: item[1])
    return f"Subdivide '{name}': {percent(share)} of the error between vertices sits there."


def about_seams(part: Seams, others: float) -> str | None:
    """Say where meshes sink into one another, if that matters beside the largest of the other parts."""
    if not part.relative_rms.is_known or part.relative_rms.value <= max(ENOUGH, others / 2.0):
        return None
    return (
        f"{percent(part.relative_rms.value)} sits where corners of faces lie inside other geometry, most of it on "
        f"'{part.where}': cut or subdivide these faces where the meshes meet."
    )


def about_rest(whole: Estimate, parts: Sequence[Estimate], bounces: bool) -> str | None:
    """Say what the whole error holds beside its parts, if that is more than their intervals leave open.

    Args:
        whole: the error of all together.
        parts: those of the parts.
        bounces: whether light bounces off surfaces that need not have been measured themselves.
    """
    if not whole.is_known or whole.low <= hypot(*(part.high for part in parts)):
        return None
    rest = sqrt(whole.value**2 - sum(part.value**2 for part in parts))
    if rest <= ENOUGH:
        return None
    remedy = "subdivide what light bounces off" if bounces else "what is stored is not this bake: bake again"
    return f"{percent(rest)} of error is in none of these parts: {remedy}."


def about_pictures(found: PictureDifference) -> str:
    """Say how far EEVEE's picture is from Cycles', and to which side."""
    if not found.relative_rms.is_known:
        return "No pixel shows a baked surface: point the camera at one."
    bias = found.bias.value
    if found.bias.low <= 0.0 <= found.bias.high or abs(bias) < 0.0005:
        side = "with no bias"
    else:
        side = f"{percent(abs(bias))} too {'bright' if bias > 0.0 else 'dark'} in the mean"
    more = "" if found.relative_rms.value <= _GLOSS else " Gloss, lamps and emission, if there are any, are in it."
    return f"EEVEE's picture is {percent(found.relative_rms.value)} from Cycles', {side}.{more}"


def _halved(estimate: Estimate, loss: float) -> str:
    return ", half of it" if 0.4 * loss <= estimate.value <= 0.6 * loss else ""
