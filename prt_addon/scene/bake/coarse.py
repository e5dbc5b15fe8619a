# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds meshes too coarse to show the shadows that fall on them, as light is kept per vertex."""

from __future__ import annotations

from math import ceil, log2, sqrt

import numpy as np

from ...core.notices import Kind, Notice
from ..mesh.meshes import Surface
from .plan import BakePlan, ObjectToBake

_COARSE = Kind(
    "{name} has faces larger than what shades it: light is kept per vertex, so that shadows on it are lost. Subdivide it.",
    "{count} objects have faces larger than what shades them: light is kept per vertex, so that shadows on them are lost. "
    "Subdivide them: {names}.",
    "INFO",
    "prt.refine",
)
_TOO_LARGE = 1.0  # a face, as a share of the radius of what stands around
_FINE = 0.2  # what it is subdivided to
_MOST_FACES = 1 << 18  # of an object that was subdivided
_MOST_LEVELS = 6


def coarse_objects(plan: BakePlan) -> list[Notice]:
    """A notice on each object of a plan that is too coarse, if it casts rays."""
    return [Notice(_COARSE, name) for name in levels(plan)] if plan.problem.casts_rays else []


def levels(plan: BakePlan) -> dict[str, int]:
    """How many times to cut the faces of each object that is too coarse into four, by its full name.

    The size of what shades an object is the median radius of all else that stays in its place.
    """
    found = {}
    for one in plan.objects:
        others = [radius for name, radius in plan.radii if name != one.name and radius > 0.0]
        if one.space == "SCENE" and others:
            level = _level(one, float(np.median(others)))
            if level:
                found[one.name] = level
    return found


def _level(one: ObjectToBake, shading: float) -> int:
    face = _largest_face(one.surface)
    if face <= _TOO_LARGE * shading:
        return 0
    room = log2(max(_MOST_FACES / max(len(one.surface.triangles), 1), 1.0)) / 2.0
    return int(min(ceil(log2(face / (_FINE * shading))), _MOST_LEVELS, room))


def _largest_face(surface: Surface) -> float:
    """The side of a square as large as two of the largest triangle."""
    a, b, c = (surface.vertices[surface.triangles[:, k]] for k in range(3))
    return sqrt(float(np.linalg.norm(np.cross(b - a, c - a), axis=1).max(initial=0.0)))
