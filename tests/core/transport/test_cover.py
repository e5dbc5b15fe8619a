# SPDX-License-Identifier: GPL-3.0-or-later
"""Faces whose corners lie inside other geometry show the light sampled all over their open parts.

The truth shares nothing with the fit: hemispheres of 1024 rays at random points, weighed alike, sorted into open and covered by
where the scenes were built.
"""

from dataclasses import replace

import numpy as np
import pytest

from prt_addon.core.bake.bake import bounce
from prt_addon.core.problem import BakeSettings, Occluders, ReceiverGroup
from prt_addon.core.transport.cover import Fit, Samples
from prt_addon.core.transport.direct import Receivers, shadowed
from prt_addon.core.transport.raycast import RayScene
from tests.core import shapes
from tests.core.baking import bake, trace_all
from tests.core.bouncing import Scene
from tests.core.transport.test_inside import flipped, group_of, moved, scaled

SETTINGS = BakeSettings(samples=256, seed=3)
POINTS = 3000


def box(centre, size, inwards=False):
    """Of twelve triangles."""
    vertices, triangles = shapes.box()
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    found = (vertices - (low + high) / 2) / (high - low) * np.array(size) + centre, triangles
    return flipped(found) if inwards else found


def quad(length, width):
    return scaled(shapes.grid(1, 1.0), length, width, 1.0)


def flat(mesh, name="Flat"):
    """Receivers at the corners of flat faces, a hair inside of them: one for each direction of each vertex."""
    vertices, triangles = mesh
    corners = vertices[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals = np.repeat(normals / np.linalg.norm(normals, axis=1, keepdims=True), 3, axis=0)
    points = corners.reshape(-1, 3)
    _, first, faces = np.unique(
        np.concatenate([points.round(6), normals.round(4)], axis=1), axis=0, return_index=True, return_inverse=True
    )
    faces = faces.reshape(-1, 3)
    middles = [np.bincount(faces.ravel(), np.repeat(corners.mean(axis=1)[:, k], 3)) for k in range(3)]
    middle = np.stack(middles, axis=1) / np.bincount(faces.ravel())[:, None]
    points = points[first] + 1e-3 * (middle - points[first])
    radius = float(np.linalg.norm(np.ptp(vertices, axis=0))) / 2
    return ReceiverGroup(name, points, normals[first], radius, faces=faces)


def scene_of(*groups_and_meshes) -> Scene:
    """Groups and their meshes as a scene; the corners of all triangles show their receivers."""
    groups, meshes = zip(*groups_and_meshes, strict=True)
    starts = np.cumsum([0, *map(len, groups)])
    corners = [group.faces + start for group, start in zip(groups, starts, strict=False)]
    return list(groups), Occluders(*shapes.joined(*meshes), np.concatenate(corners))


def flats(*meshes) -> Scene:
    return scene_of(*((flat(mesh, f"mesh {k}"), mesh) for k, mesh in enumerate(meshes)))


def error(groups, occluders, is_open, of=0, fitted=True):
    """RMS over the open part of a group of what its vertices show, less the truth, over that of the truth."""
    baked = groups if fitted else [replace(group, faces=None) for group in groups]
    group, transport = groups[of], bake(baked, occluders, SETTINGS)[of]
    corners = group.points[group.faces]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    rng = np.random.default_rng(5)
    face, (u, v) = rng.choice(len(area), POINTS, p=area / area.sum()), rng.random((2, POINTS))
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    shares = np.stack([1 - u - v, u, v], axis=1)
    points, normals = (np.einsum("nk,nkc->nc", shares, x[group.faces[face]]) for x in (group.points, group.normals))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    kept = is_open(points)
    scene = RayScene(occluders.vertices, occluders.triangles)
    places = scene.normalised(points[kept])
    receivers_there = Receivers(places, normals[kept], np.arange(kept.sum()), scene.skips(places, group.radius))
    truth = shadowed(scene, receivers_there, 1024, 9)
    shown = np.einsum("nk,nkc->nc", shares, transport[group.faces[face]])[kept]
    return np.sqrt(((shown - truth) ** 2).mean() / (truth**2).mean())


KERBS = [box((0, y, 0.05), (21, 0.6, 0.5)) for y in (-2.0, 2.0)]


def test_road_between_kerbs():
    """One quad, its four corners in the kerbs: black without the fit; with it nearer to the truth than one that ends there."""

    def between(points):
        return np.abs(points[:, 1]) < 1.69

    groups, occluders = flats(quad(20, 4), *KERBS)
    bare = [replace(groups[0], faces=None), *groups[1:]]
    assert np.abs(bake(bare, occluders, SETTINGS)[0]).max() < 1e-3
    found = error(groups, occluders, between)
    assert found < 0.2 and found < error(*flats(quad(20, 3.4), *KERBS), between)


@pytest.mark.parametrize("with_cornice", [False, True])
def test_room_with_skirting(with_cornice):
    """Closed boxes along the walls of a room that is open on one side: no more wrong than the room without them, by half."""
    room = box((0, 0, 1.25), (5, 4, 2.5), inwards=True)
    room = room[0], room[1][2:]
    heights = (0.05, 2.45) if with_cornice else (0.05,)
    boards = [box((0, y, z), (5, 0.1, 0.1)) for z in heights for y in (-1.95, 1.95)]
    boards += [box((x, 0, z), (0.1, 4, 0.1)) for z in heights for x in (-2.45, 2.45)]

    def in_the_open(points):
        return (np.abs(points - (0, 0, 1.25)) < (2.38, 1.88, 1.13)).sum(axis=1) >= 2

    assert error(*flats(room, *boards), in_the_open) < 1.5 * error(*flats(room), in_the_open)


@pytest.mark.parametrize("detail", [3, 4])
def test_ball_sunk_in_a_slab(detail):
    """No worse than a ball that lies free is at the same detail, by half."""
    ball, slab = shapes.icosphere(detail), box((0, 0, -1), (6, 6, 2))

    def above(points):
        return points[:, 2] > 0.01

    sunk = scene_of((group_of(ball), ball), (flat(slab), slab))
    free = scene_of((group_of(ball), ball), (flat(slab), moved(slab, 0, 0, -9)))
    assert error(*sunk, above) < 1.5 * error(*free, above) + 5e-3


@pytest.mark.parametrize("detail", [3, 4])
def test_ball_sunk_in_a_sheet(detail):
    """Below a floor that is a single sheet its vertices see the sky from below; above, nothing of that may show."""
    ball, floor = moved(shapes.icosphere(detail), 0, 0, -0.05), shapes.grid(20, 6.0)
    groups, occluders = scene_of((group_of(ball), ball), (group_of(floor), floor))

    def above(points):
        return points[:, 2] > 0.01

    found = error(groups, occluders, above)
    assert found < 0.015 and 4.0 * found < error(groups, occluders, above, fitted=False)


def test_solids_sunk_into_one_another():
    """Three balls, each in the others; without the fit each is further off."""
    spheres = (((0, 0, 0), 1.0), ((0.8, 0, 0.3), 0.6), ((0.5, 0.5, 0.5), 0.5))
    balls = [moved(scaled(shapes.icosphere(3), r, r, r), *centre) for centre, r in spheres]
    groups, occluders = scene_of(*((group_of(mesh), mesh) for mesh in balls))
    for of in range(3):

        def outside(points, others=spheres[:of] + spheres[of + 1 :]):
            return np.all([np.linalg.norm(points - np.array(c), axis=1) > 1.01 * r for c, r in others], axis=0)

        found = error(groups, occluders, outside, of)
        assert found < 0.015 and found < error(groups, occluders, outside, of, fitted=False)


def test_light_bounces_to_and_from_covered_corners():
    """The road gets the kerbs' light, and gives them its own."""
    groups, occluders = flats(quad(20, 4), *KERBS)
    settings = replace(SETTINGS, mode="INTERREFLECTED", bounces=2)
    road, kerb, _ = bounce(trace_all(groups, occluders, settings), occluders, settings)
    direct = bake(groups, occluders, SETTINGS)
    assert 1.0 < road[:, 0].mean() / direct[0][:, 0].mean() < 1.2
    facing = np.abs(groups[1].normals[:, 1]) > 0.9
    assert kerb[facing, 0, 0].mean() > 1.01 * direct[1][facing, 0].mean()


def test_fit_finds_what_is_linear():
    """Samples of a linear function over a fan of faces: the covered hub gets its value, whatever the others are."""
    rng = np.random.default_rng(0)
    rim = np.stack([np.cos(np.arange(6)), np.sin(np.arange(6))], axis=1)
    places = np.concatenate([[[0.0, 0.0]], rim])
    values = (places @ [2.0, -1.0] + 0.5).astype(np.float32)
    corners = np.array([[0, 1 + k, 1 + (k + 1) % 6] for k in range(6)]).repeat(9, axis=0)
    shares = rng.dirichlet((1.0, 1.0, 1.0), len(corners))
    covered = np.arange(7) == 0
    samples = Samples(None, corners, shares, np.ones(len(corners)), covered)
    rows = np.concatenate([np.where(covered, 9.0, values), (shares * values[corners]).sum(axis=1)]).astype(np.float32)
    found = Fit(samples, 7)(rows[:, None])
    np.testing.assert_allclose(found[0, 0], values[0], atol=0.05)
    np.testing.assert_array_equal(found[1:, 0], rows[1:])
