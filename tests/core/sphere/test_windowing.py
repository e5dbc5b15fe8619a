# SPDX-License-Identifier: GPL-3.0-or-later
"""Windows have the published factors, deringing takes the mildest that is enough, and energy lies in the bands it is said to."""

import numpy as np
import pytest

from prt_addon.core.sphere import windowing
from tests.core.references import order2, random_directions, sphere_quadrature

KINDS = ["HANN", "LANCZOS"]


def lamp(direction, radiance=(1.0, 0.5, 0.25)):
    """The order-2 light of a small, strong sun: it rings."""
    return np.outer(order2(np.asarray(direction)), radiance)


def values(light, count=60):
    """The reconstructed light over a dense product grid that is not the engine's."""
    return order2(sphere_quadrature(count)[0]) @ light


def test_published_factors():
    """The formulas at cutoffs where they are known by heart."""
    assert np.array_equal(windowing.band_factors("NONE"), [1, 1, 1])
    assert np.allclose(windowing.band_factors("HANN"), [1, 0.75, 0.25])
    assert np.allclose(windowing.band_factors("HANN", 2), [1, 0.5, 0])
    assert np.allclose(windowing.band_factors("LANCZOS", 2), [1, 2 / np.pi, 0])
    assert np.allclose(windowing.band_factors("LANCZOS"), [1, np.sqrt(27) / (2 * np.pi), np.sqrt(27) / (4 * np.pi)])


@pytest.mark.parametrize("kind", KINDS)
def test_factors_at_the_ends(kind):
    """A wide window keeps everything, the narrowest the mean alone, and nothing comes back beyond the cutoff."""
    assert np.array_equal(windowing.band_factors(kind, np.inf, 8), np.ones(9))
    assert np.allclose(windowing.band_factors(kind, 1, 8), [1] + [0] * 8, rtol=0, atol=1e-15)
    factors = windowing.band_factors(kind, 4.5, 8)
    assert (np.diff(factors[:6]) < 0).all() and np.allclose(factors[5:], 0, rtol=0, atol=1e-15)


@pytest.mark.parametrize("cutoff", [0, 0.5, -1, np.nan])
def test_no_cutoff_below_one(cutoff):
    """Band 0 is never dimmed."""
    with pytest.raises(ValueError, match="at least 1"):
        windowing.band_factors("HANN", cutoff)


def test_windowed_scales_bands():
    """Every coefficient by its band's factor."""
    scaled = windowing.windowed(np.ones((9, 3)), np.array([1, 0.5, 0.25]))
    assert np.array_equal(scaled[:, 1], [1, 0.5, 0.5, 0.5, 0.25, 0.25, 0.25, 0.25, 0.25])


@pytest.mark.parametrize("seed", range(20))
def test_minimum_is_that_of_a_descent(seed):
    """Against many directions, the best of which slides downhill."""
    light = np.random.default_rng(seed).normal(size=(9, 2)) * ([1.0], [3.0], [3.0], [3.0], *[[1.0 + seed % 3]] * 5)
    for channel in range(2):
        best = random_directions(4000, seed)
        for reach in 0.5 ** np.arange(2, 30):
            best = best[np.argsort(order2(best) @ light[:, channel])[:20]]
            near = best[:, None] + reach * random_directions(100, seed + 1)
            best = np.concatenate([best, (near / np.linalg.norm(near, axis=-1, keepdims=True)).reshape(-1, 3)])
        descended = (order2(best) @ light[:, channel]).min()
        assert np.isclose(windowing.minimum(light)[channel], descended, rtol=0, atol=1e-7)
        assert windowing.minimum(light)[channel] <= descended + 1e-12


def test_minimum_by_hand():
    """Closed forms, among them those where the linear part has nothing along the least axis (the hard case)."""
    zonal = order2(np.array([0, 0, 1.0]))
    one, z, zz = (np.where(np.arange(9) == index, 1 / zonal[index], 0) for index in (0, 2, 6))  # 1, z, (3z^2 - 1) / 2
    x = np.where(np.arange(9) == 3, z[2], 0)
    cases = {
        2.0: 2 * one,
        -1.0: z,
        -0.5: zz,  # a whole ring of minima
        1.0: 2 * one - zz,
        -2 / 3: zz + z,  # 1.5 z^2 + z - 0.5, at z = -1/3
        -2.0: zz + 1.5 * x,  # on the ring, away from x
        -1 - 1 / 24: 0.5 * x - zz,  # 0.5 - 1.5 (1 - x^2) + 0.5 x, at x = -1/6, off the axis
        0.0: 0 * one,
    }
    for least, light in cases.items():
        assert np.isclose(windowing.minimum(light[:, None])[0], least, rtol=0, atol=1e-9), least


@pytest.mark.parametrize("band_1", [0.0, 1e-300, 1e-160, 1e-30, 1e-17, 1e-9])
@pytest.mark.parametrize("seed", range(5))
def test_minimum_with_next_to_no_band_1(band_1, seed):
    """Below the last bit of band 2 it changes nothing; the minimum stays that of band 2."""
    light = np.random.default_rng(seed).normal(size=(9, 3))
    light[1:4] = 0.0
    wanted = windowing.minimum(light)
    light[1:4] = band_1 * np.random.default_rng(seed + 1).normal(size=(3, 3))
    np.testing.assert_allclose(windowing.minimum(light), wanted, atol=1e-14 + 10.0 * band_1)
    assert (windowing.minimum(light) <= values(light, 60).min(axis=0)).all()


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("direction", [*np.eye(3), *random_directions(3)])
def test_deringing_a_lamp(kind, direction):
    """No direction is left negative, and a slightly wider window would not have done."""
    light = lamp(direction)
    done = windowing.dering(light, kind)
    assert values(light).min() < -0.05 and done.negative_before > 0.2
    assert values(done.light).min() > -1e-9 and done.negative_after == 0
    assert np.array_equal(done.light, windowing.windowed(light, done.factors))
    assert np.array_equal(done.factors, windowing.band_factors(kind, done.cutoff))
    wider = windowing.windowed(light, windowing.band_factors(kind, done.cutoff * 1.001))
    assert windowing.minimum(wider).min() < 0


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", range(8))
def test_deringing_takes_the_mildest(kind, seed):
    """Of the cutoffs of a plain search on a grid of directions, none wider leaves the sky without a negative part."""
    random = np.random.default_rng(seed)
    light = np.concatenate([3 + random.uniform(size=(1, 3)), random.normal(size=(8, 3))])
    done = windowing.dering(light, kind)
    for inverse in np.linspace(0, 1 / done.cutoff - 1e-3, 50):
        wider = windowing.windowed(light, windowing.band_factors(kind, 1 / inverse if inverse > 0 else np.inf))
        assert values(wider).min() < 1e-3
    assert values(done.light).min() > -1e-9


def test_one_cutoff_for_all_channels():
    """The worst channel decides; the colours do not drift apart."""
    calm, ringing = np.eye(9)[0] * 4, lamp((0, 0, 1))[:, 0]
    alone = windowing.dering(np.stack([ringing] * 3, axis=1))
    mixed = windowing.dering(np.stack([calm, ringing, calm], axis=1))
    assert mixed.cutoff == alone.cutoff
    assert np.allclose(mixed.light[:, 0], calm)


@pytest.mark.parametrize("radiance", [0.0, 1.0, 1e-4, 1e6])
def test_calm_skies_are_left_alone(radiance):
    """A constant sky, a black one, and one that only just touches zero."""
    constant = np.zeros((9, 3))
    constant[0] = radiance * np.sqrt(4 * np.pi)
    touching = constant.copy()
    touching[2] = constant[0] / np.sqrt(3)  # radiance * (1 + z)
    for light in (constant, touching):
        done = windowing.dering(light)
        assert done.cutoff == np.inf and np.array_equal(done.light, light)
        assert done.negative_before <= 1e-3 and done.negative_after <= 1e-3


def test_scale_does_not_matter():
    """Photographs come in any unit."""
    light = lamp(random_directions(1)[0])
    assert np.isclose(windowing.dering(light * 1e5).cutoff, windowing.dering(light).cutoff, rtol=1e-9)


def test_a_sky_below_zero_keeps_its_mean():
    """No window can help: band 0 alone is left, and the share says so."""
    done = windowing.dering(-lamp((1, 0, 0)))
    assert np.allclose(done.light[1:], 0, rtol=0, atol=1e-15) and done.negative_after == 1


def test_negative_share():
    """Caps of known area, and the union over channels."""
    light = np.zeros((9, 3))
    light[0], light[2, 0] = 0.5 * np.sqrt(4 * np.pi), np.sqrt(4 * np.pi / 3)  # 0.5 + z: below z = -0.5
    assert np.isclose(windowing.negative_share(light), 0.25, rtol=0, atol=1e-3)
    light[2, 1] = -light[2, 0]
    assert np.isclose(windowing.negative_share(light), 0.5, rtol=0, atol=1e-3)
    assert windowing.negative_share(light[:1]) == 0


def test_energy_shares():
    """Parseval: the coefficients' squares are the integral of the light's square."""
    light = np.random.default_rng(3).normal(size=(9, 3))
    directions, weights = sphere_quadrature(6)
    basis, expected = order2(directions), []
    for band in range(3):
        here = slice(band**2, (band + 1) ** 2)
        expected.append(np.sum(weights[:, None] * (basis[:, here] @ light[here]) ** 2))
    assert np.allclose(windowing.energy_shares(light), np.array(expected) / np.sum(expected))
    assert np.allclose(windowing.energy_shares(light, 2 * np.sum(expected)).sum(), 0.5)
    assert np.array_equal(windowing.energy_shares(np.zeros((9, 3))), [0, 0, 0])
