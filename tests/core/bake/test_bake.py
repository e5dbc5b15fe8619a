# SPDX-License-Identifier: GPL-3.0-or-later
"""Several objects are baked as one: they shade each other, and each gets its own transport, whatever is baked beside it."""

from dataclasses import replace

import numpy as np
import pytest

from prt_addon.core.bake.run import Run
from prt_addon.core.errors import Cancelled, MeshError, RayCasterMissing
from prt_addon.core.monitor import Work
from prt_addon.core.problem import BakeProblem, BakeSettings, Occluders, ReceiverGroup
from prt_addon.core.transport import raycast
from prt_addon.core.workers import Workers
from tests.core import shapes
from tests.core.baking import Noting, bake

SETTINGS = BakeSettings(samples=64, seed=3)


def scene():
    """A torus with a ball in its middle and a floor below, each an object of another size."""
    ball, torus, floor = shapes.icosphere(2), shapes.torus(), shapes.grid(8, 6.0)
    placed = {"Ball": (ball[0] * 0.5, ball[1]), "Torus": torus, "Floor": (floor[0] - (0, 0, 0.6), floor[1])}
    groups = [
        ReceiverGroup(name, vertices, shapes.vertex_normals(vertices, triangles), radius)
        for (name, (vertices, triangles)), radius in zip(placed.items(), (0.5, 1.5, 4.2), strict=True)
    ]
    return groups, Occluders(*shapes.joined(*placed.values()))


def by_name(groups, results):
    """Results under the names of their objects."""
    return dict(zip((group.name for group in groups), results, strict=True))


def test_one_array_per_object():
    """In the order given, one row per receiver, float32 as it is stored."""
    groups, occluders = scene()
    results = bake(groups, occluders, SETTINGS)
    assert [len(result) for result in results] == [len(group) for group in groups] == [162, 512, 81]
    assert all(result.shape[1] == 9 and result.dtype == np.float32 for result in results)


def test_objects_shadow_each_other():
    """Under the middle of a ball of radius r at a height h, the floor is left 1 - (r / h)^2 of its light."""
    groups, _ = scene()
    floor, sheet = groups[2], (shapes.grid(8, 6.0)[0] - (0, 0, 0.6), shapes.grid(8, 6.0)[1])
    ball = shapes.icosphere(4)
    together, alone = (
        bake([floor], Occluders(*shapes.joined(*meshes)), replace(SETTINGS, samples=4096))[0]
        for meshes in ([(ball[0] * 0.5, ball[1]), sheet], [sheet])
    )
    middle = np.argmin(np.linalg.norm(floor.points[:, :2], axis=1))
    assert np.linalg.norm(floor.points[middle] - (0, 0, -0.6)) < 1e-6
    assert alone[middle, 0] == pytest.approx(np.sqrt(1 / (4 * np.pi)), rel=1e-6)
    assert together[middle, 0] / alone[middle, 0] == pytest.approx(1 - (0.5 / 0.6) ** 2, abs=0.01)


def test_bits_do_not_depend_on_the_company():
    """Neither on the order of objects, nor on which are selected, nor on the threads."""
    groups, occluders = scene()
    expected = by_name(groups, bake(groups, occluders, SETTINGS))
    for some, threads in ((groups[::-1], 1), (groups[1:], 3), (groups[:1], 2), ([groups[2], groups[0]], None)):
        results = by_name(some, bake(some, occluders, SETTINGS, Run(Workers(threads))))
        assert all(np.array_equal(result, expected[name]) for name, result in results.items())


def test_seed_changes_the_noise():
    """And only the noise."""
    groups, occluders = scene()
    one, other = (bake(groups, occluders, BakeSettings(samples=256, seed=seed))[1] for seed in (0, 1))
    assert (one != other).any(axis=1).mean() > 0.5
    assert np.sqrt(np.mean((one - other) ** 2) / np.mean(one**2)) < 0.05


@pytest.mark.parametrize("mode", ["UNSHADOWED", "SHADOWED"])
def test_progress_ends_at_the_ray_count(mode):
    """The bar's total is known before the bake starts."""
    groups, occluders = scene()
    settings, monitor = BakeSettings(mode=mode, samples=64), Noting()
    bake(groups, occluders, settings, Run(Workers(monitor=monitor)))
    expected = Work(rays={"UNSHADOWED": 0, "SHADOWED": 64 * 755}[mode])
    assert monitor.done == BakeProblem.of(groups, occluders, settings).work == expected


def test_cancel_comes_out():
    """The caller's own exception, not one of the pool's."""
    groups, occluders = scene()

    def stop():
        raise Cancelled("stop")

    with pytest.raises(Cancelled, match="stop"):
        bake(groups, occluders, SETTINGS, Run(Workers(monitor=Noting(stop))))


@pytest.mark.parametrize("mode", ["UNSHADOWED", "SHADOWED"])
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_broken_coordinates_name_the_object(bad, mode):
    """The user must learn which of a hundred objects to repair."""
    groups, occluders = scene()
    groups[1].points[7, 2] = bad
    with pytest.raises(MeshError, match="'Torus'"):
        bake(groups, occluders, BakeSettings(mode=mode))


def test_broken_occluder_is_refused():
    """One that receives nothing has no name here, but must not pass."""
    groups, occluders = scene()
    occluders.vertices[-1, 0] = np.nan
    with pytest.raises(MeshError, match="NaN"):
        bake(groups, occluders, SETTINGS)


def test_empty_object_among_others():
    """A mesh whose vertices were all deleted gets an empty result, and shifts no one else's."""
    groups, occluders = scene()
    expected = bake(groups, occluders, SETTINGS)
    none = np.zeros((0, 3))
    for place in range(4):
        some = [*groups[:place], ReceiverGroup("Empty", none, none, 0.0), *groups[place:]]
        results = bake(some, occluders, SETTINGS)
        assert results.pop(place).shape == (0, 9)
        assert all(np.array_equal(result, want) for result, want in zip(results, expected, strict=True))


def test_without_the_ray_caster(monkeypatch):
    """Unshadowed casts no rays and works; shadowed says what is missing."""
    groups, occluders = scene()
    monkeypatch.setattr(raycast, "EmbreeScene", None)
    for group, result in zip(groups, bake(groups, occluders, BakeSettings("UNSHADOWED")), strict=True):
        assert result.shape == (len(group), 9)
        assert np.allclose(result[:, [3, 1, 2]], group.normals * np.sqrt(3 / (4 * np.pi)) * 2 / 3, rtol=0, atol=1e-6)
    with pytest.raises(RayCasterMissing, match="embreex"):
        bake(groups, occluders, SETTINGS)
