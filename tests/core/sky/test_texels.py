# SPDX-License-Identifier: GPL-3.0-or-later
"""The texels of a sky lie where the picture has them, and all but those that are no numbers are projected."""

import numpy as np
import pytest

from prt_addon.core.sky.texels import SkyTexels


def constant(height, width, radiance=2.0):
    return np.full((height, width, 3), radiance, dtype=np.float32)


@pytest.mark.parametrize("layout", ["EQUIRECTANGULAR", "MIRROR_BALL"])
@pytest.mark.parametrize("interpolated", [False, True])
def test_constant_sky(layout, interpolated):
    """`L_0 = 2 sqrt(4 pi)` and nothing else, wherever texels lie."""
    light = SkyTexels.of(constant(32, 64), layout, interpolated).project()
    np.testing.assert_allclose(light[0], 2.0 * np.sqrt(4.0 * np.pi), rtol=1e-5)
    np.testing.assert_allclose(light[1:], 0.0, atol=5e-3)


def test_what_is_not_finite_is_left_out():
    """Counted by texel, and black: the light falls by the solid angle of what is gone."""
    pixels = constant(2, 4)  # eight texels of pi / 2 steradians
    pixels[0, 1] = np.nan
    pixels[1, 2, 0] = np.inf
    texels = SkyTexels.of(pixels)
    assert texels.left_out == 2 and texels.count == 8
    np.testing.assert_allclose(texels.project()[0], 2.0 * np.sqrt(4.0 * np.pi) * 6 / 8)


def test_which_pictures_are_stretched():
    """Panoramas that are not twice as wide as high, but for a texel; a mirror ball has no such proportions."""
    widths = {64: False, 63: False, 65: False, 62: True, 128: True}
    assert {width: SkyTexels.of(constant(32, width)).is_stretched for width in widths} == widths
    assert not SkyTexels.of(constant(32, 32), "MIRROR_BALL").is_stretched
