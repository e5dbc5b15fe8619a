# SPDX-License-Identifier: GPL-3.0-or-later
"""The basis is the textbook's, in our convention, and the cosine lobe is its integral."""

import numpy as np
import pytest

from prt_addon.core.sphere import sh
from tests.core.references import axis_angle, order2, random_directions, sphere_quadrature

ORDERS = range(sh.MAX_ORDER + 1)


def test_basis_is_the_textbook_one():
    """Sign, order and scale of all nine: every file and shader relies on them."""
    directions = np.concatenate([random_directions(200), np.eye(3), -np.eye(3)])
    assert np.allclose(sh.basis(directions), order2(directions), rtol=0, atol=1e-14)


@pytest.mark.parametrize("order", ORDERS)
def test_basis_is_orthonormal(order):
    """Projection is a plain integral only if the basis is orthonormal."""
    directions, weights = sphere_quadrature(sh.MAX_ORDER + 1)
    values = sh.basis(directions, order)
    gram = values.T @ (values * weights[:, None])
    assert np.allclose(gram, np.eye((order + 1) ** 2), rtol=0, atol=1e-13)


@pytest.mark.parametrize("band", ORDERS)
def test_addition_theorem(band):
    """Each band spans the right functions: its kernel is the Legendre polynomial of the angle between."""
    a, b = random_directions(100, 3), random_directions(100, 4)
    here = slice(band**2, (band + 1) ** 2)
    kernel = np.sum(sh.basis(a, sh.MAX_ORDER)[:, here] * sh.basis(b, sh.MAX_ORDER)[:, here], axis=1)
    legendre = np.polynomial.legendre.Legendre.basis(band)(np.sum(a * b, axis=1))
    assert np.allclose(kernel, (2 * band + 1) / (4 * np.pi) * legendre, rtol=0, atol=1e-13)


def test_index_holds_band_and_azimuthal_number():
    """At l(l+1)+m and l(l+1)-m sit the cosine and sine of m azimuths, in this order, through order 8."""
    angle = 0.7
    directions = random_directions(50)
    before, after = sh.basis(directions, 8), sh.basis(directions @ axis_angle((0, 0, 1), angle).T, 8)
    for band in range(9):
        for m in range(band + 1):
            plus, minus = band * (band + 1) + m, band * (band + 1) - m
            cosine = np.cos(m * angle) * before[:, plus] - np.sin(m * angle) * before[:, minus] * (m > 0)
            assert np.allclose(after[:, plus], cosine, rtol=0, atol=1e-13), (band, m)


def test_no_condon_shortley_sign():
    """Close to the pole, a little off +x towards +y, all functions are positive: (-1)**m would show."""
    polar, azimuth = 0.05, 0.05
    direction = [np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.cos(polar)]
    assert (sh.basis(direction, 8) > 0).all()


def test_parity():
    """The opposite direction flips odd bands and no others."""
    directions = random_directions(50)
    sign = np.concatenate([np.full(2 * band + 1, (-1.0) ** band) for band in range(9)])
    assert np.allclose(sh.basis(-directions, 8), sign * sh.basis(directions, 8), rtol=0, atol=1e-14)


def test_basis_keeps_leading_axes():
    """Pictures and single directions go in as they are."""
    directions = random_directions(12).reshape(3, 4, 3)
    assert sh.basis(directions).shape == (3, 4, 9)
    assert np.array_equal(sh.basis(directions[1, 2]), sh.basis(directions)[1, 2])
    assert np.allclose(sh.basis([0, 0, 1]), order2([0, 0, 1]))  # whole numbers too


def test_cosine_lobe_anchors():
    """The published factors of Ramamoorthi & Hanrahan."""
    anchors = [np.pi, 2 * np.pi / 3, np.pi / 4, 0, -np.pi / 24, 0, np.pi / 64]
    assert np.allclose(sh.cosine_lobe(6), anchors, rtol=0, atol=1e-15)


def test_cosine_lobe_is_the_integral():
    """The formula agrees with the integral it stands for, through order 8."""
    mu, weight = np.polynomial.legendre.leggauss(16)
    mu, weight = (mu + 1) / 2, weight / 2
    integrals = [2 * np.pi * np.sum(weight * mu * np.polynomial.legendre.Legendre.basis(b)(mu)) for b in range(9)]
    assert np.allclose(sh.cosine_lobe(8), integrals, rtol=0, atol=1e-14)


def test_band2_form_is_the_function():
    """The form, which the shader turns, has the values of the harmonics it was made of."""
    coefficients = np.random.default_rng(5).normal(size=(20, 5))
    directions = random_directions(20)
    form = sh.band2_form(coefficients)
    values = np.einsum("ni,nij,nj->n", directions, form, directions)
    assert np.allclose(values, np.sum(coefficients * order2(directions)[:, 4:], axis=1), rtol=0, atol=1e-13)
    assert np.allclose(np.trace(form, axis1=1, axis2=2), 0, atol=1e-13)
    assert np.array_equal(form, form.transpose(0, 2, 1))


def test_band2_form_round_trip():
    """Nothing is lost on the way to the form and back."""
    coefficients = np.random.default_rng(6).normal(size=(4, 5, 5))
    assert np.allclose(sh.band2_coefficients(sh.band2_form(coefficients)), coefficients, rtol=0, atol=1e-14)


def test_counting():
    """Bands, orders and counts agree with each other; a count in between is refused."""
    assert [sh.coefficient_count(order) for order in range(4)] == [1, 4, 9, 16]
    assert [sh.order_of(count) for count in (1, 4, 9, 81)] == [0, 1, 2, 8]
    assert list(range(9))[sh.band_slice(2)] == [4, 5, 6, 7, 8]
    assert list(sh.per_coefficient([7, 8, 9])) == [7, 8, 8, 8, 9, 9, 9, 9, 9]
    with pytest.raises(ValueError, match="10 coefficients"):
        sh.order_of(10)
