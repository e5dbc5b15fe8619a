# SPDX-License-Identifier: GPL-3.0-or-later
"""Radiance pictures hold their texels and the mean of them. Tests in tests/scene/export let Blender read them."""

import numpy as np
import pytest

from prt_addon.core.exchange.radiance import resized, rgbe


@pytest.mark.parametrize("value", [0.0, -1.0, 1e-38, 0.9999999, 1.0, 255.4 / 256, 255.6 / 256, 65504.0, 1e30])
def test_no_channel_overflows(value):
    """Near powers of two rounding would reach 256."""
    texel = rgbe(np.array([value, value / 2, 0.0], dtype=np.float32))
    shown = texel[:3] * 2.0 ** (int(texel[3]) - 136) if texel[3] else np.zeros(3)
    assert shown[0] == pytest.approx(max(value, 0.0), rel=1 / 256, abs=1e-30)


def test_means_keep_the_sum():
    """By whole numbers, by others, and of pictures of other proportions; smaller pictures are left as they are."""
    picture = np.random.default_rng(3).gamma(0.3, size=(30, 60, 3)).astype(np.float32)
    np.testing.assert_allclose(resized(picture, 15), picture.reshape(15, 2, 30, 2, 3).mean(axis=(1, 3)), rtol=1e-5)
    for height in (7, 15, 29):
        small = resized(picture, height)
        assert small.shape == (height, 2 * height, 3)
        np.testing.assert_allclose(small.mean(axis=(0, 1)), picture.mean(axis=(0, 1)), rtol=1e-5)
    assert resized(picture, 64) is picture
    assert resized(picture[:, :40], 64).shape == (30, 60, 3)
