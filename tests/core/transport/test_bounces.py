# SPDX-License-Identifier: GPL-3.0-or-later
"""Bounced light is that of closed forms and of a path tracer that shares none of its code."""

from dataclasses import replace
from statistics import NormalDist

import numpy as np
import pytest
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene

from prt_addon.core.bake import trace as casting
from prt_addon.core.bake.bake import bounce
from prt_addon.core.bake.run import Run
from prt_addon.core.errors import Cancelled
from prt_addon.core.files import in_file
from prt_addon.core.problem import BakeSettings, Occluders
from prt_addon.core.sphere import sh
from prt_addon.core.surface import Albedo, TexturePatch
from prt_addon.core.transport import direct as transport_module
from prt_addon.core.transport import gather as gather_module
from prt_addon.core.transport.bounces import interreflected
from prt_addon.core.transport.direct import shadowed
from prt_addon.core.transport.gather import Gather
from prt_addon.core.transport.hits import trace
from prt_addon.core.transport.raycast import RayScene
from prt_addon.core.workers import Workers
from tests.core.baking import Noting, bake, trace_all
from tests.core.bouncing import SETTINGS, corner, gather_of, inside_sphere, panel, patterned, receivers_at, scene_of


@pytest.mark.parametrize("rho", [0.25, 0.8])
def test_white_furnace_is_a_geometric_series(rho):
    scene, receivers, triangles = inside_sphere()
    direct, gather = gather_of(scene, receivers, triangles, Albedo(np.full(triangles.shape, rho)))
    assert not direct.any()
    lamp = np.ones_like(direct)
    for bounces in (0, 1, 3, 10):
        expected = (1 - rho ** (bounces + 1)) / (1 - rho)
        np.testing.assert_allclose(interreflected(lamp, gather, bounces), expected, rtol=1e-5)
    np.testing.assert_allclose(interreflected(lamp, gather, tolerance=1e-7), 1 / (1 - rho), rtol=1e-5)


def test_tolerance_stops_early_and_bounces_are_then_ignored():
    scene, receivers, triangles = inside_sphere()
    direct, gather = gather_of(scene, receivers, triangles, Albedo(np.full(triangles.shape, 0.5)))
    lamp = np.ones_like(direct)
    loose = interreflected(lamp, gather, bounces=0, tolerance=0.1)
    np.testing.assert_allclose(loose, interreflected(lamp, gather, bounces=4), rtol=1e-6)  # 0.5**4 < 0.1


def test_series_rises_and_stays_below_the_open_sky():
    """Two white planes that face each other: the first coefficient is a sum of positive terms, each less than the last."""
    groups, occluders = scene_of(
        [panel((-1, -1, 0), (2, 0, 0), (0, 2, 0), 9), panel((-1, -1, 0.5), (0, 2, 0), (2, 0, 0), 9)], [[1, 1, 1]] * 2
    )
    traced = trace_all(groups, occluders, SETTINGS)
    sums = [np.concatenate(bounce(traced, occluders, replace(SETTINGS, bounces=n)))[:, 0] for n in range(6)]
    steps = np.diff(sums, axis=0)
    assert (steps >= 0.0).all()
    assert (steps[1:].max(axis=(1, 2)) < steps[:-1].max(axis=(1, 2))).all()
    assert sums[-1].max() < sh.basis([0.0, 0.0, 1.0])[0] * (1 + 1e-6)


def test_corners_without_receiver_return_nothing():
    groups, occluders = corner(6)
    black = replace(occluders, corner_receiver=np.full_like(occluders.corner_receiver, -1))
    part = occluders.corner_receiver.copy()
    part[part >= len(groups[0])] = -1  # only the floor returns light
    wall_black = replace(occluders.albedo, constant=occluders.albedo.constant * (part[:, :1] >= 0))
    direct = bake(groups, occluders, replace(SETTINGS, mode="SHADOWED"))
    for floor, expected in zip(bake(groups, black, SETTINGS), direct, strict=True):
        np.testing.assert_array_equal(floor, np.repeat(expected[:, :, None], 3, axis=2))
    some = bake(groups, replace(occluders, corner_receiver=part), SETTINGS)
    for here, expected in zip(some, bake(groups, replace(occluders, albedo=wall_black), SETTINGS), strict=True):
        np.testing.assert_allclose(here, expected, atol=1e-6)


def test_direct_part_has_the_bits_of_shadowed():
    groups, occluders = corner(12)
    traced = trace_all(groups, occluders, SETTINGS)
    expected = np.concatenate(bake(groups, occluders, replace(SETTINGS, mode="SHADOWED")))
    np.testing.assert_array_equal(traced.direct, expected)
    dark = replace(occluders, albedo=Albedo(np.zeros(occluders.triangles.shape)))
    result = np.concatenate(bake(groups, dark, SETTINGS))
    np.testing.assert_array_equal(result, np.repeat(expected[:, :, None], 3, axis=2))
    assert result.dtype == np.float32


def test_same_bits_for_any_chunks_threads_and_group_order(monkeypatch):
    groups, occluders = corner(8)
    occluders = patterned(occluders)
    usual = bake(groups, occluders, SETTINGS, Run(Workers(1)))
    order = [2, 0, 1]
    first = np.cumsum([0, *(len(groups[i]) for i in order)])
    moved = np.concatenate([first[order.index(i)] + np.arange(len(groups[i])) for i in range(3)])
    shuffled = replace(occluders, corner_receiver=moved[occluders.corner_receiver])
    for rays, hits, threads in ((64, 1, 3), (640, 100, 2), (1 << 20, 1 << 20, 1)):
        monkeypatch.setattr(transport_module, "_RAYS_AT_A_TIME", rays)
        for limit in ("_RECEIVERS_AT_A_TIME", "_RAYS_IN_CACHE", "_COARSE_AT_A_TIME", "_TRIANGLES_AT_A_TIME"):
            monkeypatch.setattr(gather_module, limit, hits)
        again = bake([groups[i] for i in order], shuffled, SETTINGS, Run(Workers(threads)))
        for position, i in enumerate(order):
            np.testing.assert_array_equal(again[position], usual[i])


def test_same_bits_however_triangles_are_numbered():
    """Other objects come and go in front of them, and a receiver's result must not care."""
    groups, occluders = corner(8)
    occluders = patterned(occluders)
    order = np.roll(np.arange(len(occluders.triangles)), len(occluders.triangles) // 3)
    plain = Albedo(occluders.albedo.constant[order])
    moved = Occluders(occluders.vertices, occluders.triangles[order], occluders.corner_receiver[order], plain)
    straight = replace(occluders, albedo=Albedo(occluders.albedo.constant))
    for one, other in zip(bake(groups, moved, SETTINGS), bake(groups, straight, SETTINGS), strict=True):
        np.testing.assert_array_equal(one, other)


def turned_over(groups, occluders, number):
    """The same scene with one of its three panels turned over: its backs, whose receivers these now are, show where fronts did."""
    third = len(occluders.triangles) // 3
    part = slice(third * number, third * (number + 1))
    triangles, fronts = occluders.triangles.copy(), occluders.corner_receiver.copy()
    triangles[part] = triangles[part][:, ::-1]
    backs = np.full_like(fronts, -1)
    backs[part], fronts[part] = fronts[part][:, ::-1], -1
    return replace(occluders, triangles=triangles, corner_receiver=fronts, back_receiver=backs)


@pytest.mark.parametrize("number", [0, 1, 2])
def test_a_back_returns_light_as_a_front_does(number):
    """Light that bounces off a panel that was turned over is the same, but for the random corners that stand for hits."""
    groups, occluders = corner(8)
    usual = bake(groups, occluders, replace(SETTINGS, samples=256))
    over = turned_over(groups, occluders, number)
    for one, other in zip(bake(groups, over, replace(SETTINGS, samples=256)), usual, strict=True):
        assert np.abs(one - other).max() < 2e-3
    black = bake(groups, replace(over, back_receiver=None), replace(SETTINGS, samples=256))
    assert max(np.abs(one - other).max() for one, other in zip(black, usual, strict=True)) > 0.02


def test_a_back_has_the_colours_of_its_front():
    """A checkered floor and a wall of running colour, which lie across the triangles: as in a scene with their fronts there."""
    groups, occluders = corner(8)
    occluders = patterned(occluders)
    third = len(occluders.triangles) // 3
    tiles, wall = occluders.albedo.patterns
    for number, pattern in enumerate(
        (replace(tiles, uv=tiles.uv[:, ::-1]), replace(wall, colours=wall.colours[:, ::-1]))
    ):
        patterns = tuple(pattern if k == number else one for k, one in enumerate(occluders.albedo.patterns))
        over = turned_over(groups, replace(occluders, albedo=Albedo(occluders.albedo.constant, patterns)), number)
        assert len(over.albedo_of_sides.constant) == 6 * third
        for one, other in zip(bake(groups, over, SETTINGS), bake(groups, occluders, SETTINGS), strict=True):
            assert np.abs(one - other).max() < 4e-3


def test_a_tolerance_is_reached():
    """Each term is a share of the one before it; what stands for a coarse triangle must not flip for ever."""
    groups, occluders = corner(8)
    calls = []

    class Counted(Gather):
        def __call__(self, transport, thin=None):
            calls.append(thin)
            return super().__call__(transport, thin)

    settings = replace(SETTINGS, samples=30)
    traced = trace_all(groups, occluders, settings)
    occluders = patterned(occluders)
    interreflected(traced.direct, Counted(traced.hits, occluders.albedo, occluders.corner_receiver), 0, 1e-3)
    assert 3 < len(calls) < 20


@pytest.mark.parametrize("memory", [1 << 30, 20_000, 0])
@pytest.mark.parametrize("rays", [300, 5000])
def test_same_bits_in_any_pieces_in_memory_or_on_disk(monkeypatch, rays, memory):
    groups, occluders = corner(8)
    occluders = patterned(occluders)
    whole = trace_all(groups, occluders, SETTINGS)
    monkeypatch.setattr(casting, "RAYS_IN_A_PIECE", rays)
    pieces = trace_all(groups, occluders, SETTINGS, Run(memory=memory))
    assert len(pieces.hits.pieces) == -(-192 // max(1, rays // 64))
    assert [in_file(piece.packed) for piece in pieces.hits.pieces].count(True) in (
        range(1, 192) if memory == 20_000 else [len(pieces.hits.pieces) if memory == 0 else 0]
    )
    assert pieces.hits.nbytes <= memory + 192 * 16
    assert pieces.hits.count == whole.hits.count
    for one, other in zip(bounce(pieces, occluders, SETTINGS), bounce(whole, occluders, SETTINGS), strict=True):
        np.testing.assert_array_equal(one, other)


def test_another_albedo_needs_no_new_rays():
    groups, occluders = corner(8)
    traced = trace_all(groups, occluders, SETTINGS)
    edited = patterned(occluders)
    again = bounce(traced, edited, SETTINGS)
    for kept, fresh in zip(again, bake(groups, edited, SETTINGS), strict=True):
        np.testing.assert_array_equal(kept, fresh)
    assert traced.nbytes < len(traced.direct) * (64 * 8 + 9 * 4 + 8) + 8


def test_grey_is_worth_one_channel_and_equals_three():
    groups, occluders = corner(8, colours=[[0.5] * 3] * 3)
    traced = trace_all(groups, occluders, SETTINGS)
    almost = replace(occluders, albedo=Albedo(occluders.albedo.constant * np.array([1, 1, 0.5], dtype=np.float32)))
    assert Gather(traced.hits, occluders.albedo, occluders.corner_receiver).channels == 1
    for grey, colour in zip(bounce(traced, occluders, SETTINGS), bounce(traced, almost, SETTINGS), strict=True):
        np.testing.assert_allclose(grey[..., :2], colour[..., :2], atol=1e-7)


def test_a_two_coloured_floor_bleeds_each_colour_to_its_side():
    """A floor of two triangles with a picture, red for x < 0 and blue beyond: a mean over a triangle would mix them."""
    vertices = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], dtype=float)
    triangles = np.array([[0, 1, 2], [0, 2, 3]], dtype=np.int32)
    uv = ((vertices[:, :2] + 1) / 2).astype(np.float32)[triangles]
    picture = np.array([[[1, 0, 0], [0, 0, 1]]], dtype=np.float32)
    albedo = Albedo(np.zeros((2, 3)), (TexturePatch(np.arange(2), uv, picture, "Closest"),))
    scene = RayScene(vertices, triangles)
    points = np.array([[-0.7, 0, 0.1], [0.7, 0, 0.1], [0, 0, 0.1]])
    receivers = receivers_at(scene.normalised(points), np.tile([0.0, 0.0, -1.0], (3, 1)))
    _, gather = gather_of(scene, receivers, np.zeros((2, 3), dtype=np.int64), albedo, samples=1024)
    left, right, middle = gather(np.ones((3, 3, 9), dtype=np.float32))[:, :, 0]
    assert left[0] > 0.9
    assert left[2] < 0.02
    np.testing.assert_allclose(right[::-1], left, atol=0.005)
    np.testing.assert_allclose(middle[0], middle[2], atol=0.005)
    assert not np.any([left[1], right[1], middle[1]])


def test_bounces_can_be_cancelled():
    groups, occluders = corner(6)

    class Stop(Noting):
        def advance(self, work):
            if work.bounces:
                raise Cancelled("enough")

    with pytest.raises(Cancelled, match="enough"):
        bake(groups, occluders, SETTINGS, Run(Workers(monitor=Stop())))


def test_nothing_hit_leaves_nothing_to_bounce():
    groups, occluders = scene_of([panel((-1, -1, 0), (2, 0, 0), (0, 2, 0), 4)], [[0.9, 0.5, 0.1]])
    (result,) = bake(groups, occluders, SETTINGS)
    (direct,) = bake(groups, occluders, replace(SETTINGS, mode="SHADOWED"))
    np.testing.assert_array_equal(result, np.repeat(direct[:, :, None], 3, axis=2))
    assert trace_all(groups, occluders, SETTINGS).hits.count == 0


# --- against a path tracer --------------------------------------------------------------------------------------------


def cosine_directions(normals, rng):
    """Lambert's law by rejection-free sampling: a point on the unit sphere around the tip of the normal."""
    sphere = rng.normal(size=normals.shape)
    sphere /= np.linalg.norm(sphere, axis=1, keepdims=True)
    direction = normals + sphere
    return direction / np.linalg.norm(direction, axis=1, keepdims=True)


def path_traced(occluders, point, normal, bounces, paths, rng):
    """Every path's estimate (paths, 9, 3) of the transport at a point, on flat normals, with exactly so many bounces."""
    corners = occluders.vertices[occluders.triangles].astype(np.float32)
    flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]).astype(float)
    flat /= np.linalg.norm(flat, axis=1, keepdims=True)
    embree = EmbreeScene(robust=True)
    TriangleMesh(embree, corners)
    estimate = np.zeros((paths, 9, 3))
    alive, throughput = np.arange(paths), np.ones((paths, 3))
    origins, normals = np.tile(point, (paths, 1)), np.tile(normal, (paths, 1))
    for _ in range(bounces + 1):
        directions = cosine_directions(normals, rng)
        starts = (origins + 1e-4 * directions).astype(np.float32)
        found = embree.run(starts, directions.astype(np.float32), output=True)
        hit = found["primID"]
        open_sky = hit < 0
        estimate[alive[open_sky]] = sh.basis(directions[open_sky])[:, :, None] * throughput[open_sky, None, :]
        front = ~open_sky & ((flat[hit] * directions).sum(axis=1) < 0)
        origins = (starts + found["tfar"][:, None] * directions)[front]
        normals, alive = flat[hit[front]], alive[front]
        throughput = throughput[front] * occluders.albedo.constant[hit[front]]
    return estimate


def test_agrees_with_a_path_tracer_within_its_own_error():
    """No coefficient of any receiver is off by more than chance allows (Sidak's correction, one failure in 1000 seeds).

    Vertices are dense enough that interpolating between them, and the bake's own noise at 1024 rays, are small
    against the path tracer's standard error of about 1e-3.
    """
    count, paths, bounces = 33, 40_000, 3
    groups, occluders = corner(count)
    result = bake(groups, occluders, BakeSettings("INTERREFLECTED", samples=1024, seed=7, bounces=bounces))
    direct = bake(groups, occluders, BakeSettings("SHADOWED", samples=1024, seed=7))
    rng = np.random.default_rng(20021)
    scores, bleeding = [], []
    places = [(0, 4, 16), (0, 14, 16), (0, 28, 5), (1, 16, 8), (1, 7, 24), (2, 16, 16), (2, 4, 28)]
    for group, row, column in places:
        index = row * count + column
        surface = groups[group]
        estimate = path_traced(occluders, surface.points[index], surface.normals[index], bounces, paths, rng)
        error = estimate.std(axis=0, ddof=1) / np.sqrt(paths)
        scores.append((result[group][index] - estimate.mean(axis=0)) / error)
        bleeding.append((direct[group][index][:, None] - estimate.mean(axis=0)) / error)
    limit = NormalDist().inv_cdf(0.5 + 0.5 * 0.999 ** (1 / np.size(scores)))
    assert np.abs(scores).max() < limit
    assert np.abs(bleeding).max() > 10 * limit  # the test would notice a missing bounce


def test_nearest_hits_and_occlusion_agree_where_rays_graze_edges():
    """Every ray starts on a vertex, along the facets that meet there."""
    scene, receivers, triangles = inside_sphere()
    outside = receivers_at(receivers.points / 0.9, -receivers.normals)
    direct, _ = trace(scene, outside, 100, 1, np.ones(len(triangles), dtype=bool))
    np.testing.assert_array_equal(direct, shadowed(scene, outside, 100, 1))
