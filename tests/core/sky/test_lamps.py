# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps are found where a painted sky has them, as large and as bright, and nowhere else."""

import numpy as np
import pytest

from prt_addon.core.sky import lamps
from prt_addon.core.sky.projection import project_equirect
from prt_addon.core.sphere.directions import fibonacci_sphere
from prt_addon.core.sphere.equirect import texel_directions
from prt_addon.core.sphere.rotation import rotation_matrix
from prt_addon.core.sphere.sh import basis

HEIGHT = 256
DIRECTIONS = texel_directions(HEIGHT)


def sky(*discs, dim=0.2):
    """A dim sky with painted discs: direction, radius in degrees, radiance."""
    picture = np.full((HEIGHT, 2 * HEIGHT, 3), dim, dtype=np.float32)
    for towards, radius, radiance in discs:
        towards = np.array(towards) / np.linalg.norm(towards)
        picture[DIRECTIONS @ towards > np.cos(np.radians(radius))] += np.float32(radiance)
    return picture


def angle(a, b):
    """In degrees."""
    return np.degrees(np.arccos(np.clip(np.dot(a, b) / np.linalg.norm(a) / np.linalg.norm(b), -1.0, 1.0)))


def irradiance(radius, radiance):
    """Of a disc, on a surface that faces it, to first order in its solid angle."""
    return 2.0 * np.pi * (1.0 - np.cos(np.radians(radius))) * np.mean(radiance)


def test_a_sun_is_found():
    towards, colour = (0.3, -0.8, 0.5), np.array((200.0, 150.0, 100.0))
    found = lamps.find_lamps(sky((towards, 4.0, colour)), 8)
    [sun] = found.lamps
    assert angle(sun.direction, towards) < 0.2
    assert abs(np.degrees(sun.radius) - 4.0) < 0.2
    assert abs(sun.irradiance / irradiance(4.0, colour) - 1.0) < 0.05  # what lies under the threshold stays in the sky
    np.testing.assert_allclose(found.colour, colour / colour.mean(), rtol=1e-2)


def test_lamps_are_not_averaged():
    """Three lamps, two to be found: the brighter two, each where it is."""
    places = [(1.0, 0.0, 0.2), (-1.0, 0.3, 0.4), (0.0, 1.0, 0.1)]
    found = lamps.find_lamps(sky(*((place, 3.0, power) for place, power in zip(places, (90, 60, 30), strict=True))), 2)
    assert [angle(lamp.direction, place) < 0.3 for lamp, place in zip(found.lamps, places[:2], strict=True)] == [
        True,
        True,
    ]


def test_light_of_a_lamp_is_that_of_its_disc():
    """In bands: what a painted disc projects to."""
    disc = sky(((0.2, 0.4, 0.6), 9.0, 100.0), dim=0.0)
    found = lamps.find_lamps(disc, 1)
    truth = project_equirect(disc, 4)[:, 0]
    ours = found.light(4)
    whole = found.share
    np.testing.assert_allclose(ours, whole * truth, atol=4e-3 * np.abs(truth).max())


@pytest.mark.parametrize("most", [0, 1, 4])
def test_a_soft_sky_has_none(most):
    """Bright above, dark below: nothing ten times the mean."""
    picture = np.repeat(np.exp(2.0 * DIRECTIONS[..., 2:]), 3, axis=-1).astype(np.float32)
    assert lamps.find_lamps(picture, most).lamps == ()


def test_no_more_lamps_than_are_needed():
    """One sun is enough where it is all there is; a second as bright one is needed, too."""
    one = ((0.3, -0.8, 0.5), 2.0, 500.0)
    other = ((-0.3, 0.8, 0.5), 2.0, 500.0)
    dust = [((np.cos(k), np.sin(k), -0.5), 1.0, 5.0) for k in range(6)]
    assert len(lamps.find_lamps(sky(one, *dust), 4, lamps.ENOUGH).lamps) == 1
    assert len(lamps.find_lamps(sky(one, other, *dust), 4, lamps.ENOUGH).lamps) == 2


def test_same_sky_same_lamps():
    """Bit for bit; and a larger picture has the same."""
    picture = sky(((0.3, -0.8, 0.5), 4.0, 200.0), ((-1.0, 0.3, 0.4), 2.0, 300.0))
    first, second = (lamps.find_lamps(picture, 4) for _ in range(2))
    larger = lamps.find_lamps(np.repeat(np.repeat(picture, 4, axis=0), 4, axis=1), 4)
    np.testing.assert_array_equal(first.light(), second.light())
    np.testing.assert_allclose(larger.light(), first.light(), atol=2e-3 * first.light().max())


def test_truncation_is_that_at_the_foot_of_a_wall():
    """Against a sum over turns of the sky, without the sum over bands."""
    directions = fibonacci_sphere(20000)
    harmonics = basis(directions, 8)
    seen = np.where(directions[:, 0] > 0.0, np.maximum(directions[:, 2], 0.0), 0.0) / np.pi
    transport = 4.0 * np.pi * (seen @ harmonics) / len(directions)
    light = np.random.default_rng(1).normal(size=(81, 1))
    turns = fibonacci_sphere(300)
    shown = []
    for turn in turns:
        x = np.cross(turn, (0.3, 0.5, 0.8))
        for sign in (1.0, -1.0):
            axes = np.stack([sign * x / np.linalg.norm(x), np.cross(turn, sign * x / np.linalg.norm(x)), turn])
            turned = rotation_matrix(axes, 8) @ light[:, 0]
            shown.append([(transport * turned)[9:].sum(), (transport * turned).sum()])
    lost, whole = np.sqrt((np.array(shown) ** 2).mean(axis=0))
    assert abs(lamps.truncation(light) / (lost / whole) - 1.0) < 0.25  # 600 turns of all
