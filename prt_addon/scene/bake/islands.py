# SPDX-License-Identifier: GPL-3.0-or-later
"""Joins objects that were read and that shade each other to the islands of a bake's problem."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from ...core.files import digest
from ...core.notices import Notice
from ...core.problem import Island, Occluders, ReceiverGroup
from ...core.surface import Albedo, Opacity, Pattern
from ..material.patterns import SurfaceValues
from ..mesh.meshes import ObjectReceivers, Surface
from ..mesh.record import Identity, IdentitySum


@dataclass(frozen=True)
class Read:
    """One object or instance: its surface, and what light that bounces needs of it."""

    surface: Surface
    identity: Identity
    blocks: bool
    receivers: ObjectReceivers | None
    albedo: SurfaceValues | None
    opacity: SurfaceValues | None = None

    @property
    def groups(self) -> list[ReceiverGroup]:
        """Its receivers: none, fronts, or fronts and backs."""
        return self.receivers.groups if self.receivers else []

    @property
    def has_backs(self) -> bool:
        """Whether its backs receive light and return it."""
        return len(self.groups) > 1

    @property
    def notices(self) -> list[Notice]:
        """What there is to say about its materials."""
        return [notice for found in (self.albedo, self.opacity) if found for notice in found.notices]


def of_others(everything: IdentitySum, read: Read) -> IdentitySum:
    """Sum up all that blocks light beside an object that was read."""
    return everything.without(read.identity) if read.blocks else everything


def first_groups(objects: Sequence[tuple[Read, bool]], others: Sequence[Read]) -> list[int]:
    """The number of the first group of each object: those that stay come first, then what stands around them, then each of
    the rest.

    Args:
        objects: each with whether it stays.
        others: all else that blocks light.
    """
    staying, moving = ([read for read, stays in objects if stays is wanted] for wanted in (True, False))
    starts = _starts(len(read.groups) for read in (*staying, *others, *moving)).tolist()
    numbers = {True: iter(starts[: len(staying)]), False: iter(starts[len(staying) + len(others) :])}
    return [next(numbers[stays]) for _, stays in objects]


def island(read: Sequence[Read], bounces: bool) -> Island:
    """Make the island of objects that shade each other."""
    return Island([group for one in read for group in one.groups], _joined(read, bounces))


def fingerprint(receiving: Iterable[tuple[str, Read]], everything: IdentitySum) -> str:
    """Digest the objects that receive light, what they are baked for, and all that blocks light. Colours play no part."""
    parts = [f"{everything.occluders:x}".encode()]
    for space, read in receiving:
        if read.receivers:
            identity = read.identity
            parts += [space.encode(), identity.shape, identity.normals, identity.placement]
    return digest(*parts).hex()


def _joined(read: Sequence[Read], bounces: bool) -> Occluders:
    """All surfaces as one; with bounces, also the receivers at their corners and their albedo.

    Receivers are counted as they are given, but surfaces are laid out by what they are: sums over what rays hit then
    run in the same order, and have the same bits, whichever objects were selected.
    """
    first_receiver = _starts(sum(map(len, one.groups)) for one in read)
    order = sorted((i for i, one in enumerate(read) if one.blocks), key=lambda i: read[i].identity.numbers)
    laid_out = [read[i] for i in order]
    if not laid_out:
        return Occluders(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int32))
    surfaces = [one.surface for one in laid_out]
    vertices = np.concatenate([surface.vertices for surface in surfaces])
    first_vertex = _starts(len(surface.vertices) for surface in surfaces)
    triangles = np.concatenate(
        [surface.triangles + start for surface, start in zip(surfaces, first_vertex, strict=True)], dtype=np.int32
    )
    one_sided = np.concatenate([surface.one_sided for surface in surfaces])
    opacity = _joined_opacity(laid_out)
    if not bounces:
        return Occluders(vertices, triangles, one_sided=one_sided, opacity=opacity)
    corners = [_receivers_at_corners(one, int(first_receiver[i])) for i, one in zip(order, laid_out, strict=True)]
    corner_receiver = np.concatenate(corners)
    backs = [_backs_at_corners(one, fronts) for one, fronts in zip(laid_out, corners, strict=True)]
    back_receiver = np.concatenate(backs) if any(one.has_backs for one in laid_out) else None
    return Occluders(vertices, triangles, corner_receiver, _joined_albedo(laid_out), one_sided, opacity, back_receiver)


def _receivers_at_corners(one: Read, first: int) -> npt.NDArray[np.int64]:
    """(T, 3) counted from the first of its own; -1 where nothing was read that could bounce light, as at hair."""
    if one.receivers is None:
        return np.full(one.surface.triangles.shape, -1, dtype=np.int64)
    return one.receivers.at_corners(one.surface) + first


def _backs_at_corners(one: Read, fronts: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    """(T, 3) the receivers of backs at its corners, from those of fronts, which they follow; -1 where it has none."""
    return fronts + len(one.groups[0]) if one.has_backs else np.full_like(fronts, -1)


def _joined_albedo(read: Sequence[Read]) -> Albedo:
    constants = [
        one.albedo.constant if one.albedo else np.zeros(one.surface.triangles.shape, dtype=np.float32) for one in read
    ]
    return Albedo(np.concatenate(constants), _joined_patterns(read, [one.albedo for one in read]))


def _joined_opacity(read: Sequence[Read]) -> Opacity | None:
    """None if all of it stops all light."""
    if not any(one.opacity for one in read):
        return None
    constants = [
        one.opacity.constant if one.opacity else np.ones((len(one.surface.triangles), 1), dtype=np.float32)
        for one in read
    ]
    return Opacity(np.concatenate(constants), _joined_patterns(read, [one.opacity for one in read]))


def _joined_patterns(read: Sequence[Read], found: Sequence[SurfaceValues | None]) -> tuple[Pattern, ...]:
    """The patterns that were found of each surface, over the triangles of all."""
    first_triangle = _starts(len(one.surface.triangles) for one in read)
    return tuple(
        replace(pattern, triangles=pattern.triangles + start)
        for one, start in zip(found, first_triangle, strict=True)
        for pattern in (one.patterns if one else ())
    )


def _starts(sizes: Iterable[int]) -> npt.NDArray[np.int64]:
    """Where each of some runs begins when they are laid end to end."""
    ends = np.cumsum(list(sizes))
    return np.concatenate([[0], ends[:-1]])
