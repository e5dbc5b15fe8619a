# SPDX-License-Identifier: GPL-3.0-or-later
"""Projects pictures of the sky onto spherical harmonics."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ..arrays import Float64
from ..errors import PictureError
from ..sphere import sh

_ROWS_AT_A_TIME = 64  # float64 copies stay small whatever the picture's size
_BALL_SAMPLES = 512  # across a mirror ball at least: texels are cut for the share of the rim's that lies on the ball


def _azimuths(width: int) -> Float64:
    return 2.0 * np.pi * (0.5 - (np.arange(width) + 0.5) / width)


def _elevations(height: int) -> Float64:
    return np.pi * ((np.arange(height) + 0.5) / height - 0.5)


def project_equirect(
    pixels: npt.NDArray[np.float32] | Float64, order: int = sh.ORDER, interpolated: bool = False
) -> Float64:
    """Project an equirectangular picture, every texel, onto spherical harmonics.

    A row shares its polar functions, so the azimuth is one matrix product per row and the cost per texel is
    `2 * order + 1` multiply-adds per channel. Sums are float64: in float32 they drift by percents on large pictures.

    Args:
        pixels: (height, width, 3) linear radiance, row 0 at the bottom (Blender's order).
        order: highest band.
        interpolated: whether radiance goes linearly from the centre of a texel to the next, as renderers show pictures; of
            a texel in height rows that changes its share of band l by about `l (l + 1) / height**2`, and its share of
            the sky by 8 % in the rows at the poles. Without it, texels are flat.

    Returns:
        ((order + 1)**2, 3) float64, `L_i = integral L(w) Y_i(w) dw`.

    Raises:
        PictureError: if the picture is empty or holds NaN or infinite texels.
    """
    height, width = pixels.shape[:2]
    if not height or not width:
        raise PictureError("The sky picture is empty: load one that has pixels.")
    azimuthal = _azimuthal_integrals(width, order, interpolated)
    polar = _polar_integrals(height, order, interpolated)
    light = np.zeros((sh.coefficient_count(order), 3))
    for first in range(0, height, _ROWS_AT_A_TIME):
        rows = slice(first, first + _ROWS_AT_A_TIME)
        texels = _finite(pixels[rows])
        moments = np.einsum("mw,hwc->mhc", azimuthal, texels, optimize=True)
        for (band, m), weight in polar.items():
            centre = band * (band + 1)
            light[centre + m] += weight[rows] @ moments[m]
            if m:
                light[centre - m] += weight[rows] @ moments[order + m]
    return light


def without_broken(pixels: npt.NDArray[np.float32]) -> tuple[npt.NDArray[np.float32], int]:
    """Leave texels out that are not finite: they become black.

    Args:
        pixels: (height, width, 3), changed in place where it can be.

    Returns:
        The picture, and how many texels were left out.
    """
    count = 0
    for first in range(0, len(pixels), _ROWS_AT_A_TIME):
        rows = pixels[first : first + _ROWS_AT_A_TIME]
        broken = ~np.isfinite(rows).all(axis=2)
        if broken.any():
            if not pixels.flags.writeable:
                pixels = pixels.copy()
                rows = pixels[first : first + _ROWS_AT_A_TIME]
            rows[broken] = 0.0
            count += int(broken.sum())
    return pixels, count


def project_mirror_ball(pixels: npt.NDArray[np.float32] | Float64, order: int = sh.ORDER) -> Float64:
    """Project a photograph of a mirror ball, every texel that shows the ball, onto spherical harmonics.

    The ball fills the picture and is seen along +y from afar, as Blender's Environment Texture has it: the normal at
    (x, z) of the unit disc is n = (x, -sqrt(1 - x^2 - z^2), z), and the direction seen there the view mirrored in it. As
    its solid angle is `|4 n.y| dn` and `dn = dx dz / |n.y|`, all texels weigh the same: 4 dx dz, 4 pi in all.

    Args:
        pixels: (height, width, 3) linear radiance, row 0 at the bottom.
        order: highest band.

    Returns:
        ((order + 1)**2, 3) float64. A constant ball is right to 5e-4 at any size.

    Raises:
        PictureError: if the picture is empty or holds NaN or infinite texels on the ball.
    """
    height, width = pixels.shape[:2]
    if not height or not width:
        raise PictureError("The sky picture is empty: load one that has pixels.")
    light, weight = np.zeros((sh.coefficient_count(order), 3)), 0.0
    for row in range(height):
        harmonics, share = _ball_row(row, height, width, order)
        shown = share > 0.0
        light += harmonics[shown].T @ _finite(pixels[row, shown])
        weight += share.sum()
    return light * (4.0 * np.pi / weight)  # the sampled disc's area, made exact


def _ball_row(row: int, height: int, width: int, order: int) -> tuple[Float64, Float64]:
    """Of each texel of a row: harmonics, averaged over its part of the ball and scaled by that; and this share."""
    cuts = -(-_BALL_SAMPLES // min(height, width))
    inside = (np.arange(cuts) + 0.5) / cuts
    x = 2.0 * (np.arange(width)[:, None] + inside) / width - 1.0
    z = 2.0 * (row + inside) / height - 1.0
    x, z = np.broadcast_arrays(x[:, None, :], z[None, :, None])
    depth2 = 1.0 - x**2 - z**2
    on_ball = depth2 > 0.0
    forward = 2.0 * np.sqrt(np.maximum(depth2, 0.0))
    seen = np.stack([x * forward, 1.0 - 2.0 * depth2, z * forward], axis=-1)
    harmonics = np.where(on_ball[..., None], sh.basis(np.where(on_ball[..., None], seen, (0.0, 1.0, 0.0)), order), 0.0)
    return harmonics.mean(axis=(1, 2)), on_ball.mean(axis=(1, 2))


def _finite(texels: npt.NDArray[np.float32] | Float64) -> Float64:
    """Texels as float64."""
    if not np.isfinite(texels).all():
        raise PictureError("The sky holds NaN or infinite texels: repair the picture, or the nodes that make them.")
    return texels.astype(np.float64)


def _azimuthal_integrals(width: int, order: int, interpolated: bool) -> Float64:
    """(2 order + 1, width): cos(m phi), then sin(m phi), integrated over each column: a box, or a tent twice as wide."""
    azimuth, step = _azimuths(width), 2.0 * np.pi / width
    power = 2 if interpolated else 1  # a tent is a box, blurred by a box
    cosines = [np.cos(m * azimuth) * step * np.sinc(m / width) ** power for m in range(order + 1)]
    sines = [np.sin(m * azimuth) * step * np.sinc(m / width) ** power for m in range(1, order + 1)]
    return np.stack(cosines + sines)


def _polar_integrals(height: int, order: int, interpolated: bool) -> dict[tuple[int, int], Float64]:
    """For each (l, m), the polar part of Y_lm integrated over the solid angle of each row: (height,).

    Integrated, not sampled at the texel's centre: a constant sky is then exact at any resolution. By Gauss-Legendre
    quadrature in the elevation on either side of the centre, where the integrand is smooth up to the poles.
    """
    nodes, weights = np.polynomial.legendre.leggauss(12)  # type: ignore[no-untyped-call]
    places = np.concatenate([nodes - 1.0, nodes + 1.0]) / 4.0  # in texels from the centre
    weights = np.tile(weights, 2) / 4.0
    step = np.pi / height
    elevation = _elevations(height)[:, None] + step * places
    ring = np.cos(elevation)
    measure = ring * weights * step
    polar = sh.legendre(np.sin(elevation), order)
    to_next = np.abs(places) if interpolated else np.zeros_like(places)
    integrals = {}
    for (band, m), value in polar.items():
        value = value * ring**m * measure
        here, lost = (value * (1.0 - to_next)).sum(axis=1), value * to_next
        below, above = lost[:, places < 0.0].sum(axis=1), lost[:, places > 0.0].sum(axis=1)
        here[:-1] += below[1:]
        here[1:] += above[:-1]
        here[0] += below[0]  # beyond the centres of the outermost rows there is nothing to blend with
        here[-1] += above[-1]
        integrals[band, m] = here
    return integrals


def srgb_to_linear(encoded: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    """Decode by the sRGB transfer function of IEC 61966-2-1; values in [0, 1]."""
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4).astype(np.float32)
