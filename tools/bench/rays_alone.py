# SPDX-License-Identifier: GPL-3.0-or-later
"""Casts a bake's own rays alone, made beforehand and handed to `EmbreeScene.run`: the yardstick."""

from __future__ import annotations

from collections.abc import Sequence

from measure import NOTHING, Seconds, timed

from prt_addon.core.problem import BakeSettings, Occluders, ReceiverGroup
from prt_addon.core.transport.direct import RayPattern, Receivers
from prt_addon.core.transport.raycast import RayScene
from prt_addon.core.workers import ALL_CORES

_CHUNKS_IN_MEMORY = 48


def rays_alone(groups: Sequence[ReceiverGroup], occluders: Occluders, settings: BakeSettings) -> Seconds:
    """The same rays in the same chunks on as many threads, as the same query: occlusion, or the nearest hit.

    Making the rays and building the scene is not counted.
    """
    scene = RayScene(occluders.vertices, occluders.triangles)
    receivers = Receivers.of(groups, scene)
    pattern = RayPattern(settings.samples, settings.seed)
    query = {"output": True} if settings.mode == "INTERREFLECTED" else {"query": "OCCLUDED"}
    batch = pattern.chunk * _CHUNKS_IN_MEMORY
    total = NOTHING
    for first in range(0, len(receivers), batch):
        starts = range(first, min(first + batch, len(receivers)), pattern.chunk)
        rays = [pattern.rays(receivers[start : start + pattern.chunk]) for start in starts]

        def cast(part: slice) -> None:
            for one in rays[part]:  # noqa: B023 - runs before the next batch is made
                scene._scene.run(one.origins, one.directions, **query)

        total += timed(lambda: ALL_CORES.run(len(rays), 1, cast))  # noqa: B023
    return total
