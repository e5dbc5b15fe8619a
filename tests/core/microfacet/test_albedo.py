# SPDX-License-Identifier: GPL-3.0-or-later
"""What rough mirrors return is the same in three ways, in closed forms, and in a table."""

import numpy as np
import pytest

from prt_addon.core.microfacet import albedo, fresnel, ggx
from prt_addon.core.microfacet.table import average_albedo, energy_table
from tests.core.references import hemisphere_quadrature

UP = (0.0, 0.0, 1.0)
CASES = [(mu, roughness) for mu in (0.1, 0.4, 0.8, 1.0) for roughness in (0.3, 0.5, 0.8, 1.0)]


def outgoing(mu):
    return np.array([np.sqrt(1.0 - mu * mu), 0.0, mu])


def textbook(mu, roughness, points=400):
    """E by quadrature over directions, of GGX and Smith written out (Heitz 2014): no code shared."""
    directions, weights = hemisphere_quadrature(UP, points)
    out, alpha = outgoing(mu), roughness**2
    half = directions + out
    half /= np.linalg.norm(half, axis=1, keepdims=True)
    tan2 = (half[:, 0] ** 2 + half[:, 1] ** 2) / half[:, 2] ** 2
    spread = 1.0 / (np.pi * alpha**2 * half[:, 2] ** 4 * (1.0 + tan2 / alpha**2) ** 2)
    cosines = np.stack([directions[:, 2], np.full(len(directions), mu)])
    hidden = (-1.0 + np.sqrt(1.0 + alpha**2 * (1.0 / cosines**2 - 1.0))) / 2.0
    brdf = spread / (1.0 + hidden.sum(axis=0)) / (4.0 * mu * directions[:, 2])
    return (brdf * directions[:, 2] * weights).sum()


def test_every_direction_sees_its_own_projected_area():
    """The areas of facets add up to the surface, and those a direction sees to what it sees of the surface (Smith)."""
    directions, weights = hemisphere_quadrature(UP, 300)
    for alpha in (0.25, 0.5, 1.0):
        area = ggx.distribution(directions[:, 2], alpha) * weights
        assert (area * directions[:, 2]).sum() == pytest.approx(1.0, abs=1e-4)
        for mu in (0.3, 0.9):
            seen = np.maximum(directions @ outgoing(mu), 0.0) / (1.0 + ggx.smith_lambda(mu, alpha))
            assert (area * seen).sum() == pytest.approx(mu, abs=1e-3)


def test_light_goes_both_ways_alike():
    directions, _ = hemisphere_quadrature(UP, 6)
    there = ggx.single_scattering(directions[:, None], directions[None], 0.3)
    np.testing.assert_allclose(there, there.T, rtol=1e-12)


@pytest.mark.parametrize(("mu", "roughness"), CASES)
def test_quadrature_is_the_integral(mu, roughness):
    assert albedo.by_quadrature(mu, roughness).white == pytest.approx(textbook(mu, roughness), abs=2e-3)


@pytest.mark.parametrize("sample", [albedo.by_uniform_sampling, albedo.by_ggx_sampling])
def test_samples_agree_within_their_standard_error(sample):
    """Over many cases the deviations are those of a normal distribution: neither biased nor too sure of themselves."""
    deviations = []
    for seed in range(8):
        for mu, roughness in CASES:
            found = sample(mu, roughness, 20_000, seed)
            deviations.append((found.value - albedo.by_quadrature(mu, roughness).white) / found.standard_error)
    count = len(deviations)
    assert abs(np.mean(deviations)) < 4.0 / np.sqrt(count)
    assert 0.8 < np.std(deviations) < 1.2
    assert np.abs(deviations).max() < 4.5


def test_normals_beat_directions_where_the_lobe_is_narrow():
    """As importance sampling is for; a wide lobe at a grazing angle is the other way round."""
    uniform, normals = albedo.by_uniform_sampling, albedo.by_ggx_sampling
    assert uniform(0.8, 0.3, 20_000).variance > 100.0 * normals(0.8, 0.3, 20_000).variance
    assert uniform(0.1, 1.0, 20_000).variance < normals(0.1, 1.0, 20_000).variance


def test_schlick_splits_the_sum():
    """A F0 + B is the albedo of coloured mirrors, by random directions."""
    mu, roughness, facing = 0.5, 0.6, 0.04
    split = albedo.by_quadrature(mu, roughness)
    incoming = np.random.default_rng(1).normal(size=(400_000, 3))
    incoming /= np.linalg.norm(incoming, axis=1, keepdims=True)
    incoming[:, 2] = np.abs(incoming[:, 2])
    half = incoming + outgoing(mu)
    cosine = np.sum(half * incoming, axis=1) / np.linalg.norm(half, axis=1)
    brdf = ggx.single_scattering(outgoing(mu), incoming, roughness**2)
    samples = 2.0 * np.pi * brdf * fresnel.schlick(facing, cosine) * incoming[:, 2]
    error = samples.std() / np.sqrt(len(samples))
    assert split.scale * facing + split.bias == pytest.approx(samples.mean(), abs=4.0 * error)


def test_fresnel_anchors():
    assert fresnel.schlick(0.04, 1.0) == pytest.approx(0.04) and fresnel.schlick(0.04, 0.0) == 1.0


def test_smooth_mirrors_lose_nothing():
    np.testing.assert_allclose(albedo.by_quadrature([0.1, 0.5, 1.0], 0.02).white, 1.0, atol=1e-3)


def test_table_is_what_it_was_made_of():
    """At its steps exactly, and between them nearly; roughness along rows."""
    table = energy_table()
    rows, columns = np.meshgrid(table.steps, table.steps, indexing="ij")
    assert np.array_equal(table.at(columns, rows).white, table.albedo.white)
    mu, roughness = np.random.default_rng(3).uniform(0.1, 0.98, (2, 200))
    np.testing.assert_allclose(table.at(mu, roughness).white, albedo.by_quadrature(mu, roughness).white, atol=5e-3)
    np.testing.assert_allclose(table.average_at(roughness), average_albedo(roughness), atol=1e-3)


def test_average_is_the_mean_over_light_from_everywhere():
    mu = np.sqrt((np.arange(400) + 0.5) / 400)  # even steps of mu**2: the cosine is in the density
    assert average_albedo(0.7) == pytest.approx(albedo.by_quadrature(mu, 0.7).white.mean(), abs=1e-4)
    assert (np.diff(average_albedo(np.linspace(0.1, 1.0, 10))) < 0.0).all()


@pytest.mark.parametrize("ways", [albedo.by_uniform_sampling, albedo.by_ggx_sampling])
def test_same_seed_same_bits(ways):
    assert ways(0.5, 0.5, 1000, 7) == ways(0.5, 0.5, 1000, 7) != ways(0.5, 0.5, 1000, 8)


@pytest.mark.parametrize(("mu", "roughness"), [(0.0, 0.5), (0.5, 0.0), (1.1, 0.5), (0.5, np.nan)])
def test_what_has_no_albedo_is_refused(mu, roughness):
    for refused in (
        lambda: albedo.by_quadrature(mu, roughness),
        lambda: albedo.by_ggx_sampling(mu, roughness, 10),
        lambda: albedo.by_uniform_sampling(mu, roughness, 10),
    ):
        with pytest.raises(ValueError, match=r"\(0, 1\]"):
            refused()
