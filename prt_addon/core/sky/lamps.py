# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds lamps in a picture of the sky: spots so bright and small that lights with sharp shadows show them better than
bands.

What a spot exceeds its surroundings by becomes a distant lamp, a disc: direction, size, irradiance. All lamps of a sky share one
colour, so that one coefficient per band and order says what they are of the SH light. What their own colours differ by, and
what lies between spots, stays in the SH light.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from math import pi

import numpy as np
import numpy.typing as npt

from ..arrays import Float32, Float64
from ..sphere import sh
from ..sphere.equirect import directions_at, solid_angles, texels_along
from .projection import project_equirect

BRIGHT = 10.0
"""Times the sky's mean radiance, from which on a texel belongs to a spot, with all that it exceeds this by."""

ENOUGH = 0.03
"""Truncation of the light under which no more lamps are looked for."""

_REACH = np.radians(12.0)
"""Of a spot, from its middle: what is wider casts no shadow that bands would lose."""

_CELLS, _COARSE_CELLS = 512, 64  # rows of cells in which lamps are looked for, and their seeds
_REFINEMENTS = 8  # of the spots' middles: Lloyd's steps, of which the first two or three move anything
_WORTH_IT = 0.9  # what another lamp must leave of the truncation at most


@dataclass(frozen=True)
class Lamp:
    """A distant disc of one colour with its neighbours.

    Attributes:
        direction: (3,) unit vector towards it, in the picture's directions.
        irradiance: on a surface that faces it, mean of the channels.
        radius: of the disc, in radians.
    """

    direction: Float64
    irradiance: float
    radius: float


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


def find_lamps(picture: Float32, most: int, enough: float = 0.0) -> Lamps:
    """Take lamps out of a sky, the brightest first.

    Middles of spots are found one by one, each where most light is left, and refined by k-means, weighted by light. Unlike k-means
    alone that never averages two lamps: what is far from all of them stays in the sky.

    Args:
        picture: (H, W, 3) equirectangular radiance, row 0 at the bottom.
        most: so many lamps at most.
        enough: no more lamps than bring the truncation under this; with 0, as many as there are.
    """
    spots = _bright_texels(picture)
    if not most or spots is None:
        return Lamps()
    seeds = _seeds(spots, most)
    counts = range(1, len(seeds) + 1) if enough else [len(seeds)]
    found = [_lamps(spots, seeds[:count]) for count in counts]
    return _fewest(picture, [Lamps(), *found], enough) if enough else found[-1]


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


@dataclass(frozen=True)
class _Spots:
    """The texels of all spots, those of a large picture together as they fall into cells.

    Attributes:
        directions: (N, 3).
        excess: (N, 3) the light by which each is too bright.
        whole: (3,) all light of the sky.
    """

    directions: Float64
    excess: Float64
    whole: Float64

    @property
    def flux(self) -> Float64:
        """(N,) mean of the channels."""
        return np.asarray(self.excess.mean(axis=-1))

    def gathered(self, height: int) -> _Spots:
        """The same with all texels in a cell of a picture of so many rows as one."""
        cells, place = np.unique(
            np.ravel_multi_index(texels_along(self.directions, height, 2 * height), (height, 2 * height)),
            return_inverse=True,
        )
        excess, towards = np.zeros((len(cells), 3)), np.zeros((len(cells), 3))
        np.add.at(excess, place, self.excess)
        np.add.at(towards, place, self.directions * self.flux[:, None])
        return _Spots(towards / np.linalg.norm(towards, axis=-1, keepdims=True), excess, self.whole)


def _bright_texels(picture: Float32) -> _Spots | None:
    height, width = picture.shape[:2]
    ring = solid_angles(height, width)
    whole = np.einsum("h,hc->c", ring, [np.maximum(row, 0.0).sum(axis=0, dtype=np.float64) for row in picture])
    threshold = BRIGHT * whole.mean() / (4.0 * pi)
    found = [np.flatnonzero(row.mean(axis=-1) > threshold) for row in picture]  # row by row: copies stay small
    rows, columns = np.repeat(np.arange(height), [len(one) for one in found]), np.concatenate(found)
    if not len(rows):
        return None
    radiance = np.maximum(picture[rows, columns].astype(np.float64), 0.0)
    excess = radiance * (1.0 - threshold / radiance.mean(axis=-1, keepdims=True))
    directions = directions_at(rows + 0.5, (columns + 0.5) * (2.0 * height / width), height)
    return _Spots(directions, excess * ring[rows, None], whole).gathered(min(height, _CELLS))


def _seeds(spots: _Spots, most: int) -> Float64:
    """(at most `most`, 3) unit vectors: middles of spots, each where most light is left."""
    coarse = spots.gathered(_COARSE_CELLS)
    near = coarse.directions @ coarse.directions.T >= np.cos(_REACH)
    left, seeds = coarse.flux.copy(), list[Float64]()
    while len(seeds) < most and left.max() > 0.0:
        seed = _mean(coarse.directions, np.where(near[np.argmax(near @ left)], left, 0.0))
        seeds.append(seed)
        left = np.where(coarse.directions @ seed >= np.cos(_REACH), 0.0, left)
    return np.array(seeds)


def _lamps(spots: _Spots, seeds: Float64) -> Lamps:
    """A lamp near each seed."""
    flux, middles = spots.flux, seeds
    for _ in range(_REFINEMENTS):
        owner = _owners(spots.directions, middles)
        middles = np.array(
            [_mean(spots.directions, np.where(owner == number, flux, 0.0)) for number in range(len(seeds))]
        )
    lamps, taken, owner = [], np.zeros(3), _owners(spots.directions, middles)
    for number, middle in enumerate(middles):
        its = owner == number
        power = float(flux[its].sum())
        spread = (flux[its] * (1.0 - spots.directions[its] @ middle)).sum() / power
        radius = float(2.0 * np.sqrt(max(spread, 0.0)))  # of a disc of radius R: mean of angle^2 / 2 is R^2 / 4
        lamps.append(Lamp(middle, power, radius))
        taken += spots.excess[its].sum(axis=0)
    red, green, blue = taken / taken.mean()
    return Lamps(tuple(lamps), (float(red), float(green), float(blue)), float(taken.sum() / spots.whole.sum()))


def _owners(directions: Float64, middles: Float64) -> npt.NDArray[np.int64]:
    """(N,) the nearest middle of each direction, -1 where none is near."""
    cosines = directions @ middles.T
    nearest = cosines.argmax(axis=-1)
    return np.where(cosines.max(axis=-1) >= np.cos(_REACH), nearest, -1)


def _mean(directions: Float64, weights: Float64) -> Float64:
    """Unit vector of a weighted mean."""
    mean = weights @ directions
    return np.asarray(mean / np.linalg.norm(mean))


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


def _fewest(picture: Float32, choices: Sequence[Lamps], enough: float) -> Lamps:
    """The fewest lamps whose truncation is low enough, or not to be improved."""
    sky = project_equirect(picture, sh.MAX_ORDER)
    best, least = choices[0], truncation(sky)
    for lamps in choices[1:]:
        if least <= enough:
            break
        loss = truncation(sky - np.multiply.outer(lamps.light(sh.MAX_ORDER), lamps.colour), sky)
        if loss < _WORTH_IT * least:
            best, least = lamps, loss
    return best


def truncation(left: Float64, whole: Float64 | None = None) -> float:
    """What a light loses beyond order 2 where half of the sky is hidden, as a share of all that arrives there; RMS.

    The yardstick is a surface at the foot of a wall, turned in all ways: there a sharp light casts a sharp shadow, while in the
    open nothing of it would be lost.

    Args:
        left: ((order + 1)**2, 3) the light that is shown in bands.
        whole: the light that arrives; without it, the same.
    """
    lost = _arriving(left)[sh.ORDER + 1 :].sum()
    everything = _arriving(left if whole is None else whole).sum()
    return float(np.sqrt(lost / everything)) if everything > 0.0 else 0.0


def _arriving(light: Float64) -> Float64:
    """(order + 1,) mean square of what each band of a light sends to the foot of a wall."""
    order = sh.order_of(len(light))
    squares = (light**2).mean(axis=-1)
    return np.array([squares[sh.band_slice(band)].sum() * share for band, share in enumerate(_wall(order))])


@lru_cache
def _wall(order: int) -> tuple[float, ...]:
    """(order + 1,) mean square, over all turns, of the transport at the foot of a wall, per coefficient of each band."""
    height = 64
    x, _, z = np.moveaxis(directions_at(np.arange(height)[:, None] + 0.5, np.arange(2 * height) + 0.5, height), -1, 0)
    seen = np.where(x > 0.0, np.maximum(z, 0.0), 0.0) / pi
    transport = project_equirect(np.repeat(seen[..., None], 3, axis=-1), order)[:, 0]
    return tuple(float((transport[sh.band_slice(band)] ** 2).sum() / (2 * band + 1)) for band in range(order + 1))
