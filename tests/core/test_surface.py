# SPDX-License-Identifier: GPL-3.0-or-later
"""Albedo is looked up in the picture where a ray lands."""

import numpy as np
import pytest

from prt_addon.core.surface import Albedo, CornerColours, TexturePatch

UNIT_UV = np.array([[[0, 0], [1, 0], [0, 1]]], dtype=np.float32)  # barycentrics (u, v) are the picture's own
RAMP = np.stack(np.broadcast_arrays(np.arange(4)[None, :] / 4, np.arange(2)[:, None] / 2, 0.25), -1).astype(np.float32)


def lookup(image, x, y, **options):
    """Colours of a picture at coordinates, through one triangle whose UVs reach far beyond the unit square."""
    far = np.float32(8.0)
    uv = (UNIT_UV - np.float32(0.5)) * far
    patch = TexturePatch(np.array([0]), uv, image, **options)
    u, v = ((np.atleast_1d(np.float32(c)) + far / 2) / far for c in (x, y))
    return Albedo(np.zeros((1, 3)), (patch,)).at(np.zeros(len(u), dtype=int), u, v)


def test_constant_colours_are_clipped():
    albedo = Albedo(np.array([[0.1, 0.2, 0.3], [2.0, -1.0, np.nan]]))
    zero = np.zeros(3, dtype=np.float32)
    expected = np.array([[1, 0, 0], [0.1, 0.2, 0.3], [1, 0, 0]], dtype=np.float32)
    np.testing.assert_array_equal(albedo.at(np.array([1, 0, 1]), zero, zero), expected)
    assert not albedo.is_grey
    assert Albedo(np.full((5, 3), 0.4)).is_grey


def test_corner_colours_are_linear_between_corners():
    corners = np.eye(3, dtype=np.float32)[None]
    albedo = Albedo(np.zeros((3, 3)), (CornerColours(np.array([1]), corners),))
    u, v = np.array([0.0, 1.0, 0.0, 0.25], dtype=np.float32), np.array([0.0, 0.0, 1.0, 0.5], dtype=np.float32)
    colour = albedo.at(np.ones(4, dtype=int), u, v)
    np.testing.assert_allclose(colour, np.stack([1 - u - v, u, v], axis=1), atol=1e-7)
    assert not albedo.at(np.zeros(4, dtype=int), u, v).any()
    assert albedo.is_patterned.tolist() == [False, True, False]


@pytest.mark.parametrize("interpolation", ["Linear", "Closest"])
def test_texel_centres_show_their_texel(interpolation):
    rows, columns = (index.ravel() for index in np.indices(RAMP.shape[:2]))
    colour = lookup(RAMP, (columns + 0.5) / 4, (rows + 0.5) / 2, interpolation=interpolation)
    np.testing.assert_allclose(colour, RAMP[rows, columns], atol=1e-5)


def test_bilinear_is_halfway_between_texels():
    np.testing.assert_allclose(lookup(RAMP, 0.5, 0.5)[0], RAMP[:, 1:3].mean(axis=(0, 1)), atol=1e-5)


@pytest.mark.parametrize(
    ("extension", "columns"),
    [
        ("REPEAT", [3, 0, 3, 0, 1]),
        ("EXTEND", [0, 0, 3, 3, 3]),
        ("MIRROR", [0, 0, 3, 3, 2]),
        ("CLIP", [None, 0, 3, None, None]),
    ],
)
@pytest.mark.parametrize("interpolation", ["Linear", "Closest"])
def test_beyond_the_picture(extension, columns, interpolation):
    x = np.array([-0.125, 0.125, 0.875, 1.125, 1.375])
    colour = lookup(RAMP, x, np.full(5, 0.25), interpolation=interpolation, extension=extension)
    expected = [np.zeros(3) if column is None else RAMP[0, column] for column in columns]
    np.testing.assert_allclose(colour, expected, atol=1e-5)


def test_repeat_blends_across_the_seam():
    np.testing.assert_allclose(lookup(RAMP, 1.0, 0.25)[0], (RAMP[0, 3] + RAMP[0, 0]) / 2, atol=1e-5)


def test_the_later_pattern_shows():
    below = CornerColours(np.array([0, 1]), np.full((2, 3, 3), 0.25, dtype=np.float32))
    above = TexturePatch(np.array([1]), UNIT_UV, np.full((1, 1, 3), 0.75, dtype=np.float32))
    albedo = Albedo(np.zeros((2, 3)), (below, above))
    zero = np.zeros(2, dtype=np.float32)
    np.testing.assert_allclose(albedo.at(np.array([0, 1]), zero, zero)[:, 0], [0.25, 0.75])
    assert albedo.is_grey
