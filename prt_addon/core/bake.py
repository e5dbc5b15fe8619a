# SPDX-License-Identifier: GPL-3.0-or-later
"""One bake from arrays to arrays: receivers of several objects, one scene of occluders, one set of settings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from .albedo import Albedo
from .errors import MeshError
from .gather import Gather
from .hits import KeptHits, trace
from .interreflection import interreflected
from .parallel import Progress, ignore_progress
from .raycast import RayScene
from .transport import Receivers, shadowed, unshadowed

Float32 = npt.NDArray[np.float32]
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
    """

    name: str
    points: Float64
    normals: Float64
    radius: float

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


@dataclass(frozen=True)
class Traced:
    """What the rays of an interreflected bake found; another albedo or number of bounces needs no new ones.

    sizes: receivers of each group.
    direct: (N, 9) float32 shadowed transport of all groups.
    hits: what the blocked rays hit.
    """

    sizes: list[int]
    direct: Float32
    hits: KeptHits

    @property
    def nbytes(self) -> int:
        """Memory it occupies."""
        return self.direct.nbytes + self.hits.nbytes


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
    """Transport of every group: (N, 9) float32 each, or (N, 9, 3) RGB if interreflected.

    Light bounces only off triangles whose corners are receivers: pass the groups of everything that shall bounce it, and
    drop the results that are not wanted. The result has the same bits whatever the order of the groups, the number of threads and the chunk size.

    Raises:
        MeshError: coordinates that are not finite, or nothing to cast rays at.
        RayCasterMissing: the mode casts rays and embreex is not installed.
        Cancelled: if `progress` raised it.
    """
    if settings.mode == "INTERREFLECTED":
        return bounce(
            trace_groups(groups, occluders, settings, progress, threads), occluders, settings, progress, threads
        )
    _check_finite(groups)
    if settings.mode == "UNSHADOWED":
        return [unshadowed(group.normals) for group in groups]
    scene = RayScene(occluders.vertices, occluders.triangles)
    receivers = _joined(groups, scene)
    transport = shadowed(scene, receivers, settings.samples, settings.seed, progress, threads)
    return _split(transport, [len(group) for group in groups])


def trace_groups(
    groups: Sequence[ReceiverGroup],
    occluders: Occluders,
    settings: BakeSettings,
    progress: Progress = ignore_progress,
    threads: int | None = None,
) -> Traced:
    """The first half of an interreflected bake: all of its rays. Arguments and errors as those of `bake`."""
    _check_finite(groups)
    scene = RayScene(occluders.vertices, occluders.triangles)
    returns = (_corner_receiver(occluders) >= 0).any(axis=1)
    receivers = _joined(groups, scene)
    direct, hits = trace(scene, receivers, settings.samples, settings.seed, returns, progress, threads)
    return Traced([len(group) for group in groups], direct, hits)


def bounce(
    traced: Traced,
    occluders: Occluders,
    settings: BakeSettings,
    progress: Progress = ignore_progress,
    threads: int | None = None,
) -> list[Float32]:
    """The second half: bounce the light. Only the albedo may differ from the occluders that were traced.

    Returns:
        (N, 9, 3) float32 per group, RGB.
    """
    albedo = occluders.albedo or Albedo(np.ones_like(occluders.triangles, dtype=np.float32))
    gather = Gather(traced.hits, albedo, _corner_receiver(occluders), progress, threads)
    transport = interreflected(traced.direct, gather, settings.bounces, settings.tolerance, progress)
    return _split(transport, traced.sizes)


def _check_finite(groups: Sequence[ReceiverGroup]) -> None:
    for group in groups:
        if not np.isfinite(group.points).all():
            raise MeshError(
                f"Mesh of '{group.name}' holds NaN or infinite coordinates: remove those vertices and bake again."
            )


def _corner_receiver(occluders: Occluders) -> npt.NDArray[np.int64]:
    if occluders.corner_receiver is None:
        return np.full(occluders.triangles.shape, -1, dtype=np.int64)
    return occluders.corner_receiver


def _split(transport: Float32, sizes: Sequence[int]) -> list[Float32]:
    return np.split(transport, np.cumsum(sizes)[:-1])


def _joined(groups: Sequence[ReceiverGroup], scene: RayScene) -> Receivers:
    return Receivers(
        points=scene.normalised(np.concatenate([group.points for group in groups])),
        normals=np.concatenate([group.normals for group in groups]),
        ids=np.concatenate([np.arange(len(group)) for group in groups]),
        skips=np.concatenate([np.full(len(group), scene.skip_length(group.radius)) for group in groups]),
    )
