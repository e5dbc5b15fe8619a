# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of the sky are projected as integrals over the sphere, texel by texel."""

import numpy as np
import pytest

from prt_addon.core.errors import PictureError
from prt_addon.core.sky import projection as envmap
from tests.core.references import order2, random_directions


def blender_texel(direction, width, height):
    """Column and row that Blender looks up, from its own formula; row 0 is the bottom."""
    x, y, z = direction
    u, v = 0.5 - np.arctan2(y, x) / (2 * np.pi), 0.5 + np.arcsin(z) / np.pi
    return min(int(u * width), width - 1), min(int(v * height), height - 1)


def random_sky(height, width, seed=3):
    """Texels of a wide range, as in photographs."""
    return np.random.default_rng(seed).exponential(size=(height, width, 3)).astype(np.float32) ** 3


@pytest.mark.parametrize("height", [1, 2, 9, 512])
@pytest.mark.parametrize("radiance", [1.0, 7.25])
def test_constant_sky(radiance, height):
    """L_0 = c sqrt(4pi) and nothing else, at any resolution: harmonics taken at texel centres leave 3.3 c / h**2."""
    light = envmap.project_equirect(np.full((height, 2 * height + 1, 3), radiance, dtype=np.float32))
    assert np.allclose(light[0], radiance * np.sqrt(4 * np.pi), rtol=1e-13)
    assert np.allclose(light[1:], 0, atol=1e-13 * radiance)


AXES = [*np.eye(3), *-np.eye(3)]


@pytest.mark.parametrize("direction", [*AXES, *random_directions(4)])
def test_hot_texel_lands_where_blender_shows_it(direction):
    """One lamp per axis: a mirrored or turned sky cannot pass."""
    width, height = 256, 128
    pixels = np.zeros((height, width, 3), dtype=np.float32)
    column, row = blender_texel(direction, width, height)
    pixels[row, column] = (1000, 500, 250)
    light = envmap.project_equirect(pixels)
    towards = light[[3, 1, 2]].T / np.linalg.norm(light[[3, 1, 2]], axis=0)[:, None]
    assert np.allclose(towards, direction, rtol=0, atol=1.5 * np.pi / width)
    assert np.allclose(light[:, 0], 2 * light[:, 1]) and np.allclose(light[:, 0], 4 * light[:, 2])


def texel_integral(row, column, height, width):
    """The nine harmonics over one texel by Gauss-Legendre in both angles; the edges are Blender's u and v."""
    node, weight = np.polynomial.legendre.leggauss(12)
    polar = np.pi * (1 - (row + (node + 1) / 2) / height)[:, None]
    azimuth = 2 * np.pi * (0.5 - (column + (node + 1) / 2) / width)
    rows = [np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.cos(polar) + 0 * azimuth]
    areas = np.outer(weight * np.pi / (2 * height) * np.sin(polar[:, 0]), weight * np.pi / width)
    return np.einsum("pa,pai->i", areas, order2(np.stack(rows, axis=-1)))


@pytest.mark.parametrize("size", [(9, 16), (70, 5), (4, 3)])
def test_every_texel_by_hand(size):
    """The quick product per row is the plain sum over texels; of odd m it keeps an error of the third order."""
    height, width = size
    pixels = random_sky(height, width)
    light = np.zeros((9, 3))
    for row, column in np.ndindex(height, width):
        light += texel_integral(row, column, height, width)[:, None] * pixels[row, column].astype(np.float64)
    error = np.abs(envmap.project_equirect(pixels) - light).max(axis=1) / light[0].max()
    assert (error[[0, 2, 4, 6, 8]] < 1e-13).all()
    assert (error[[1, 3, 5, 7]] < 1 / height**3).all()


def test_higher_orders_extend_lower_ones():
    """The first nine do not depend on how many follow, but for the error of odd m."""
    pixels = random_sky(20, 40)
    light = envmap.project_equirect(pixels, 8)
    assert light.shape == (81, 3)
    assert np.allclose(light[:9], envmap.project_equirect(pixels), rtol=0, atol=2e-5 * light[0].max())


@pytest.mark.parametrize("rows", [1, 7, 1000])
def test_rows_at_a_time_do_not_matter(monkeypatch, rows):
    """How much memory is used must not change the light."""
    pixels = random_sky(130, 64)
    expected = envmap.project_equirect(pixels)
    monkeypatch.setattr(envmap, "_ROWS_AT_A_TIME", rows)
    assert np.allclose(envmap.project_equirect(pixels), expected, rtol=1e-12, atol=1e-12)


def test_sums_are_float64():
    """A float32 sum of two million texels drifts by percents."""
    light = envmap.project_equirect(np.full((1024, 2048, 3), 0.1, dtype=np.float32))
    assert np.allclose(light[0], np.float64(np.float32(0.1)) * np.sqrt(4 * np.pi), rtol=1e-12)


@pytest.mark.parametrize("row", [0, 99])
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_broken_texels_are_refused(bad, row):
    """One NaN would make the whole scene black: it is refused instead, wherever it lies."""
    pixels = random_sky(100, 10)
    pixels[row, 5, 1] = bad
    with pytest.raises(PictureError, match="NaN"):
        envmap.project_equirect(pixels)


def test_two_infinities_are_refused():
    """They cancel to NaN, or warn, on some ways through the sums."""
    pixels = random_sky(10, 10)
    pixels[0, 2], pixels[0, 7] = np.inf, -np.inf
    with pytest.raises(PictureError, match="infinite"):
        envmap.project_equirect(pixels)


@pytest.mark.parametrize("size", [(0, 0), (0, 4), (4, 0)])
def test_empty_picture_is_refused(size):
    """Blender reports 0 x 0 for a picture whose file is gone."""
    with pytest.raises(PictureError, match="empty"):
        envmap.project_equirect(np.zeros((*size, 3), dtype=np.float32))


def test_srgb_anchors():
    """The published curve, not a power of 2.2: both of its parts and the joint."""
    encoded = np.array([0, 0.02, 0.04045, 0.5, 1], dtype=np.float32)
    linear = envmap.srgb_to_linear(encoded)
    assert linear.dtype == np.float32
    assert np.allclose(linear, [0, 0.02 / 12.92, 0.0031308, 0.21404114, 1], rtol=1e-5, atol=0)


@pytest.mark.parametrize("size", [(3, 3), (40, 80), (600, 600)])
def test_constant_mirror_ball(size):
    """All of the sphere is on it, whatever its resolution."""
    light = envmap.project_mirror_ball(np.full((*size, 3), 2.0, dtype=np.float32))
    assert np.allclose(light[0], 2 * np.sqrt(4 * np.pi), rtol=1e-12)
    assert np.allclose(light[1:], 0, atol=5e-4 * light[0].max())


def test_corners_of_a_mirror_ball_do_not_matter():
    """They show the photographer, and may hold anything."""
    pixels = np.ones((64, 64, 3), dtype=np.float32)
    pixels[0, 0] = pixels[-1, 0] = np.nan
    assert np.isfinite(envmap.project_mirror_ball(pixels)).all()
    pixels[32, 32] = np.nan
    with pytest.raises(PictureError, match="NaN"):
        envmap.project_mirror_ball(pixels)


def test_interpolated_texels_are_tents():
    """The same light as of a picture nine times as fine that is interpolated by hand, up to the finer one's own error."""
    height, width, fine = 12, 24, 9
    pixels = random_sky(height, width).astype(np.float64)

    def along(values, axis):
        place = np.arange(values.shape[axis] * fine) / fine + 0.5 / fine - 0.5
        low, share = np.floor(place).astype(int), place - np.floor(place)
        size = values.shape[axis]
        shape = [-1 if k == axis else 1 for k in range(3)]
        first, second = (np.take(values, low + step, axis=axis, mode="wrap" if axis else "clip") for step in (0, 1))
        assert first.shape[axis] == size * fine
        return first * (1 - share.reshape(shape)) + second * share.reshape(shape)

    wanted = envmap.project_equirect(along(along(pixels, 0), 1))
    light = envmap.project_equirect(pixels, interpolated=True)
    assert np.allclose(light, wanted, rtol=0, atol=1e-3 * np.abs(wanted[0]).max())
    flat = envmap.project_equirect(pixels)
    assert np.abs(light - wanted).max() < 0.05 * np.abs(flat - wanted).max()
