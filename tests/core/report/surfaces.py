# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes baked surfaces for reports to judge, and skies to judge them under."""

import numpy as np

from prt_addon.core.problem import Occluders, ReceiverGroup
from prt_addon.core.report.findings import Effort
from prt_addon.core.report.subject import Lighting, Scenery, Subject
from prt_addon.core.sky.find_lamps import ENOUGH
from prt_addon.core.sky.projection import project_equirect
from prt_addon.core.sphere import sh
from prt_addon.core.sphere.rotation import rotation_matrix
from prt_addon.core.surface import Albedo
from tests.core import shapes
from tests.core.baking import bake

FEW = Effort(points=128, samples=64)


SCENE = np.eye(3)

AUTOMATIC = 4, ENOUGH
"""Rule of the lamps that are looked for."""


def directions(height, width):
    azimuth, elevation = np.meshgrid(
        2.0 * np.pi * (0.5 - (np.arange(width) + 0.5) / width), np.pi * ((np.arange(height) + 0.5) / height - 0.5)
    )
    ring = np.cos(elevation)
    return np.stack([ring * np.cos(azimuth), ring * np.sin(azimuth), np.sin(elevation)], axis=-1)


def smooth_sky():
    """Order 2 and nothing beyond, nowhere negative."""
    light = np.random.default_rng(5).normal(size=(9, 3))
    light[0] = 8.0
    return (sh.basis(directions(128, 256)) @ light).astype(np.float32)


def sunny_sky():
    """A grey sky with a sun that carries half of its light."""
    pixels = np.full((64, 128, 3), 0.5, dtype=np.float32)
    pixels[46, 30] = 0.5 * 4.0 * np.pi / (2.0 * np.pi / 128 * np.diff(np.sin(np.pi * (np.array([46, 47]) / 64 - 0.5))))
    return pixels


def light_of(pixels, turn=SCENE):
    """The sky, and its projection as the world would store it."""
    return Lighting(pixels, turn, rotation_matrix(turn.T) @ project_equirect(pixels), AUTOMATIC)


def subjects_of(parts, settings, colours=None, **bake_options):
    """Subjects of meshes (name: (vertices, triangles)) that are baked together."""
    vertices, triangles = shapes.joined(*parts.values())
    normals = shapes.vertex_normals(vertices, triangles)
    sizes = [len(points) for points, _ in parts.values()]
    starts = np.concatenate([[0], np.cumsum(sizes)])
    groups = [
        ReceiverGroup(name, vertices[first:last], normals[first:last], 2.0)
        for name, first, last in zip(parts, starts[:-1], starts[1:], strict=True)
    ]
    albedo = Albedo(np.full((len(triangles), 3), 0.8) if colours is None else colours(triangles))
    occluders = Occluders(vertices, triangles, triangles.astype(np.int64), albedo)
    stored = [
        each if each.ndim == 3 else np.repeat(each[..., None], 3, -1) for each in bake(groups, occluders, settings)
    ]
    scenery = Scenery(occluders, groups, np.concatenate(stored))
    return [
        Subject(group, settings, transport, points[own], own.astype(np.int64), scenery, SCENE)
        for group, transport, (points, own) in zip(groups, stored, parts.values(), strict=True)
    ]


def floor(cells, roof_height=0.3):
    """A floor under a small roof whose shadow is soft."""
    vertices, triangles = shapes.grid(4, 0.8)
    return {"floor": shapes.grid(cells), "roof": (vertices + np.array((0.0, 0.0, roof_height)), triangles)}


def half(estimate):
    """Half an interval."""
    return (estimate.high - estimate.low) / 2.0
