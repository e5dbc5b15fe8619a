# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds scenes that light bounces in: panels, a corner, a room, a closed sphere."""

from dataclasses import replace

import numpy as np

from prt_addon.core.problem import BakeSettings, Occluders, ReceiverGroup
from prt_addon.core.surface import Albedo, CornerColours, TexturePatch
from prt_addon.core.transport.direct import Receivers
from prt_addon.core.transport.gather import Gather
from prt_addon.core.transport.hits import trace
from prt_addon.core.transport.raycast import RayScene

Scene = tuple[list[ReceiverGroup], Occluders]
SETTINGS = BakeSettings("INTERREFLECTED", samples=64, seed=3)


def panel(origin, right, up, count):
    """A flat grid of count x count vertices; its front looks along right x up."""
    s, t = (axis.ravel()[:, None] for axis in np.meshgrid(*[np.linspace(0, 1, count)] * 2, indexing="ij"))
    points = np.asarray(origin) + s * np.asarray(right) + t * np.asarray(up)
    index = np.arange(count * count).reshape(count, count)
    a, b, c, d = (part.ravel() for part in (index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]))
    normal = np.cross(right, up)
    normals = np.tile(normal / np.linalg.norm(normal), (len(points), 1))
    return points, normals, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])


def scene_of(panels, colours) -> Scene:
    """Groups, one per panel, and occluders whose corners show their own vertices."""
    groups = [ReceiverGroup(f"panel {i}", points, normals, 2.0) for i, (points, normals, _) in enumerate(panels)]
    first = np.cumsum([0, *(len(group) for group in groups)])
    triangles = np.concatenate([panel[2] + start for panel, start in zip(panels, first, strict=False)])
    constant = np.repeat(np.asarray(colours, dtype=np.float32), [len(panel[2]) for panel in panels], axis=0)
    vertices = np.concatenate([group.points for group in groups])
    return groups, Occluders(vertices, triangles.astype(np.int32), triangles.astype(np.int64), Albedo(constant))


def corner(count, colours=((0.8, 0.8, 0.8), (0.8, 0.1, 0.1), (0.6, 0.6, 0.6))) -> Scene:
    """A white floor, a red wall that stands off it by a gap, and an overhang that looks down."""
    return scene_of(
        [
            panel((0, -1, 0), (2, 0, 0), (0, 2, 0), count),
            panel((-0.3, -1, 0.1), (0, 2, 0), (0, 0, 1.5), count),
            panel((0.4, -0.5, 0.9), (0, 1, 0), (1.2, 0, 0), count),
        ],
        colours,
    )


def room(count) -> Scene:
    """A white room with a slit in the lid: nearly all light has bounced often."""
    floor, lid = panel((-1, -1, 0), (2, 0, 0), (0, 2, 0), count), panel((-1, -1, 2), (0, 2, 0), (1.1, 0, 0), count)
    walls = [
        panel((-1, -1, 0), (0, 2, 0), (0, 0, 2), count),
        panel((1, -1, 0), (0, 0, 2), (0, 2, 0), count),
        panel((-1, -1, 0), (0, 0, 2), (2, 0, 0), count),
        panel((-1, 1, 0), (2, 0, 0), (0, 0, 2), count),
    ]
    return scene_of([floor, *walls, lid], [[0.9] * 3] * 6)


def patterned(occluders):
    """The same scene with a checkered floor and a wall whose colour runs: triangles in thirds, as `corner` has them."""
    third = len(occluders.triangles) // 3
    uv = occluders.vertices[occluders.triangles[:third], :2].astype(np.float32)
    checker = np.random.default_rng(1).random((8, 8, 3), dtype=np.float32)
    wall = np.random.default_rng(2).random((third, 3, 3), dtype=np.float32)
    patterns = TexturePatch(np.arange(third), uv, checker), CornerColours(np.arange(third, 2 * third), wall)
    return replace(occluders, albedo=Albedo(occluders.albedo.constant, patterns))


def inside_sphere(rings=12, segments=24):
    """The inside of a closed sphere: scene, a receiver a little before each vertex, and its triangles."""
    polar, azimuth = np.linspace(0, np.pi, rings + 1)[1:-1], 2 * np.pi * np.arange(segments) / segments
    polar, azimuth = (angle.ravel() for angle in np.meshgrid(polar, azimuth, indexing="ij"))
    ring = np.stack([np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.cos(polar)], 1)
    vertices = np.concatenate([ring, [[0, 0, 1], [0, 0, -1]]])
    index = np.arange(len(ring)).reshape(rings - 1, segments)
    after = np.roll(index, -1, axis=1)
    a, b, c, d = (part.ravel() for part in (index[:-1], index[1:], after[1:], after[:-1]))
    north, south = np.full(segments, len(ring)), np.full(segments, len(ring) + 1)
    outward = [(a, b, c), (a, c, d), (north, index[0], after[0]), (south, after[-1], index[-1])]
    triangles = np.concatenate([np.stack(triangle, 1) for triangle in outward])[:, ::-1]
    scene = RayScene(vertices, triangles.astype(np.int32))
    return scene, receivers_at(scene.normalised(vertices * 0.9), -vertices), triangles


def receivers_at(points, normals):
    return Receivers(points, normals, np.arange(len(points)), np.full(len(points), 1e-4))


def gather_of(scene, receivers, corner_receiver, albedo, samples=64, seed=0):
    returns = np.ones(len(corner_receiver), dtype=bool)
    direct, hits = trace(scene, receivers, samples, seed, returns)
    return direct, Gather(hits, albedo, corner_receiver)
