# SPDX-License-Identifier: GPL-3.0-or-later
"""A problem says which settings matter, how much work it is, and what its rays depend on."""

from dataclasses import replace

import numpy as np
import pytest

from prt_addon.core.monitor import Work
from prt_addon.core.problem import BakeProblem, BakeSettings, Island
from tests.core import bouncing


@pytest.mark.parametrize(
    ("settings", "used"),
    [
        (BakeSettings("UNSHADOWED"), {"mode"}),
        (BakeSettings("SHADOWED", tolerance=0.1), {"mode", "samples", "seed"}),
        (BakeSettings("INTERREFLECTED"), {"mode", "samples", "seed", "bounces", "tolerance"}),
        (BakeSettings("INTERREFLECTED", tolerance=0.1), {"mode", "samples", "seed", "tolerance"}),
    ],
)
def test_each_mode_uses_some_settings(settings, used):
    assert settings.used == used


def test_work_is_counted_through_all_islands():
    groups, occluders = bouncing.corner(4)
    problem = BakeProblem((Island(groups, occluders), Island(groups[:1], occluders)), bouncing.SETTINGS)
    assert problem.receivers == 4 * 16
    assert problem.work.rays == 64 * 64 and 0 < problem.work.bounces < problem.work.rays
    assert replace(problem, settings=BakeSettings("UNSHADOWED")).work == Work()
    assert [(len(island), group, receiver) for island, group, receiver in problem.numbered()] == [
        (48, 0, 0),
        (16, 3, 48),
    ]


def test_a_trace_is_known_by_what_its_rays_depend_on():
    """Not by colours, bounces and tolerance; but by everything else."""
    groups, occluders = bouncing.corner(4)
    island, settings = Island(groups, occluders), bouncing.SETTINGS
    key = island.trace_key(settings)
    painted = replace(occluders, albedo=None)
    assert Island(groups, painted).trace_key(replace(settings, bounces=9, tolerance=0.1)) == key
    moved = replace(groups[0], points=groups[0].points + np.array([0, 0, 1e-9]))
    for other in (
        Island([moved, *groups[1:]], occluders),
        Island(groups[::-1], occluders),
        Island(groups[1:], occluders),
    ):
        assert other.trace_key(settings) != key
    for others in (
        replace(settings, seed=9),
        replace(settings, samples=128),
        replace(settings, mode="SHADOWED"),
    ):
        assert island.trace_key(others) != key
