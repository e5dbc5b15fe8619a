# SPDX-License-Identifier: GPL-3.0-or-later
"""One bake from arrays to arrays: receivers of several objects, one scene of occluders, one set of settings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from .errors import MeshError
from .parallel import Progress, ignore_progress
from .raycast import RayScene
from .transport import Receivers, shadowed, unshadowed

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]

Mode = Literal["UNSHADOWED", "SHADOWED"]


@dataclass(frozen=True)
class BakeSettings:
    """What a bake depends on beside the geometry."""

    mode: Mode = "SHADOWED"
    samples: int = 256
    seed: int = 0


@dataclass(frozen=True)
class ReceiverGroup:
    """The receivers of one object, in world space.

    name: the object's, for messages.
    points, normals: (N, 3) float64; normals are unit length.
    radius: of the object, to scale the skipped start of rays.
    """

    name: str
    points: Float64
    normals: Float64
    radius: float

    def __len__(self) -> int:
        return len(self.points)


@dataclass(frozen=True)
class Occluders:
    """All that blocks light, in world space: vertices (V, 3) float64, triangles (T, 3) front = counter-clockwise."""

    vertices: Float64
    triangles: npt.NDArray[np.int32]


def ray_count(groups: Sequence[ReceiverGroup], settings: BakeSettings) -> int:
    """Rays that `bake` will report to its progress."""
    return 0 if settings.mode == "UNSHADOWED" else settings.samples * sum(map(len, groups))


def bake(
    groups: Sequence[ReceiverGroup],
    occluders: Occluders,
    settings: BakeSettings,
    progress: Progress = ignore_progress,
    threads: int | None = None,
) -> list[Float32]:
    """Transport of every group, (N, 9) float32 each.

    The result has the same bits whatever the order of the groups, the number of threads and the chunk size.

    Raises:
        MeshError: coordinates that are not finite, or nothing to cast rays at.
        RayCasterMissing: the mode casts rays and embreex is not installed.
        Cancelled: if `progress` raised it.
    """
    for group in groups:
        if not np.isfinite(group.points).all():
            raise MeshError(f"Mesh of '{group.name}' holds NaN or infinite coordinates: remove those vertices and bake again.")
    if settings.mode == "UNSHADOWED":
        return [unshadowed(group.normals) for group in groups]
    scene = RayScene(occluders.vertices, occluders.triangles)
    receivers = _joined(groups, scene)
    transport = shadowed(scene, receivers, settings.samples, settings.seed, progress, threads)
    return np.split(transport, np.cumsum([len(group) for group in groups])[:-1])


def _joined(groups: Sequence[ReceiverGroup], scene: RayScene) -> Receivers:
    return Receivers(
        points=scene.normalised(np.concatenate([group.points for group in groups])),
        normals=np.concatenate([group.normals for group in groups]),
        ids=np.concatenate([np.arange(len(group)) for group in groups]),
        skips=np.concatenate([np.full(len(group), scene.skip_length(group.radius)) for group in groups]),
    )
