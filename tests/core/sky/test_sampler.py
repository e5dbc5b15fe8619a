# SPDX-License-Identifier: GPL-3.0-or-later
"""The sampler looks up the picture in full resolution, and draws directions with the density that it claims."""

import numpy as np
import pytest

from prt_addon.core.errors import PictureError
from prt_addon.core.sky.projection import project_equirect
from prt_addon.core.sky.sampler import MAX_WIDTH, Skylight, reduced
from prt_addon.core.sphere import sh
from prt_addon.core.sphere.rotation import rotation_matrix
from tests.core.references import random_directions, random_rotations

[TURN] = random_rotations(1)


@pytest.fixture(scope="module")
def picture():
    """Noise, a sun ten thousand times the mean, and a black row."""
    pixels = np.random.default_rng(3).random((32, 64, 3)).astype(np.float32)
    pixels[20, 50] = (5000, 4000, 3000)
    pixels[5] = 0.0
    return pixels


def uniforms(count):
    index = np.arange(count)
    return np.stack([(index + 0.5) / count, (index * (np.sqrt(5.0) - 1.0) / 2.0) % 1.0], axis=-1)


def test_drawn_directions_integrate_the_sky(picture):
    """Radiance over density, against every harmonic up to order 6: the projection of the turned sky, sun and all."""
    sky = Skylight(picture[None], TURN)
    directions = sky.draw(uniforms(1 << 17))
    np.testing.assert_allclose(np.linalg.norm(directions, axis=1), 1.0, atol=1e-12)
    weighed = sky.radiance(directions)[:, 0] / sky.density(directions)[:, None]
    estimate = sh.basis(directions, 6).T @ weighed / len(directions)
    wanted = rotation_matrix(TURN.T, 6) @ project_equirect(picture, 6)
    assert np.abs(estimate - wanted).max() < 2e-3 * np.abs(wanted).max()


def test_density_is_a_probability(picture):
    """It integrates to one over the sphere, and nothing is drawn where the sky is black."""
    sky = Skylight(picture[None], TURN)
    directions = random_directions(1 << 18)
    rest = sky.density(directions)
    rest = rest[rest < rest.max() / 2.0]  # all but the sun, which is too small for random directions
    sun = 4000.0 * 2.0 * np.pi / 64 * np.diff(np.sin(np.pi * (np.array([20, 21]) / 32 - 0.5)))[0] / sky.flux
    assert rest.sum() * 4.0 * np.pi / len(directions) + sun == pytest.approx(1.0, abs=0.01)
    assert sky.density(sky.draw(uniforms(4096))).min() > 0.0


def test_each_picture_is_looked_up_as_it_is(picture):
    """Along w the sky shows what the picture holds along R w: Blender's equirect, written out."""
    sky = Skylight(np.stack([picture, 2.0 * picture]), TURN)
    for direction in random_directions(16, seed=9):
        x, y, z = TURN @ direction
        row = int((0.5 + np.arcsin(z) / np.pi) * 32)
        column = int((0.5 - np.arctan2(y, x) / (2.0 * np.pi)) * 64)
        found = sky.radiance(direction[None])[0]
        np.testing.assert_array_equal(found, [picture[row, column], 2.0 * picture[row, column]])


def test_black_and_broken_skies():
    """No light is no error; NaN is."""
    black = Skylight(np.zeros((1, 4, 8, 3), dtype=np.float32), np.eye(3))
    assert black.flux == 0.0 and not black.density(random_directions(8)).any()
    with pytest.raises(PictureError, match="NaN"):
        Skylight(np.full((1, 4, 8, 3), np.nan, dtype=np.float32), np.eye(3))


def test_huge_pictures_are_averaged_down():
    """The light stays what it was; a small picture is left alone."""
    huge = np.random.default_rng(1).random((8, 2 * MAX_WIDTH, 3)).astype(np.float32)
    small = reduced(huge)
    assert small.shape == (4, MAX_WIDTH, 3)
    np.testing.assert_allclose(small.mean(axis=(0, 1)), huge.mean(axis=(0, 1)), rtol=1e-5)
    assert reduced(small) is small
