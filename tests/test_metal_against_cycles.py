# SPDX-License-Identifier: GPL-3.0-or-later
"""Rough metal returns the energy that Cycles' does: a sphere under a constant sky, by GGX and by multiscatter GGX."""

import numpy as np
import pytest

from prt_addon.core.microfacet import compensation
from prt_addon.core.microfacet.albedo import by_quadrature
from prt_addon.core.microfacet.table import average_albedo

ROUGHNESS = tuple(np.arange(1, 11) / 10.0)
COLOUR = (0.9, 0.5, 0.2)
PIXELS = 24


@pytest.fixture
def furnace(blender, stage, tmp_path):
    """Looks at a metal sphere under a sky of 1, radiance (pixels, 3); and the cosine at each pixel, from a fifth on."""
    shader, shown, mu = stage.furnace(rim=0.2, pixels=PIXELS)

    def look(distribution, roughness, colour):
        shader.distribution, shader.inputs["Roughness"].default_value = distribution, roughness
        shader.inputs["Color"].default_value = (*colour, 1.0)
        return stage.render(tmp_path / "sphere.exr", "CYCLES", samples=256)[shown][:, :3]

    return look, mu


def test_one_bounce_loses_what_cycles_loses(furnace):
    """E(mu) at every roughness, averaged over rings; 1 is what white metal should return."""
    look, mu = furnace
    rings = np.digitize(mu, (0.5, 0.7, 0.9))
    for roughness in ROUGHNESS:
        found, ours = look("GGX", roughness, (1.0,) * 3)[:, 0], by_quadrature(mu, roughness).white
        means = np.array([[values[rings == ring].mean() for ring in range(4)] for values in (found, ours)])
        np.testing.assert_allclose(means[1], means[0], atol=5e-3)


def test_all_bounces_return_what_cycles_returns(furnace):
    """Both lobes of coloured metal, per channel; the course's colour would be noticed."""
    look, mu = furnace
    for roughness in ROUGHNESS:
        found = look("MULTI_GGX", roughness, COLOUR)
        albedo, average = by_quadrature(mu, roughness).white[:, None], average_albedo(roughness)
        ours = COLOUR * albedo + (1.0 - albedo) * compensation.bounce_colour(COLOUR, average)
        print(roughness, found.mean(axis=0), ours.mean(axis=0))  # pytest shows it on failure, or with -s
        np.testing.assert_allclose(ours.mean(axis=0), found.mean(axis=0), atol=2e-3)
    course = COLOUR * albedo + (1.0 - albedo) * compensation.course_bounce_colour(COLOUR, average)
    assert (course.mean(axis=0) - found.mean(axis=0))[1:].min() > 0.04
