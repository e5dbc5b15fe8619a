# SPDX-License-Identifier: GPL-3.0-or-later
"""Puts what was read of a scene together: the plan of a bake, with the problem that the engine solves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import bpy
import numpy as np
import numpy.typing as npt

from ...core.layout import Space
from ...core.notices import Notice
from ...core.problem import BakeProblem, BakeSettings
from ..mesh.carrier import Geometry
from ..mesh.meshes import positions
from ..mesh.record import Evidence, IdentitySum
from .islands import Read, fingerprint, first_groups, island, of_others
from .plan import BakePlan, ObjectToBake


@dataclass(frozen=True)
class ReadObject:
    """An object to bake, as it was read.

    matrix: (4, 4), the object's in the world.
    carried: the geometry of a carrier for its transport; None if its own mesh holds that.
    """

    ob: bpy.types.Object
    read: Read
    space: Space
    matrix: npt.NDArray[np.float64]
    carried: Geometry | None

    @property
    def stays(self) -> bool:
        """Whether it shares light and shadow with the scene, and not with itself alone."""
        return self.space == "SCENE"


def bake_plan(
    objects: Sequence[ReadObject], others: Sequence[Read], settings: BakeSettings, notices: list[Notice]
) -> BakePlan:
    """The plan of a bake.

    Args:
        objects: to bake.
        others: all else that blocks light.
        settings: of the bake.
        notices: on what was read.
    """
    staying = [one for one in objects if one.stays]
    everything = IdentitySum.of(read.identity for read in (*(one.read for one in staying), *others) if read.blocks)
    groups = first_groups([(one.read, one.stays) for one in objects], others)
    return BakePlan(
        objects=[
            planned
            for one, number in zip(objects, groups, strict=True)
            if (planned := _object_to_bake(one, number, everything))
        ],
        problem=_problem(objects, others, settings, everything),
        notices=notices,
        radii=[(one.ob.name_full, _radius(one.read)) for one in staying] + [("", _radius(read)) for read in others],
    )


def _object_to_bake(one: ReadObject, group: int, everything: IdentitySum) -> ObjectToBake | None:
    ob, read = one.ob, one.read
    if not read.receivers:
        return None
    return ObjectToBake(
        ob.name_full,
        read.surface,
        read.receivers,
        one.space,
        Evidence(read.identity, one.matrix, of_others(everything, read) if one.stays else IdentitySum()),
        group,
        (len(ob.data.vertices), len(ob.data.loops)),
        positions(ob.data),
        one.carried,
    )


def _problem(
    objects: Sequence[ReadObject], others: Sequence[Read], settings: BakeSettings, everything: IdentitySum
) -> BakeProblem:
    """One island of all that stays where it is, and one of each object that may move."""
    bounces = settings.bounces_light
    receiving = [(one.space, one.read) for one in objects]
    return BakeProblem(
        islands=[
            island([*(one.read for one in objects if one.stays), *others], bounces),
            *(island([one.read], bounces) for one in objects if not one.stays),
        ],
        settings=settings,
        fingerprint=fingerprint([*receiving, *(("SCENE", read) for read in others)], everything),
    )


def _radius(read: Read) -> float:
    """Half of the diagonal of its box."""
    return float(np.linalg.norm(np.ptp(read.surface.vertices, axis=0))) / 2.0 if len(read.surface.vertices) else 0.0
