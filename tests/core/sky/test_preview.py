# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of a light show it where it is, and their energy is how much of the sky is in it."""

import numpy as np
import pytest

from prt_addon.core.sky import preview
from prt_addon.core.sky import projection as envmap
from prt_addon.core.sphere import windowing
from tests.core.references import axis_angle, order2, random_directions, sphere_quadrature

LIGHT = np.random.default_rng(1).normal(size=(9, 3))


def lookup(directions, height):
    """Row and column of Blender's equirectangular lookup."""
    x, y, z = directions.T
    u, v = 0.5 - np.arctan2(y, x) / (2 * np.pi), 0.5 + np.arcsin(z) / np.pi
    return (v * height).astype(int), (u * 2 * height).astype(int) % (2 * height)


def test_light_picture_is_the_light():
    """Along random directions, and as a whole: projecting the picture gives the light back."""
    picture, directions = preview.light_picture(LIGHT, 256), random_directions(50)
    assert picture.shape == (256, 512, 3) and picture.dtype == np.float32
    assert np.allclose(picture[lookup(directions, 256)], order2(directions) @ LIGHT, rtol=0, atol=0.05)
    assert np.allclose(envmap.project_equirect(picture), LIGHT, rtol=0, atol=1e-4)


@pytest.mark.parametrize("size", [(16, 32), (64, 128), (200, 400), (64, 301)])
def test_turned_picture_looks_along_the_turned_direction(size):
    """Pictures coarser and finer than the result, and of odd sizes: what is seen along w is what was along R w."""
    elevation = np.pi * ((np.arange(size[0]) + 0.5) / size[0] - 0.5)[:, None]
    azimuth = 2 * np.pi * (0.5 - (np.arange(size[1]) + 0.5) / size[1])
    parts = np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)
    picture = (order2(np.stack(np.broadcast_arrays(*parts), axis=-1)) @ LIGHT).astype(np.float32)
    turn, directions = axis_angle((1, -2, 0.5), 1.1), random_directions(50)
    turned = preview.turned_picture(picture, turn, 64)
    assert turned.shape == (64, 128, 3)
    wanted = order2(directions @ turn.T) @ LIGHT
    assert np.abs(turned[lookup(directions, 64)] - wanted).max() < 2 * np.pi / min(64, size[0]) * np.abs(wanted).max()
    wrong = order2(directions @ turn) @ LIGHT
    assert np.abs(turned[lookup(directions, 64)] - wrong).max() > 0.5


def test_unturned_picture_keeps_its_suns():
    """Averaged, not skipped: the light of a picture eight times as fine is the same."""
    picture = np.random.default_rng(2).exponential(size=(512, 1024, 3)).astype(np.float32) ** 4
    picture[300, 777] = 1e5
    light = envmap.project_equirect(picture)
    shown = envmap.project_equirect(preview.turned_picture(picture, np.eye(3), 64))
    assert np.abs(shown - light).max() < 0.01 * light.max()


def test_energy_is_the_integral_of_the_square():
    """Parseval: of a picture that a light describes, every band's share adds up to all of it."""
    directions, weights = sphere_quadrature(6)
    whole = np.sum(weights[:, None] * (order2(directions) @ LIGHT) ** 2)
    total = preview.energy(preview.light_picture(LIGHT, 128))
    assert np.isclose(total, whole, rtol=1e-3)
    assert np.isclose(windowing.energy_shares(LIGHT, total).sum(), 1, rtol=1e-3)


def test_display():
    """The brightest is white, what is below zero black, half of the light encoded; black stays black."""
    shown = preview.display(np.array([[[4.0, 2.0, -1.0]]], dtype=np.float32))
    assert np.allclose(shown, [[[1, 0.7353569, 0, 1]]], rtol=1e-5) and shown.dtype == np.float32
    assert np.array_equal(preview.display(np.zeros((1, 1, 3), dtype=np.float32)), [[[0, 0, 0, 1]]])
