# SPDX-License-Identifier: GPL-3.0-or-later
"""One bounce is a product with a dense matrix; its two savings, chosen corners and thin bounces, cost little noise."""

from dataclasses import replace

import numpy as np
import pytest

from prt_addon.core.bake.bake import bounce
from prt_addon.core.surface import Albedo
from prt_addon.core.transport import gather as gather_module
from prt_addon.core.transport.direct import RayPattern
from prt_addon.core.transport.gather import Gather
from prt_addon.core.transport.raycast import RayScene
from tests.core.baking import trace_all
from tests.core.bouncing import SETTINGS, corner, gather_of, panel, patterned, receivers_at, room, scene_of


def test_no_bounce_creates_energy():
    groups, occluders = corner(10)
    for albedo in (occluders.albedo, patterned(occluders).albedo):
        traced = trace_all(groups, occluders, SETTINGS)
        gather = Gather(traced.hits, albedo, occluders.corner_receiver)
        rows = gather(np.ones((len(traced.direct), gather.channels, 9), dtype=np.float32))
        assert rows.min() >= 0.0
        assert rows.max() <= 1.0 + 1e-6
    assert (rows[: len(groups[0])] > 0.05).any()


def test_gather_is_the_matrix_it_claims_to_be():
    """Against a dense matrix, built ray by ray in float64 from the definition."""
    groups, occluders = corner(5)
    occluders = patterned(occluders)
    scene = RayScene(occluders.vertices, occluders.triangles)
    points, normals = (np.concatenate([getattr(group, name) for group in groups]) for name in ("points", "normals"))
    receivers = receivers_at(scene.normalised(points), normals)
    rays = RayPattern(128, 5).rays(receivers)
    hits = scene.hits(rays.origins, rays.directions)
    returned_light = np.flatnonzero((hits.triangle >= 0) & hits.front)
    triangle, u, v = hits.triangle[returned_light], hits.u[returned_light], hits.v[returned_light]
    weight = np.stack([1 - u - v, u, v], 1)[:, :, None] * occluders.albedo.at(triangle, u, v)[:, None, :] / 128
    dense = np.zeros((len(points), len(points), 3))
    np.add.at(
        dense, (np.repeat(returned_light // 128, 3), occluders.corner_receiver[triangle].ravel()), weight.reshape(-1, 3)
    )
    state = np.random.default_rng(0).random((len(points), 3, 9), dtype=np.float32)
    _, gather = gather_of(scene, receivers, occluders.corner_receiver, occluders.albedo, 128, 5)
    np.testing.assert_allclose(gather(state), np.einsum("xyc,yck->xck", dense, state), atol=2e-5)


def test_choice_of_a_corner_keeps_the_energy_and_the_mean(monkeypatch):
    """One corner for three: the same light where all return the same, and on average wherever the light runs.

    Under a ramp, each receiver's error is a sum of random choices; their mean has no more than its own standard error.
    """
    groups, occluders = corner(24)
    hits = trace_all(groups, occluders, replace(SETTINGS, samples=256)).hits

    def both(state):
        results = []
        for limit in (0.0, np.inf):
            monkeypatch.setattr(gather_module, "_FINE", limit)
            results.append(Gather(hits, occluders.albedo, occluders.corner_receiver)(state))
        return results

    exact, chosen = both(np.ones((len(hits), 3, 9), dtype=np.float32))
    np.testing.assert_allclose(chosen, exact, rtol=1e-5)
    ramp = np.concatenate([group.points for group in groups]) @ np.random.default_rng(0).normal(size=(3, 9))
    exact, chosen = both(np.repeat(ramp[:, None, :], 3, axis=1).astype(np.float32))
    receives = exact[:, 0].any(axis=1)
    error = (chosen - exact)[receives]
    assert error.std() > 1e-4
    assert np.abs(error.mean(axis=0) / error.std(axis=0)).max() < 4.0 / np.sqrt(receives.sum())


@pytest.mark.parametrize("count", [9, 25])
def test_choice_of_a_corner_is_lost_in_the_noise_of_the_rays(monkeypatch, count):
    """A quarter of that noise would lengthen the error by a thirtieth."""
    groups, occluders = corner(count)
    settings = replace(SETTINGS, samples=256)
    traced = [trace_all(groups, occluders, replace(settings, seed=seed)) for seed in (0, 1)]
    usual = np.concatenate(bounce(traced[0], occluders, settings))
    monkeypatch.setattr(gather_module, "_FINE", 0.0)
    exact, other = (np.concatenate(bounce(one, occluders, settings)) for one in traced)
    noise = np.std(exact - other) / np.sqrt(2)
    assert 0.0 < np.std(usual - exact) < 0.25 * noise


def test_choice_of_a_corner_on_a_large_triangle(monkeypatch):
    """A small board on a ground of two triangles a thousand times as large: its rays hit the same place, and choose apart."""
    ground, board = (
        panel((-50, -50, 0), (100, 0, 0), (0, 100, 0), 2),
        panel((1, 2, 0.002), (0, 0.002, 0), (0, 0, 0.002), 9),
    )
    groups, occluders = scene_of([ground, board], [[0.8] * 3] * 2)
    hits = trace_all(groups, occluders, replace(SETTINGS, samples=256)).hits
    ramp = np.zeros((len(hits), 3, 9), dtype=np.float32)
    ramp[:4] = np.linspace(0.9, 1.1, 4)[:, None, None]

    def board_gets(limit):
        monkeypatch.setattr(gather_module, "_FINE", limit)
        return Gather(hits, occluders.albedo, occluders.corner_receiver)(ramp)[4:, 0, 0]

    exact, chosen = board_gets(0.0), board_gets(np.inf)
    spread = np.sqrt(np.var(np.linspace(0.9, 1.1, 4)) * 0.8 / 128)  # of about so many independent choices
    assert exact.min() > 0.1 and np.sqrt(np.mean((chosen - exact) ** 2)) < 1.5 * spread


@pytest.mark.parametrize("scenery, share", [(corner, 0.25), (room, 0.5)])
@pytest.mark.parametrize("count", [3, 9, 25])
def test_thin_bounces_are_lost_in_the_noise_of_the_rays(monkeypatch, scenery, count, share):
    """All bounces but the last read a quarter of the hits: a share of the noise lengthens the error by half its square."""
    groups, occluders = scenery(count)
    settings = replace(SETTINGS, samples=256, bounces=20)
    traced = [trace_all(groups, occluders, replace(settings, seed=seed)) for seed in (0, 1)]
    usual = np.concatenate(bounce(traced[0], occluders, settings))
    monkeypatch.setattr(gather_module, "THIN", 1)
    whole, other = (np.concatenate(bounce(one, occluders, settings)) for one in traced)
    noise = np.std(whole - other) / np.sqrt(2)
    assert 0.0 < np.std(usual - whole) < share * noise


def test_thin_bounces_keep_the_energy():
    groups, occluders = corner(10)
    occluders = patterned(occluders)
    traced = trace_all(groups, occluders, replace(SETTINGS, samples=30))
    plain = Albedo(occluders.albedo.constant)
    white = np.ones((len(traced.direct), 3, 9), dtype=np.float32)
    for albedo, closeness in ((plain, 0.02), (occluders.albedo, 0.05)):
        gather = Gather(traced.hits, albedo, occluders.corner_receiver)
        thin, whole = gather(white, thin=0), gather(white)
        assert thin.max() <= 1.0 + 1e-6
        np.testing.assert_array_equal(thin.any(axis=(1, 2)), whole.any(axis=(1, 2)))
        np.testing.assert_allclose(thin.mean(axis=0), whole.mean(axis=0), rtol=closeness)
    one_colour = Gather(traced.hits, Albedo(np.full_like(plain.constant, 0.5)), occluders.corner_receiver)
    np.testing.assert_allclose(one_colour(white[:, :1], thin=3), one_colour(white[:, :1]), rtol=1e-5)
