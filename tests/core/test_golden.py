# SPDX-License-Identifier: GPL-3.0-or-later
"""The golden numbers, which the web's code must give, too, are what the formulas say and what the engine gives."""

import json

import numpy as np
import pytest

from prt_addon.core import layout, shown
from prt_addon.core.sky.projection import project_equirect
from prt_addon.core.sphere import sh
from prt_addon.core.sphere.rotation import rotation_matrix
from tests.golden import make


def golden(name):
    """The committed numbers."""
    return {
        key: value if isinstance(value, str) else np.array(value)
        for key, value in json.loads((make.HERE / f"{name}.json").read_text()).items()
    }


@pytest.mark.parametrize("name", make.GOLDEN)
def test_committed_numbers_are_what_the_formulas_say(name):
    committed, made = golden(name), make.plain(make.GOLDEN[name]())
    assert committed.keys() == made.keys()
    for key, value in made.items():
        if isinstance(value, str):
            assert committed[key] == value
        else:
            np.testing.assert_allclose(committed[key], value, rtol=1e-9, atol=1e-11)


def test_the_sphere():
    found = golden("sphere")
    np.testing.assert_allclose(sh.basis(found["directions"]), found["basis"], atol=1e-13)
    for turn, wanted in zip(found["rotations"], found["turned"], strict=True):
        np.testing.assert_allclose(rotation_matrix(turn.T) @ found["light"], wanted, atol=1e-12)
    lobes = sh.per_coefficient(sh.cosine_lobe()) / np.pi
    np.testing.assert_allclose((sh.basis(found["normals"]) * lobes) @ found["light"], found["unshadowed"], atol=1e-12)


def test_what_is_shown():
    found = golden("shading")
    negative = np.einsum("nic,ic->nc", found["transport"], found["light"]).min(axis=1) < 0.0
    assert 0 < negative.sum() < len(negative)
    np.testing.assert_allclose(shown.shown(found["transport"], found["light"]), found["shown"], atol=1e-12)
    np.testing.assert_allclose(shown.linear_to_srgb(np.clip(found["linear"], 0.0, 1.0)), found["srgb"], atol=1e-12)


def test_the_sky():
    found = golden("sky")
    upright = found["picture"][::-1]  # Blender's pictures begin at the bottom
    np.testing.assert_allclose(project_equirect(upright, interpolated=True), found["light"], atol=1e-10)


def test_the_lamps_of_a_sky():
    """As many as are wanted, the brightest first, with all of their light in its coefficients."""
    found = golden("lamps")
    assert len(found["irradiances"]) == found["most"] == 4 and found["irradiances"].max() == found["irradiances"][0]
    np.testing.assert_allclose(np.linalg.norm(found["directions"], axis=1), 1.0)
    np.testing.assert_allclose(
        found["light"][0], found["irradiances"].sum() * found["colour"] * sh.basis(np.eye(3))[0, 0]
    )
    assert sorted(found["counts"]) == [0, 1, 2, 3, 4]  # of *Automatic*: every number that it may choose


def test_the_layers_that_the_web_knows():
    """Names and marks in `web/packages/core/src/layout.ts`."""
    text = (make.HERE.parents[1] / "web" / "packages" / "core" / "src" / "layout.ts").read_text()
    assert f"COEFFICIENTS = {len(layout.LAYERS)};" in text and "`_PRT_${i}`" in text
    assert layout.LAYERS[3] == "_PRT_3"
    assert f"BAKED_BELOW = {layout.BAKED_BELOW};" in text and f"OWN_AXES_BELOW = {layout.OWN_AXES_BELOW};" in text
