# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps are found where a painted sky has them, as large and as bright, and nowhere else."""

import numpy as np
import pytest

from prt_addon.core.sky.find_lamps import ENOUGH, extract_lamps, find_lamps
from prt_addon.core.sky.projection import project_equirect
from prt_addon.core.sphere.equirect import solid_angles, texel_directions

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
    found = find_lamps(sky((towards, 4.0, colour)), 8)
    [sun] = found.lamps
    assert angle(sun.direction, towards) < 0.2
    assert abs(np.degrees(sun.radius) - 4.0) < 0.2
    assert abs(sun.irradiance / irradiance(4.0, colour) - 1.0) < 0.05  # what lies under the threshold stays in the sky
    np.testing.assert_allclose(found.colour, colour / colour.mean(), rtol=1e-2)


def test_lamps_are_not_averaged():
    """Three lamps, two to be found: the brighter two, each where it is."""
    places = [(1.0, 0.0, 0.2), (-1.0, 0.3, 0.4), (0.0, 1.0, 0.1)]
    found = find_lamps(sky(*((place, 3.0, power) for place, power in zip(places, (90, 60, 30), strict=True))), 2)
    assert [angle(lamp.direction, place) < 0.3 for lamp, place in zip(found.lamps, places[:2], strict=True)] == [
        True,
        True,
    ]


def test_light_of_a_lamp_is_that_of_its_disc():
    """In bands: what a painted disc projects to."""
    disc = sky(((0.2, 0.4, 0.6), 9.0, 100.0), dim=0.0)
    found = find_lamps(disc, 1)
    truth = project_equirect(disc, 4)[:, 0]
    ours = found.light(4)
    whole = found.share
    np.testing.assert_allclose(ours, whole * truth, atol=4e-3 * np.abs(truth).max())


def test_a_sun_stays_sharp_in_its_glow():
    """The glow is a lamp of its own; so is a window, which is found in a sky without a sun, too."""
    sun, glow, window = ((0.6, 0.0, 0.8), 1.0, 900.0), ((0.6, 0.0, 0.8), 15.0, 2.0), ((-0.6, 0.64, 0.48), 17.0, 3.0)
    found = find_lamps(sky(sun, glow, window), 4, ENOUGH).lamps
    assert [round(float(np.degrees(lamp.radius))) for lamp in found] == [1, 17, 15]
    assert [angle(lamp.direction, disc[0]) < 1.0 for lamp, disc in zip(found, (sun, window, glow), strict=True)] == [
        True
    ] * 3
    [alone] = find_lamps(sky(window), 4, ENOUGH).lamps
    assert angle(alone.direction, window[0]) < 0.5 and abs(np.degrees(alone.radius) - 17.0) < 0.5
    assert abs(alone.irradiance / irradiance(17.0, 3.0) - 1.0) < 0.35  # what lies under the threshold stays in the sky


def test_the_radiance_of_a_lamp_is_that_of_its_texels():
    """Not that of the disc, where its light comes from small hearts."""
    hearts = [((1.0, 0.1 * y, 0.1 * z), 1.0, 800.0) for y in (-1, 1) for z in (-1, 1)]
    [lamp] = find_lamps(sky(*hearts), 1).lamps
    assert abs(lamp.radiance / 800.2 - 1.0) < 1e-3 and lamp.irradiance / (np.pi * lamp.radius**2) < 100.0


@pytest.mark.parametrize("most", [0, 1, 4])
def test_a_soft_sky_has_none(most):
    """Bright above, dark below: four times the mean, but nine coefficients lose nothing of it."""
    picture = np.repeat(np.exp(2.0 * DIRECTIONS[..., 2:]), 3, axis=-1).astype(np.float32)
    assert find_lamps(picture, most).lamps == ()


def test_no_more_lamps_than_are_needed():
    """One sun is enough where it is all there is; a second as bright one is needed, too."""
    one = ((0.3, -0.8, 0.5), 2.0, 500.0)
    other = ((-0.3, 0.8, 0.5), 2.0, 500.0)
    dust = [((np.cos(k), np.sin(k), -0.5), 1.0, 5.0) for k in range(6)]
    assert len(find_lamps(sky(one, *dust), 4, ENOUGH).lamps) == 1
    assert len(find_lamps(sky(one, other, *dust), 4, ENOUGH).lamps) == 2


def test_same_sky_same_lamps():
    """Bit for bit; and a larger picture has the same."""
    picture = sky(((0.3, -0.8, 0.5), 4.0, 200.0), ((-1.0, 0.3, 0.4), 2.0, 300.0))
    first, second = (find_lamps(picture, 4) for _ in range(2))
    larger = find_lamps(np.repeat(np.repeat(picture, 4, axis=0), 4, axis=1), 4)
    np.testing.assert_array_equal(first.light(), second.light())
    np.testing.assert_allclose(larger.light(), first.light(), atol=2e-3 * first.light().max())


def light_of(picture):
    """(3,) all that a picture sends."""
    return np.einsum("h,hwc->c", solid_angles(*picture.shape[:2]), picture.astype(np.float64))


SPOTS = {
    "sun in its glow, and a window": (
        ((0.6, 0.0, 0.8), 1.0, np.array((900.0, 700.0, 400.0))),
        ((0.6, 0.0, 0.8), 15.0, np.array((2.0, 1.5, 1.0))),
        ((-0.6, 0.64, 0.48), 17.0, np.array((2.0, 3.0, 4.0))),
    ),
    "two suns": (((1.0, 0.0, 0.2), 3.0, 90.0), ((1.0, 0.3, 0.2), 3.0, 60.0)),
    "one sun of many": tuple(((np.cos(k), np.sin(k), 0.2), 3.0, 90.0 + k) for k in range(6)),
}


@pytest.mark.parametrize("rule", [(4, ENOUGH), (1, 0.0), (8, 0.0)], ids=["automatic", "one", "up to 8"])
@pytest.mark.parametrize("spots", SPOTS.values(), ids=SPOTS)
def test_what_lamps_take_is_missing_in_the_rest(spots, rule):
    """As exactly as floats are, in each channel; what is left of a spot has its colour, and nothing else is touched."""
    picture = sky(*spots)
    picture[0, :3] = -1.0
    given = picture.copy()
    lamps, rest = extract_lamps(picture, *rule)
    np.testing.assert_array_equal(picture, given)
    assert [lamp.irradiance for lamp in lamps.lamps] == [lamp.irradiance for lamp in find_lamps(picture, *rule).lamps]
    taken = sum(lamp.irradiance for lamp in lamps.lamps) * np.array(lamps.colour)
    np.testing.assert_allclose(light_of(rest) + taken, light_of(picture), rtol=1e-6)
    assert (rest <= picture).all() and ((rest >= 0.0) | (rest == picture)).all()
    touched = (rest < picture).any(axis=-1)
    middles = np.array([lamp.direction for lamp in lamps.lamps])
    assert touched.any() and ((DIRECTIONS[touched] @ middles.T).max(axis=-1) > np.cos(np.radians(20.0))).all()
    np.testing.assert_allclose(
        rest[touched] * picture[touched][:, :1], picture[touched] * rest[touched][:, :1], rtol=1e-5
    )


def test_the_rest_is_as_bright_as_spots_of_its_kind_begin():
    """Ten times the mean within a sun's reach, three times in a wide lamp's, which takes the sun's rest as well."""
    sun, window = ((0.6, 0.0, 0.8), 1.0, 5000.0), ((-0.6, 0.64, 0.48), 17.0, 8.0)
    for spots, times in (((sun,), 10.0), ((window,), 3.0), ((sun, ((0.6, 0.0, 0.8), 15.0, 8.0)), 3.0)):
        picture = sky(*spots)
        mean = light_of(picture).mean() / (4.0 * np.pi)
        lamps, rest = extract_lamps(picture, 4, ENOUGH)
        assert len(lamps.lamps) == len(spots) and abs(rest.max() / mean / times - 1.0) < 1e-5


def test_without_lamps_the_rest_is_the_picture_itself():
    picture = sky(((0.3, -0.8, 0.5), 4.0, 200.0))
    assert extract_lamps(picture, 0)[1] is picture
    soft = np.repeat(np.exp(2.0 * DIRECTIONS[..., 2:]), 3, axis=-1).astype(np.float32)
    lamps, rest = extract_lamps(soft, 4)
    assert lamps.lamps == () and rest is soft


def test_what_lamps_take_of_a_large_picture():
    """Lamps are made of cells there: at the edge of a reach a texel may be on either side."""
    fine = texel_directions(1024)
    picture = (0.2 + 40.0 * np.exp(40.0 * (fine[..., :1] - 1.0)) * np.array((1.0, 0.8, 0.5))).astype(np.float32)
    lamps, rest = extract_lamps(picture, 4, ENOUGH)
    taken = sum(lamp.irradiance for lamp in lamps.lamps) * np.array(lamps.colour)
    assert lamps.lamps and (rest <= picture).all() and (rest >= 0.0).all()
    np.testing.assert_allclose(light_of(rest) + taken, light_of(picture), rtol=1e-3)
