# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds lamps in a picture of the sky: spots so bright that lights with shadows of their own show them better than bands.

What a spot exceeds its surroundings by becomes a lamp. First come compact spots, suns and lamps, whose shadows are sharp; where bands
lose much of what these leave, wide ones, windows and clouds, and the glow around a sun. What the colours of spots differ by, and what
lies between them, stays in the SH light.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import pi

import numpy as np

from ..arrays import Float32, Float64, Int64
from ..sphere import sh
from ..sphere.equirect import directions_at, solid_angles, texels_along
from .lamps import Lamp, Lamps
from .projection import project_equirect
from .truncation import truncation

ENOUGH = 0.03
"""Truncation of the light under which no more lamps are looked for."""

_CELLS, _COARSE_CELLS = 512, 64  # rows of cells in which lamps are looked for, and their seeds
_REFINEMENTS = 8  # of the spots' middles: Lloyd's steps, of which the first two or three move anything
_WORTH_IT = 0.9  # what another lamp must leave of the truncation at most


@dataclass(frozen=True)
class _Kind:
    """Of spots.

    Attributes:
        brightness: times the sky's mean radiance, from which on a texel belongs to a spot, with all that it exceeds this by.
        reach: of a spot from its middle, in radians.
        heart: times the sky's mean radiance, that a spot of the kind has at least where its light comes from: a window may be as bright as
            the surroundings of a sun.
    """

    brightness: float
    reach: float
    heart: float = 0.0

    def near(self, directions: Float64, middles: Float64) -> Int64:
        """(N,) the nearest of the middles (M, 3) of spots for each direction (N, 3); -1 where none is in reach."""
        cosines = directions @ middles.T
        return np.where(cosines.max(axis=-1) >= np.cos(self.reach), cosines.argmax(axis=-1), -1)


_COMPACT = _Kind(10.0, float(np.radians(12.0)), 50.0)
_WIDE = _Kind(3.0, float(np.radians(20.0)))
"""Wide spots cast soft shadows. Of the skies that Blender ships these take the truncation of compact ones' rest from 3-20 % to 3-13 %."""


def find_lamps(picture: Float32, most: int, enough: float = 0.0, wide: bool = True) -> Lamps:
    """Take lamps out of a sky, compact ones before wide ones, the brightest first.

    Middles of spots are found one by one, each where most light is left, and refined by k-means, weighted by light. Unlike k-means
    alone that never averages two lamps: what is far from all of them stays in the sky.

    Args:
        picture: (H, W, 3) equirectangular radiance, row 0 at the bottom.
        most: so many lamps at most.
        enough: no more compact lamps than bring the truncation under this; with 0, as many as there are. There are never more wide ones
            than bring it under `ENOUGH`.
        wide: whether wide spots are looked for at all.
    """
    sky = _Sky(picture)
    _, found = _compact_and_all(sky, most, enough, wide)
    return found.shared(sky)


def extract_lamps(picture: Float32, most: int, enough: float = 0.0, wide: bool = True) -> tuple[Lamps, Float32]:
    """The lamps that `find_lamps` finds, and the picture without the light that was taken for them.

    Only what exceeds the brightness of its kind goes, so that spots are left in their own colours, as bright as the dimmest that are
    taken. Pictures higher than `_CELLS` lose it texel by texel, the lamps cell by cell: at the edge of a reach they may differ by a cell.

    Returns:
        The lamps; a picture of its own, or the one that was given if there are none.
    """
    sky = _Sky(picture)
    compact, found = _compact_and_all(sky, most, enough, wide)
    rest = picture.copy() if found.lamps else picture
    _dim(rest, sky, _COMPACT, compact.lamps)
    _dim(rest, sky, _WIDE, found.lamps[len(compact.lamps) :])
    return found.shared(sky), rest


@dataclass(frozen=True)
class _Sky:
    """A picture (H, W, 3), and what is known of it."""

    picture: Float32

    @cached_property
    def light(self) -> Float64:
        """(81, 3)."""
        return project_equirect(self.picture, sh.MAX_ORDER)

    @cached_property
    def whole(self) -> Float64:
        """(3,) all of its light."""
        rings = [np.maximum(row, 0.0).sum(axis=0, dtype=np.float64) for row in self.picture]
        return np.einsum("h,hc->c", solid_angles(*self.picture.shape[:2]), rings)

    @property
    def mean(self) -> float:
        """Its radiance, all around and over the channels."""
        return float(self.whole.mean() / (4.0 * pi))

    def brighter(self, kind: _Kind) -> tuple[Int64, Int64, Float64]:
        """(N,) rows, (N,) columns and (N, 3) directions of the texels that are as bright as spots of a kind."""
        height, width = self.picture.shape[:2]
        least = 3.0 * kind.brightness * self.mean
        sums = (row[:, 0] + row[:, 1] + row[:, 2] for row in self.picture)  # row by row: copies stay small
        found = [np.flatnonzero(row > least) for row in sums]
        rows, columns = np.repeat(np.arange(height), [len(one) for one in found]), np.concatenate(found)
        return rows, columns, directions_at(rows + 0.5, (columns + 0.5) * (2.0 * height / width), height)


@dataclass(frozen=True)
class _Taken:
    """Lamps, and the light (3,) that was taken out of the sky for them."""

    lamps: tuple[Lamp, ...] = ()
    light: Float64 | None = None

    def shared(self, sky: _Sky) -> Lamps:
        """The same in one colour."""
        if self.light is None:
            return Lamps()
        red, green, blue = (self.light / self.light.mean()).tolist()
        return Lamps(self.lamps, (red, green, blue), float(self.light.sum() / sky.whole.sum()))

    def truncation(self, sky: _Sky) -> float:
        """Of what is left of the sky."""
        lamps = self.shared(sky)
        return truncation(sky.light - np.multiply.outer(lamps.light(sh.MAX_ORDER), lamps.colour), sky.light)


@dataclass(frozen=True)
class _Spots:
    """The texels of all spots of a kind, those of a large picture together as they fall into cells.

    Attributes:
        kind: of the spots.
        least: radiance of the heart of each.
        directions: (N, 3).
        excess: (N, 3) the light by which each is too bright.
        radiance: (N,) mean of the channels.
    """

    kind: _Kind
    least: float
    directions: Float64
    excess: Float64
    radiance: Float64

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
        flux = self.flux
        columns = (self.excess, self.directions * flux[:, None], (self.radiance * flux)[:, None])
        sums = np.zeros((len(cells), 7))
        np.add.at(sums, place, np.concatenate(columns, axis=1))
        excess, towards, weighted = np.split(sums, (3, 6), axis=1)
        towards /= np.linalg.norm(towards, axis=-1, keepdims=True)
        return _Spots(self.kind, self.least, towards, excess, weighted[:, 0] / excess.mean(axis=-1))


def _compact_and_all(sky: _Sky, most: int, enough: float, wide: bool) -> tuple[_Taken, _Taken]:
    """The compact lamps of a sky, and these with the wide ones after them; arguments as those of `find_lamps`."""
    if not most:
        return _Taken(), _Taken()
    compact = _found(sky, _Taken(), _bright_texels(sky, _COMPACT), most, enough)
    rest = _bright_texels(sky, _WIDE, compact.lamps) if wide and len(compact.lamps) < most else None
    return compact, _found(sky, compact, rest, most, ENOUGH)


def _dim(rest: Float32, sky: _Sky, kind: _Kind, lamps: tuple[Lamp, ...]) -> None:
    """Take out of a picture, in place, by what texels in reach of lamps of a kind are too bright."""
    if not lamps:
        return
    rows, columns, directions = sky.brighter(kind)
    near = kind.near(directions, _middles(lamps)) >= 0
    rows, columns = rows[near], columns[near]
    rgb = rest[rows, columns].astype(np.float64)
    radiance = np.maximum(rgb, 0.0).mean(axis=-1, keepdims=True)
    kept = np.minimum(kind.brightness * sky.mean / radiance, 1.0)
    rest[rows, columns] = np.where(rgb > 0.0, kept * rgb, rgb)  # lamps take no negative light


def _middles(lamps: tuple[Lamp, ...]) -> Float64:
    """(M, 3)."""
    return np.array([lamp.direction for lamp in lamps])


def _bright_texels(sky: _Sky, kind: _Kind, compact: tuple[Lamp, ...] = ()) -> _Spots | None:
    """The spots of a kind; None if there are none.

    Args:
        sky: in which they are.
        kind: of spots.
        compact: lamps that have been taken out before.
    """
    height, width = sky.picture.shape[:2]
    threshold = kind.brightness * sky.mean
    rows, columns, directions = sky.brighter(kind)
    if not len(rows):
        return None
    rgb = np.maximum(sky.picture[rows, columns].astype(np.float64), 0.0)
    radiance = rgb.mean(axis=-1)
    left = radiance
    if compact:
        taken = _COMPACT.near(directions, _middles(compact)) >= 0
        left = np.where(taken, np.minimum(radiance, _COMPACT.brightness * sky.mean), radiance)
    excess = rgb * ((left - threshold) / radiance * solid_angles(height, width)[rows])[:, None]
    return _Spots(kind, kind.heart * sky.mean, directions, excess, radiance).gathered(min(height, _CELLS))


def _found(sky: _Sky, before: _Taken, spots: _Spots | None, most: int, enough: float) -> _Taken:
    """Lamps for spots, added to those before: the fewest whose truncation is low enough, or not to be improved; with 0, all."""
    most -= len(before.lamps)
    if spots is None or not most:
        return before
    seeds = _seeds(spots, most)
    if not enough and len(seeds):
        return _with_lamps(before, spots, seeds)
    best, least = before, before.truncation(sky)
    for count in range(1, len(seeds) + 1):
        if least <= enough:
            break
        more = _with_lamps(before, spots, seeds[:count])
        if (loss := more.truncation(sky)) < _WORTH_IT * least:
            best, least = more, loss
    return best


def _seeds(spots: _Spots, most: int) -> Float64:
    """(at most `most`, 3) unit vectors: middles of spots, each where most light is left."""
    coarse = spots.gathered(_COARSE_CELLS)
    near = coarse.directions @ coarse.directions.T >= np.cos(spots.kind.reach)
    left, seeds = coarse.flux.copy(), list[Float64]()
    while len(seeds) < most and left.max() > 0.0:
        its = np.where(near[np.argmax(near @ left)], left, 0.0)
        seed = _mean(coarse.directions, its)
        if its @ coarse.radiance >= spots.least * its.sum():
            seeds.append(seed)
        left = np.where(spots.kind.near(coarse.directions, seed[None]) >= 0, 0.0, left)
    return np.array(seeds).reshape(-1, 3)


def _with_lamps(before: _Taken, spots: _Spots, seeds: Float64) -> _Taken:
    """A lamp more near each seed."""
    flux, middles = spots.flux, seeds
    for _ in range(_REFINEMENTS):
        owner = spots.kind.near(spots.directions, middles)
        middles = np.array(
            [_mean(spots.directions, np.where(owner == number, flux, 0.0)) for number in range(len(seeds))]
        )
    owner = spots.kind.near(spots.directions, middles)
    lamps, taken = before.lamps, np.zeros(3) if before.light is None else before.light
    for number, middle in enumerate(middles):
        its = owner == number
        lamps += (_lamp(middle, spots.directions[its], flux[its], spots.radiance[its]),)
        taken = taken + spots.excess[its].sum(axis=0)
    return _Taken(lamps, taken)


def _lamp(middle: Float64, directions: Float64, flux: Float64, radiance: Float64) -> Lamp:
    """A disc in place of texels: their light, and how far that is from the middle."""
    power = float(flux.sum())
    spread = float(flux @ (1.0 - directions @ middle)) / power
    radius = float(2.0 * np.sqrt(max(spread, 0.0)))  # of a disc of radius R: mean of angle^2 / 2 is R^2 / 4
    return Lamp(middle, power, radius, float(flux @ radiance) / power)


def _mean(directions: Float64, weights: Float64) -> Float64:
    """Unit vector of a weighted mean."""
    mean = weights @ directions
    return np.asarray(mean / np.linalg.norm(mean))
