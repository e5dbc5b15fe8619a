# SPDX-License-Identifier: GPL-3.0-or-later
"""Receivers inside other geometry are found, others are not, and are filled from the open ones beside them."""

import re
from dataclasses import replace

import numpy as np
import pytest

from prt_addon.core.bake import bake as engine
from prt_addon.core.bake.bake import bounce
from prt_addon.core.bake.run import Run
from prt_addon.core.problem import BakeProblem, BakeSettings, Occluders, ReceiverGroup
from prt_addon.core.surface import Albedo
from prt_addon.core.transport import direct as transport_module
from prt_addon.core.transport import inside as buried_module
from prt_addon.core.transport.inside import Fill
from prt_addon.core.workers import Workers
from tests.core import shapes
from tests.core.baking import Noting, bake, trace_all
from tests.core.bouncing import Scene

SETTINGS = BakeSettings(samples=128, seed=3)
OPEN = 0.5 / np.sqrt(np.pi)


def edges_of(triangles):
    return np.unique(np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0)


def group_of(mesh, name="Mesh"):
    vertices, triangles = mesh
    radius = float(np.linalg.norm(np.ptp(vertices, axis=0))) / 2
    normals = shapes.vertex_normals(vertices, triangles)
    return ReceiverGroup(name, vertices, normals, radius, edges=edges_of(triangles).astype(np.int32), faces=triangles)


def scene_of(*meshes) -> Scene:
    """Groups of all meshes, and occluders whose corners show their own vertices."""
    vertices, triangles = shapes.joined(*meshes)
    groups = [group_of(mesh, f"mesh {k}") for k, mesh in enumerate(meshes)]
    return groups, Occluders(vertices, triangles, triangles.astype(np.int64))


def moved(mesh, *offset):
    return mesh[0] + offset, mesh[1]


def flipped(mesh):
    return mesh[0], mesh[1][:, ::-1]


def scaled(mesh, *factors):
    return mesh[0] * factors, mesh[1]


def buried_of(groups, occluders):
    """Which receivers of each group were filled."""
    traced = trace_all(groups, occluders, replace(SETTINGS, mode="INTERREFLECTED"))
    return np.split(traced.mended, np.cumsum(traced.sizes)[:-1])


def without(mesh, gone):
    """Less some triangles, and less the vertices that only these used."""
    used, triangles = np.unique(mesh[1][~gone], return_inverse=True)
    return mesh[0][used], triangles.reshape(-1, 3).astype(np.int32)


def ball_in_ground(ball=None):
    """A ball sunk to the middle in a slab whose top is z = 0, with a fine top of its own."""
    slab = scaled(shapes.icosphere(5), 4.0, 4.0, 2.0)
    slab[0][:, 2] = np.minimum(slab[0][:, 2], 0.0)
    return scene_of(ball or shapes.icosphere(4), slab)


def test_ball_sunk_into_the_ground_is_filled_below():
    """And nothing else: neither on the ball nor, but for what the ball covers, on the ground."""
    groups, occluders = ball_in_ground()
    ball, ground = buried_of(groups, occluders)
    height = groups[0].points[:, 2]
    assert ball[height < -0.01].all()
    assert not ball[height > 0.0].any()
    top = groups[1].points[:, 2] > -1e-9
    distance = np.linalg.norm(groups[1].points[:, :2], axis=1)
    assert ground[top & (distance < 0.95)].all()
    assert not ground[~top | (distance > 1.01)].any()


def test_no_black_ring_above_the_seam():
    """Below it, values are the seam's own; an unfilled bake is black there."""
    groups, occluders = ball_in_ground()
    bare = bake([replace(group, edges=None, faces=None) for group in groups], occluders, SETTINGS)
    filled = bake(groups, occluders, SETTINGS)
    height = groups[0].points[:, 2]
    ring = (height < -0.02) & (height > -0.15)
    assert bare[0][ring, 0].max() < 1e-3
    assert filled[0][ring, 0].min() > 0.3 * OPEN
    valid = ~np.concatenate(buried_of(groups, occluders))
    np.testing.assert_array_equal(np.concatenate(filled)[valid], np.concatenate(bare)[valid])


def test_a_solid_that_is_open_below_buries_too():
    """A stone without a bottom, on ground of single faces: what lies under it is filled."""
    stone = shapes.icosphere(4)
    stone = without(stone, stone[0][stone[1]][..., 2].min(axis=1) < -0.3)
    groups, occluders = scene_of(stone, shapes.grid(40, 6.0))
    _, ground = buried_of(groups, occluders)
    distance = np.linalg.norm(groups[1].points[:, :2], axis=1)
    assert ground[distance < 0.95].all()
    assert not ground[distance > 1.0].any()


def room(*, window, outwards):
    """Walls about a ball and a floor; with a window, most receivers still see next to no sky."""
    walls = shapes.icosphere(3)
    if window:
        walls = without(walls, walls[0][walls[1]][..., 0].min(axis=1) > 0.9)
    walls = scaled(walls, 6.0, 6.0, 6.0)
    return scene_of(
        moved(shapes.icosphere(3), -2.0, 0, -1.0), shapes.grid(30, 5.0), walls if outwards else flipped(walls)
    )


def roofed():
    """Wide ground under a low roof of single faces that look up: dark, and rightly so."""
    return scene_of(shapes.grid(60, 6.0), moved(shapes.grid(4, 4.0), 0, 0, 0.1))


def thicket():
    """Ground under thousands of loose blades, each seen from its front as often as from its back."""
    rng = np.random.default_rng(5)
    corners = rng.uniform((-2, -2, 0.0), (2, 2, 0.4), (4000, 1, 3)) + rng.normal(0, 0.12, (4000, 3, 3))
    blades = corners.reshape(-1, 3), np.arange(12000, dtype=np.int32).reshape(-1, 3)
    return scene_of(shapes.grid(60, 6.0), blades)


def two_sided():
    """A sheet that stands twice, once turned over: light falls on both."""
    return scene_of(shapes.grid(9), flipped(shapes.grid(9)))


@pytest.mark.parametrize(
    "scene",
    [
        lambda: room(window=True, outwards=True),
        lambda: room(window=True, outwards=False),
        lambda: room(window=False, outwards=True),
        lambda: room(window=False, outwards=False),
        roofed,
        thicket,
        lambda: scene_of(shapes.icosphere(3), scaled(shapes.icosphere(3), 9.0, 9.0, 9.0)),
        lambda: scene_of(flipped(shapes.icosphere(3))),
        two_sided,
        lambda: scene_of(shapes.bumpy_sphere(5)),
    ],
    ids=[
        "window-out",
        "window-in",
        "closed-out",
        "closed-in",
        "roof",
        "thicket",
        "wholly-inside",
        "inside-out",
        "two-sided",
        "dents",
    ],
)
def test_what_is_dark_for_a_reason_is_left_alone(scene):
    groups, occluders = scene()
    dark = [transport[:, 0] < 0.05 * OPEN for transport in bake(groups, occluders, SETTINGS)]
    for group, found in zip(groups, buried_of(groups, occluders), strict=True):
        assert found.mean() <= (0.25 if scene is thicket else 0.0), group.name
    assert np.concatenate(dark).any() == (scene is not two_sided)


def test_a_thicket_stays_dark():
    """What of it is taken for covered gets what its faces get: on the whole it is no brighter."""
    groups, occluders = thicket()
    bare = bake([replace(group, edges=None, faces=None) for group in groups], occluders, SETTINGS)
    for group, before, after in zip(groups, bare, bake(groups, occluders, SETTINGS), strict=True):
        assert 0.85 < after[:, 0].mean() / before[:, 0].mean() < 1.02, group.name


def test_bounces_neither_start_nor_end_in_the_ground():
    """Receivers about the seam are bright after every number of bounces, and without colour there are none."""
    groups, occluders = ball_in_ground()
    settings = replace(SETTINGS, mode="INTERREFLECTED")
    traced = trace_all(groups, occluders, settings)
    for bounces in (0, 1, 4):
        result = np.concatenate(bounce(traced, occluders, replace(settings, bounces=bounces)))
        ring = traced.mended[: len(groups[0])] & (groups[0].points[:, 2] > -0.15)
        assert result[: len(groups[0])][ring, 0].min() > 0.25 * OPEN
    dark = replace(occluders, albedo=Albedo(np.zeros(occluders.triangles.shape)))
    np.testing.assert_array_equal(
        np.concatenate(bounce(traced, dark, settings))[..., 0], np.concatenate(bake(groups, occluders, SETTINGS))
    )


def test_same_bits_for_any_chunks_threads_and_group_order(monkeypatch):
    groups, occluders = ball_in_ground()
    first = len(groups[0]), len(groups[1])
    corner = occluders.corner_receiver
    swapped = replace(occluders, corner_receiver=np.where(corner < first[0], corner + first[1], corner - first[0]))
    for mode in ("SHADOWED", "INTERREFLECTED"):
        settings = replace(SETTINGS, mode=mode)
        usual = bake(groups, occluders, settings, Run(Workers(1)))
        with monkeypatch.context() as patch:
            patch.setattr(transport_module, "_RAYS_AT_A_TIME", 1000)
            again = bake(groups[::-1], swapped, settings, Run(Workers(3)))
        for here, expected in zip(again[::-1], usual, strict=True):
            np.testing.assert_array_equal(here, expected)


def test_it_is_told_and_rays_are_not_counted():
    groups, occluders = ball_in_ground()
    monitor, problem = Noting(), BakeProblem.of(groups, occluders, SETTINGS)
    findings = engine.bake(problem, Run(Workers(monitor=monitor))).findings
    assert monitor.done == problem.work
    assert [number for number, _ in findings] == [0, 1]
    share = np.mean(buried_of(groups, occluders)[0])
    assert findings[0][1].sentence.startswith(f"{share:.0%} of the receivers of 'mesh 0' lie inside other geometry")


def test_black_and_tiny_objects_are_told():
    speck = scaled(shapes.icosphere(2), *[1e-4] * 3)
    groups, occluders = scene_of(flipped(shapes.icosphere(3)), moved(speck, -4, 0, 0), moved(speck, 4, 0, 0))
    (first, black), (second, tiny) = engine.bake(BakeProblem.of(groups, occluders, SETTINGS)).findings
    assert first == 0 and second in {1, 2}, "float32 is fine about one of the specks"
    assert "No light reaches 'mesh 0'" in black.sentence
    assert f"'mesh {second}' is tiny, and far from the finest part of the scene" in tiny.sentence


def test_an_object_that_is_dark_for_the_most_part_is_told():
    """An inward ball that lacks 30 of its 1280 triangles: few rays find the way out."""
    vertices, triangles = flipped(shapes.icosphere(3))
    groups, occluders = scene_of((vertices, triangles[30:]))
    [(_, notice)] = engine.bake(BakeProblem.of(groups, occluders, SETTINGS)).findings
    assert re.match(r"No light reaches [789]\d% of the receivers of 'mesh 0': ", notice.sentence)


def test_what_stands_in_a_room_with_a_window_is_not_told(monkeypatch):
    """Hardly any sky reaches it, but light from the walls does. The room itself is built with its faces inwards."""
    ball, room = scaled(shapes.icosphere(3), *[0.3] * 3), flipped(shapes.icosphere(3))
    window = (room[0], room[1][30:])
    groups, occluders = scene_of(ball, window)
    dark = bake(groups, occluders, SETTINGS)[0][:, 0] < 0.05 * OPEN
    assert dark.mean() > 0.75
    told = engine.bake(BakeProblem.of(groups, occluders, SETTINGS)).findings
    assert [number for number, _ in told] == [1]
    groups, occluders = scene_of(ball, flipped(window))
    told = engine.bake(BakeProblem.of(groups, occluders, SETTINGS)).findings
    assert [number for number, _ in told] == [0], (
        "seen from within, faces that point outwards are the inside of a solid"
    )


def test_usual_bakes_cast_no_more_rays(monkeypatch):
    """Nothing dark beside light: nothing to look at. A closed room is dark all over and costs none either."""
    monkeypatch.setattr(buried_module, "RayPattern", None)
    for mesh in (shapes.icosphere(4), shapes.torus(), flipped(shapes.icosphere(4))):
        bake(*scene_of(mesh), SETTINGS)


def test_fill_reaches_inwards_ring_by_ring():
    """A chain with values at both ends: means of what is known already; an island without any keeps its own."""
    edges = np.array([[0, 1], [1, 2], [2, 3], [3, 4], [5, 6]])
    fill = Fill(np.array([False, True, True, True, False, True, True]), edges)
    values = np.array([1, 9, 9, 9, 3, 7, 8], dtype=np.float32)[:, None]
    np.testing.assert_array_equal(fill(values)[:, 0], [1, 1, 2, 3, 3, 7, 8])


def test_regions_are_connected_components():
    rng = np.random.default_rng(0)
    edges = rng.integers(0, 3000, (2000, 2))
    expected = np.arange(3000)
    for _ in range(3000):
        low = np.minimum(expected[edges[:, 0]], expected[edges[:, 1]])
        before = expected.copy()
        np.minimum.at(expected, edges[:, 0], low)
        np.minimum.at(expected, edges[:, 1], low)
        if (before == expected).all():
            break
    np.testing.assert_array_equal(buried_module._regions(edges, 3000), expected)
    chain = np.stack([np.arange(99_999), np.arange(1, 100_000)], axis=1)
    assert not buried_module._regions(rng.permutation(chain), 100_000).any()
