# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of skies of which only the light is known have that light."""

import numpy as np

from prt_addon.core.sky.find_lamps import find_lamps
from prt_addon.core.sky.from_light import sky_of
from prt_addon.core.sky.lamps import Lamp, Lamps
from prt_addon.core.sky.projection import project_equirect


def test_its_light_is_the_given_one():
    """Though nine coefficients of a bright sun are negative opposite to it, and a picture is not; the suns are found again in it."""
    lamps = Lamps(
        (Lamp(np.array([0.6, 0.0, 0.8]), 4.0, np.radians(2.0)), Lamp(np.array([-0.8, 0.6, 0.0]), 1.0, np.radians(0.1)))
    )
    rest = np.zeros((9, 3))
    rest[0], rest[2] = (1.0, 1.2, 1.5), 0.3
    light = rest + np.multiply.outer(lamps.light(), lamps.colour)
    picture = sky_of(light, lamps, 128)
    assert picture.min() >= 0.0 and picture.shape == (128, 256, 3)
    np.testing.assert_allclose(project_equirect(picture, interpolated=True), light, atol=1e-5)
    found = sorted(find_lamps(picture, 2).lamps, key=lambda lamp: -lamp.irradiance)
    for lamp, wanted in zip(found, lamps.lamps, strict=True):
        assert lamp.direction @ wanted.direction > np.cos(np.radians(1.5))
        assert abs(lamp.irradiance / wanted.irradiance - 1.0) < 0.1
