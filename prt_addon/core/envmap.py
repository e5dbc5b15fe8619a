# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of the sky to SH light."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from . import sh
from .errors import PictureError

Array = npt.NDArray[np.float64]

_ROWS_AT_A_TIME = 64  # float64 copies stay small whatever the picture's size


def _azimuths(width: int) -> Array:
    return 2.0 * np.pi * (0.5 - (np.arange(width) + 0.5) / width)


def _elevations(height: int) -> Array:
    return np.pi * ((np.arange(height) + 0.5) / height - 0.5)


def project_equirect(pixels: npt.NDArray[np.float32] | Array, order: int = sh.ORDER) -> Array:
    """Project an equirectangular picture, every texel, onto spherical harmonics.

    A row shares its polar functions, so the azimuth is one matrix product per row and the cost per texel is
    `2 * order + 1` multiply-adds per channel. Sums are float64: in float32 they drift by percents on large pictures.

    Args:
        pixels: (height, width, 3) linear radiance, row 0 at the bottom (Blender's order).
        order: highest band.

    Returns:
        ((order + 1)**2, 3) float64, `L_i = sum L(w) Y_i(w) dw`.

    Raises:
        PictureError: if the picture is empty or holds NaN or infinite texels.
    """
    height, width = pixels.shape[:2]
    if not height or not width:
        raise PictureError("The sky picture is empty: load one that has pixels.")
    azimuthal, polar = _azimuthal_integrals(width, order), _polar_integrals(height, order)
    light = np.zeros((sh.coefficient_count(order), 3))
    for first in range(0, height, _ROWS_AT_A_TIME):
        rows = slice(first, first + _ROWS_AT_A_TIME)
        texels = pixels[rows].astype(np.float64)
        if not np.isfinite(texels).all():
            raise PictureError(
                "The sky picture holds NaN or infinite texels: repair it in the compositor and load it again."
            )
        moments = np.einsum("mw,hwc->mhc", azimuthal, texels, optimize=True)
        for (band, m), weight in polar.items():
            centre = band * (band + 1)
            light[centre + m] += weight[rows] @ moments[m]
            if m:
                light[centre - m] += weight[rows] @ moments[order + m]
    return light


def _azimuthal_integrals(width: int, order: int) -> Array:
    """(2 order + 1, width): cos(m phi), then sin(m phi), integrated over each column."""
    azimuth, step = _azimuths(width), 2.0 * np.pi / width
    cosines = [np.cos(m * azimuth) * step * np.sinc(m / width) for m in range(order + 1)]
    sines = [np.sin(m * azimuth) * step * np.sinc(m / width) for m in range(1, order + 1)]
    return np.stack(cosines + sines)


def _polar_integrals(height: int, order: int) -> dict[tuple[int, int], Array]:
    """For each (l, m), the polar part of Y_lm integrated over the solid angle of each row: (height,).

    Integrated, not sampled at the texel's centre: a constant sky is then exact at any resolution. By Gauss-Legendre
    quadrature in the elevation, where the integrand is smooth up to the poles.
    """
    nodes, weights = np.polynomial.legendre.leggauss(12)  # type: ignore[no-untyped-call]
    step = np.pi / height
    elevation = _elevations(height)[:, None] + step / 2.0 * nodes
    ring = np.cos(elevation)
    measure = ring * weights * step / 2.0
    polar = sh.legendre(np.sin(elevation), order)
    return {(band, m): (value * ring**m * measure).sum(axis=1) for (band, m), value in polar.items()}


def srgb_to_linear(encoded: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    """The sRGB transfer function of IEC 61966-2-1, decoded; values in [0, 1]."""
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4).astype(np.float32)
