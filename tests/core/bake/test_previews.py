# SPDX-License-Identifier: GPL-3.0-or-later
"""Previews keep within their rays, and the bake after them has the bits of one without."""

from dataclasses import replace

import numpy as np
import pytest

from prt_addon.core.bake.cache import CasterCache, TraceCache
from prt_addon.core.bake.previews import FIRST, extent, is_worth, open_sky, preview_settings, previews
from prt_addon.core.bake.run import Run
from prt_addon.core.errors import Cancelled
from prt_addon.core.problem import MOST_SAMPLES, BakeProblem, BakeSettings
from prt_addon.core.transport.raycast import RayScene
from prt_addon.core.workers import Workers
from prt_addon.worker import tasks
from tests.core import bouncing
from tests.core.baking import Noting, bake
from tests.recording import recording

SETTINGS = replace(bouncing.SETTINGS, samples=256)


class Seeing(Noting):
    """Keeps what it is shown."""

    def __init__(self, act=lambda: None):
        super().__init__(act)
        self.shown = []

    def show(self, preview):
        self.shown.append(preview)


def with_previews(scene: bouncing.Scene, settings=SETTINGS, **options):
    """The transport of a bake with previews, and who watched it."""
    seeing = Seeing()
    run = Run(workers=Workers(2, seeing), **options)
    return tasks.bake_with_previews(BakeProblem.of(*scene, settings), run).transport, seeing


@pytest.mark.parametrize("samples", [1, 159, 160, 256, 799, 800, 1024, 4096, MOST_SAMPLES])
def test_all_together_take_a_tenth_of_the_rays_at_most(samples):
    """Each has four times the rays of the one before, and another would be too many."""
    found = [one.samples for one in preview_settings(replace(SETTINGS, samples=samples))]
    assert found == [FIRST * 4**k for k in range(len(found))]
    assert 10 * sum(found) <= samples < 10 * (sum(found) + FIRST * 4 ** len(found))


def test_they_have_one_bounce():
    for settings in preview_settings(BakeSettings("INTERREFLECTED", 4096, bounces=5, tolerance=0.01)):
        assert settings.bounces == 1 and "bounces" in settings.used


@pytest.mark.parametrize("mode", ["SHADOWED", "INTERREFLECTED"])
def test_a_bake_with_previews_has_the_bits_of_one_without(mode):
    """And counts the same work; its previews are bakes of their settings."""
    scene, settings = bouncing.corner(8), replace(SETTINGS, mode=mode, samples=1024)
    transport, seeing = with_previews(scene, settings)
    assert all(map(np.array_equal, transport, bake(*scene, settings)))
    assert seeing.done.rays == BakeProblem.of(*scene, settings).work.rays
    assert [(one.settings.samples, one.samples) for one in seeing.shown] == [(16, 1024), (64, 1024)]
    for one in seeing.shown:
        assert all(map(np.array_equal, one.result.transport, bake(*scene, one.settings)))


def test_they_are_close_to_what_they_show():
    """Of one bounce, a preview is within its noise of the whole."""
    scene, settings = bouncing.corner(8), replace(SETTINGS, samples=4096, bounces=1)
    transport, seeing = with_previews(scene, settings)
    whole = np.concatenate(transport)
    error = [np.linalg.norm(np.concatenate(one.result.transport) - whole) for one in seeing.shown]
    assert error[0] < 0.2 * np.linalg.norm(whole) and error[1] < error[0] / 2 and error[2] < error[1] / 2


def test_before_them_there_is_light_without_shadows():
    """Which takes no rays; each says how much of the bake it shows."""
    groups, occluders = bouncing.corner(8)
    first = open_sky(BakeProblem.of(groups, occluders, SETTINGS))
    unshadowed = bake(groups, occluders, BakeSettings("UNSHADOWED"))
    assert all(map(np.array_equal, first.result.transport, unshadowed))
    assert (first.samples, first.text) == (256, "without shadows")
    assert extent(replace(SETTINGS, samples=16), 256) == "16 of 256 rays"


def test_the_ray_caster_is_built_once(monkeypatch):
    built: list[object] = []
    monkeypatch.setattr(RayScene, "of", recording(RayScene.of, built))
    with_previews(bouncing.corner(6), replace(SETTINGS, samples=1024))
    assert len(built) == 1


def test_a_bake_that_needs_no_rays_has_none():
    """Its traces are cached, of all islands: it is there as soon as they would be."""
    scene, traces = bouncing.corner(6), TraceCache()
    first, seeing = with_previews(scene, traces=traces)
    again, seen_again = with_previews(scene, traces=traces)
    assert len(seeing.shown) == 1 and not seen_again.shown and all(map(np.array_equal, first, again))
    island = BakeProblem.of(*scene, SETTINGS).islands[0]
    other = replace(island, groups=[replace(group, name="Another") for group in island.groups])
    run = Run(traces=traces, casters=CasterCache())
    assert not list(previews(BakeProblem([island], SETTINGS), run))
    assert len(list(previews(BakeProblem([island, other], SETTINGS), run))) == 1


def test_short_bakes_are_not_worth_one():
    """They last no longer than their previews would; and what casts no rays is there at once."""
    groups, occluders = bouncing.corner(8)
    assert not is_worth(BakeProblem.of(groups, occluders, SETTINGS))
    assert is_worth(BakeProblem.of(groups, occluders, replace(SETTINGS, samples=1 << 15)))
    assert not is_worth(BakeProblem.of(groups, occluders, BakeSettings("UNSHADOWED", 1 << 15)))


def test_they_can_be_stopped():
    """Before anything is shown."""

    def stop():
        raise Cancelled("enough")

    seeing = Seeing(stop)
    with pytest.raises(Cancelled):
        tasks.bake_with_previews(BakeProblem.of(*bouncing.corner(8), SETTINGS), Run(workers=Workers(2, seeing)))
    assert not seeing.shown
