# SPDX-License-Identifier: GPL-3.0-or-later
"""Defines lamps that stand for bright spots of a sky: distant discs, their part of the SH light, how they go from moment to moment.

All lamps of a sky share one colour, so that one coefficient per band and order says what they are of the SH light.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..arrays import Float64
from ..sphere import sh


@dataclass(frozen=True)
class Lamp:
    """A distant disc of one colour with its neighbours.

    Attributes:
        direction: (3,) unit vector towards it, in the picture's directions.
        irradiance: on a surface that faces it, mean of the channels.
        radius: of the disc, in radians.
        radiance: mean of the channels over its texels, each weighed by its light; 0 if not known. It is that of the disc, or more where a
            spot is not as bright everywhere.
    """

    direction: Float64
    irradiance: float
    radius: float
    radiance: float = 0.0


@dataclass(frozen=True)
class Lamps:
    """Lamps that are taken out of a sky.

    Attributes:
        colour: (3,) of all of them, with a mean of 1.
        share: of the sky's light, in [0, 1].
    """

    lamps: tuple[Lamp, ...] = ()
    colour: tuple[float, float, float] = (1.0, 1.0, 1.0)
    share: float = 0.0

    def light(self, order: int = sh.ORDER) -> Float64:
        """((order + 1)**2,) the SH light of the lamps, before their colour."""
        parts = [lamp.irradiance * _disc(lamp, order) for lamp in self.lamps]
        return np.sum(parts, axis=0) if parts else np.zeros(sh.coefficient_count(order))

    def coloured_light(self) -> Float64:
        """(9, 3) the SH light of the lamps."""
        return np.multiply.outer(self.light(), self.colour)


def tracked(found: Sequence[Sequence[Lamp]]) -> list[list[Lamp]]:
    """Track lamps from moment to moment: in rows of equal length, each lamp is followed by the nearest one.

    What is not there at a moment is a lamp without light, where it was last seen, or will be seen first.
    """
    tracks: list[list[Lamp | None]] = []
    for moment, lamps in enumerate(found):
        free = list(range(len(tracks)))
        for track in tracks:
            track.append(None)
        for lamp in lamps:
            last = {number: _last(tracks[number]).direction @ lamp.direction for number in free}
            if last:
                number = max(last, key=lambda number: last[number])
                free.remove(number)
                tracks[number][moment] = lamp
            else:
                tracks.append([*([None] * moment), lamp])
    whole = [_without_gaps(track) for track in tracks]
    return [[track[moment] for track in whole] for moment in range(len(found))]


def _last(track: Sequence[Lamp | None]) -> Lamp:
    return next(lamp for lamp in reversed(track) if lamp)


def _without_gaps(track: Sequence[Lamp | None]) -> list[Lamp]:
    seen = replace(next(lamp for lamp in track if lamp), irradiance=0.0)
    filled = []
    for lamp in track:
        seen = lamp or replace(seen, irradiance=0.0)
        filled.append(seen)
    return filled


def _disc(lamp: Lamp, order: int) -> Float64:
    """((order + 1)**2,) a disc of irradiance 1 in spherical harmonics.

    A zonal function scales band l by its own coefficient over that of a point: for a disc that is
    `(P_(l-1)(c) - P_(l+1)(c)) / ((2 l + 1) (1 - c))` with c the cosine of its radius.
    """
    point = sh.basis(lamp.direction[None], order)[0]
    cosine = np.cos(lamp.radius)
    if 1.0 - cosine < 1e-9:
        return np.asarray(point)
    legendre = np.polynomial.legendre.legvander(np.array([cosine]), order + 1)[0]  # type: ignore[no-untyped-call]
    factors = [1.0] + [
        (legendre[band - 1] - legendre[band + 1]) / ((2 * band + 1) * (1.0 - cosine)) for band in range(1, order + 1)
    ]
    return np.asarray(point * sh.per_coefficient(np.array(factors)))
