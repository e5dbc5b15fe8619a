# SPDX-License-Identifier: GPL-3.0-or-later
"""The extras of a glTF scene come back as they were written."""

import json

import numpy as np

from prt_addon.core.exchange import gltf_extras
from prt_addon.core.sky.lamps import Lamp, Lamps
from tests.core.references import axis_angle


def test_what_is_written_is_read_back():
    """By way of JSON; of a scene without a light, no light."""
    rng = np.random.default_rng(4)
    suns = Lamps(
        (Lamp(np.array([0.6, 0.0, 0.8]), 3.0, 0.02), Lamp(np.array([0.0, 1.0, 0.0]), 0.5, 0.0)), (1.5, 1.0, 0.5)
    )
    given = gltf_extras.SceneLight(
        rng.normal(size=(9, 3)), rng.normal(size=(9, 3)), suns, axis_angle((1, 2, 3), 0.8), 1.5
    )
    found = gltf_extras.from_extras(json.loads(json.dumps(gltf_extras.to_extras(2, gltf_extras.Y_UP, given))), 2)
    for name in ("light", "lamps", "turn"):
        np.testing.assert_allclose(getattr(found, name), getattr(given, name), atol=1e-12)
    assert found.strength == 1.5
    np.testing.assert_allclose(found.suns.colour, suns.colour)
    for lamp, wanted in zip(found.suns.lamps, suns.lamps, strict=True):
        np.testing.assert_allclose(lamp.direction, wanted.direction)
        np.testing.assert_allclose((lamp.irradiance, lamp.radius), (wanted.irradiance, wanted.radius))
    assert gltf_extras.from_extras(gltf_extras.to_extras(2, gltf_extras.Y_UP, None), 2) is None


def test_the_first_version_is_read():
    """It had neither suns nor lamps."""
    extras = gltf_extras.to_extras(
        1, gltf_extras.Y_UP, gltf_extras.SceneLight(np.ones((9, 3)), np.zeros((9, 3)), Lamps(), np.eye(3), 1.0)
    )
    extras["version"] = 1
    del extras["suns"], extras["lamps"]
    found = gltf_extras.from_extras(extras, 2)
    assert found.suns == Lamps() and not found.lamps.any() and (found.light == 1.0).all()
