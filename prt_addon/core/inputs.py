# SPDX-License-Identifier: GPL-3.0-or-later
"""What a bake is given: its settings, the receivers of several objects, and what blocks their light."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from .albedo import Albedo

Float64 = npt.NDArray[np.float64]

Mode = Literal["UNSHADOWED", "SHADOWED", "INTERREFLECTED"]


@dataclass(frozen=True)
class BakeSettings:
    """What a bake depends on beside the geometry.

    samples: rays per receiver.
    bounces: of light, if interreflected and tolerance is 0.
    tolerance: if above 0, bounce until no coefficient changes by as much.
    """

    mode: Mode = "SHADOWED"
    samples: int = 256
    seed: int = 0
    bounces: int = 3
    tolerance: float = 0.0


@dataclass(frozen=True)
class ReceiverGroup:
    """The receivers of one object, in world space.

    name: the object's, for messages.
    points, normals: (N, 3) float64; normals are unit length.
    radius: of the object, to scale the skipped start of rays.
    own: if the object may move, all that blocks its light, instead of the scene: its own surface. Points, normals and
        result are then in the object's own axes, and `own.corner_receiver` counts its receivers alone.
    edges: (E, 2) pairs of receivers that are neighbours on the mesh, over which those inside other geometry are
        filled; without any, none is.
    """

    name: str
    points: Float64
    normals: Float64
    radius: float
    own: Occluders | None = None
    edges: npt.NDArray[np.int32] | None = None

    def __len__(self) -> int:
        return len(self.points)


@dataclass(frozen=True)
class Occluders:
    """All that blocks light, in world space.

    vertices: (V, 3) float64.
    triangles: (T, 3), front = counter-clockwise.
    corner_receiver: (T, 3) int64, which receiver, counted through all groups, stands at each corner of a triangle;
        -1 returns no light. All black if None. Only interreflection asks for it.
    albedo: of the triangles; white if None.
    """

    vertices: Float64
    triangles: npt.NDArray[np.int32]
    corner_receiver: npt.NDArray[np.int64] | None = None
    albedo: Albedo | None = None

    @property
    def receiver_at_corners(self) -> npt.NDArray[np.int64]:
        """(T, 3) as `corner_receiver`, -1 where there is none."""
        if self.corner_receiver is None:
            return np.full(self.triangles.shape, -1, dtype=np.int64)
        return self.corner_receiver
