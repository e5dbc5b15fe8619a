# SPDX-License-Identifier: GPL-3.0-or-later
"""Rough metal in a white furnace returns all light, and coloured metal the series of its bounces."""

import numpy as np
import pytest

from prt_addon.core.microfacet import compensation, ggx
from prt_addon.core.microfacet.table import average_albedo, energy_table
from tests.core.references import hemisphere_quadrature

ROUGHNESS = (0.3, 0.5, 0.8, 1.0)
DIRECTIONS, WEIGHTS = hemisphere_quadrature((0.0, 0.0, 1.0), 200)


def lobes(mu, roughness):
    """Radiance that both lobes of white mirrors return at an angle under a sky of 1, by quadrature over directions."""
    table, cos_in = energy_table(), DIRECTIONS[:, 2]
    out = np.array([np.sqrt(1.0 - mu * mu), 0.0, mu])
    first = ggx.single_scattering(out, DIRECTIONS, ggx.alpha_of(roughness))
    further = compensation.lost_lobe(
        table.at(mu, roughness).white, table.at(cos_in, roughness).white, table.average_at(roughness)
    )
    return (first * cos_in * WEIGHTS).sum(), (further * cos_in * WEIGHTS).sum()


def sphere(roughness):
    """Both lobes, averaged over the disc that a sphere shows from afar: even steps of mu squared."""
    return np.mean([lobes(mu, roughness) for mu in np.sqrt((np.arange(16) + 0.5) / 16)], axis=0)


@pytest.mark.parametrize("roughness", ROUGHNESS)
def test_white_spheres_return_all_light(roughness):
    """Everywhere but at the rim within 1 %; without the second lobe they lose as much as E_avg says."""
    for mu in (0.2, 0.5, 0.9):
        assert sum(lobes(mu, roughness)) == pytest.approx(1.0, abs=0.01)
    first, further = sphere(roughness)
    assert first + further == pytest.approx(1.0, abs=0.01)
    assert first == pytest.approx(average_albedo(roughness), abs=0.01)


@pytest.mark.parametrize("fresnel", [0.2, 0.7, 0.95])
@pytest.mark.parametrize("roughness", ROUGHNESS)
def test_coloured_spheres_return_the_series(roughness, fresnel):
    """Coloured at every bounce, and leaving by the share E_avg: summed up, bounce by bounce."""
    escape = average_albedo(roughness)
    series = sum(fresnel * escape * (fresnel * (1.0 - escape)) ** bounce for bounce in range(200))
    first, further = sphere(roughness)
    returned = fresnel * first + compensation.bounce_colour(fresnel, escape) * further
    assert returned == pytest.approx(series, rel=0.01)


def test_the_course_colours_once_too_little():
    """By how much its colour returns too much, as its docstring says; a white metal is right in both."""
    fresnel, escape = np.array([0.2, 0.5, 0.9, 1.0]), average_albedo(0.9)
    series = fresnel * escape / (1.0 - fresnel * (1.0 - escape))
    theirs = fresnel * escape + (1.0 - escape) * compensation.course_bounce_colour(fresnel, escape)
    np.testing.assert_allclose(theirs / series - 1.0, (1.0 - escape) * (1.0 - fresnel), atol=1e-12)


def test_what_loses_nothing_gets_nothing():
    assert compensation.lost_lobe(1.0, 0.5, 1.0) == 0.0
