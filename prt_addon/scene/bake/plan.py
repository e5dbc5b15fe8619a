# SPDX-License-Identifier: GPL-3.0-or-later
"""Holds what is to be baked as it was read, without bpy data, so that nothing that happens meanwhile can change it."""

from __future__ import annotations

from dataclasses import dataclass

from ...core.layout import Space
from ...core.notices import Notice
from ...core.problem import BakeProblem, Island
from ..mesh.carrier import Geometry
from ..mesh.meshes import ObjectReceivers, Surface
from ..mesh.record import Evidence


@dataclass(frozen=True)
class ObjectToBake:
    """One object of a plan, without bpy data.

    name: its full name.
    surface: its own, as it renders, in the axes that it is baked in.
    receivers: where its transport is computed and stored.
    space: what it is baked for, SCENE or OBJECT.
    evidence: what its bake depends on.
    group: number of its receivers in the problem; those of its backs follow, if it has any.
    elements: vertices and face corners of its own mesh.
    positions: a digest of where its vertices lie.
    carried: what a carrier is to look like; None if the object's own mesh can hold the transport.
    """

    name: str
    surface: Surface
    receivers: ObjectReceivers
    space: Space
    evidence: Evidence
    group: int
    elements: tuple[int, int]
    positions: bytes
    carried: Geometry | None


@dataclass(frozen=True)
class BakePlan:
    """A bake of some objects of a scene.

    objects: in the order of the request.
    problem: for the engine. Its first island is the scene; each object that may move has one of its own.
    notices: what the user should know.
    radii: of all that stays in its place, with the name of the object, or none.
    """

    objects: list[ObjectToBake]
    problem: BakeProblem
    notices: list[Notice]
    radii: list[tuple[str, float]]

    @property
    def scene(self) -> Island:
        """The island of all that stays in its place."""
        return self.problem.islands[0]
