# SPDX-License-Identifier: GPL-3.0-or-later
"""Evaluates real spherical harmonics: the basis, the clamped-cosine lobe, and the quadratic form of band 2."""

from __future__ import annotations

from math import factorial, pi, sqrt

import numpy as np
import numpy.typing as npt

from ..arrays import Float64

ORDER = 2
"""The order that is stored: nine coefficients, as Ramamoorthi & Hanrahan (2001) argue for diffuse light."""

MAX_ORDER = 8


def coefficient_count(order: int) -> int:
    """Number of coefficients of bands 0..order: `(order + 1)**2`."""
    return (order + 1) ** 2


def order_of(count: int) -> int:
    """The order that has `count` coefficients.

    Raises:
        ValueError: if `count` is not a square number.
    """
    order = round(sqrt(count)) - 1
    if coefficient_count(order) != count:
        raise ValueError(f"{count} coefficients are no whole number of bands")
    return order


def band_slice(band: int) -> slice:
    """The slice of band `l` among the coefficients: `l*l .. (l+1)**2`."""
    return slice(band * band, (band + 1) ** 2)


def legendre(z: Float64, order: int) -> dict[tuple[int, int], Float64]:
    """Normalised associated Legendre functions divided by `sin(theta)**m`, for 0 <= m <= l <= order.

    The division leaves a polynomial in z, which has no trouble at the poles: multiplied by the real or
    imaginary part of `(x + iy)**m` it gives the basis (Sloan 2013, "Efficient Spherical Harmonic Evaluation",
    section 2). No Condon-Shortley sign; the factor sqrt(2) of m > 0 is included.

    Args:
        z: any shape, cosine of the polar angle, in [-1, 1].
        order: highest band.
    """
    raw: dict[tuple[int, int], Float64] = {}
    for m in range(order + 1):
        raw[m, m] = np.full_like(z, float(np.prod(np.arange(1, 2 * m, 2))))
        if m < order:
            raw[m + 1, m] = (2 * m + 1) * z * raw[m, m]
        for band in range(m + 2, order + 1):
            raw[band, m] = ((2 * band - 1) * z * raw[band - 1, m] - (band + m - 1) * raw[band - 2, m]) / (band - m)
    return {(band, m): _norm(band, m) * value for (band, m), value in raw.items()}


def _norm(band: int, m: int) -> float:
    norm = sqrt((2 * band + 1) / (4 * pi) * factorial(band - m) / factorial(band + m))
    return norm if m == 0 else sqrt(2) * norm


def basis(directions: npt.ArrayLike, order: int = ORDER) -> Float64:
    """The real spherical harmonics at unit directions.

    Args:
        directions: (..., 3) unit vectors, Z up.
        order: highest band, 0..8 in practice.

    Returns:
        (..., (order + 1)**2) float64, `Y_lm` at index `l * (l + 1) + m`: Y_1 is proportional to (y, z, x).
    """
    x, y, z = np.moveaxis(np.asarray(directions, dtype=np.float64), -1, 0)
    polar = legendre(z, order)
    out = np.empty((*z.shape, coefficient_count(order)))
    cos_m, sin_m = np.ones_like(z), np.zeros_like(z)  # real and imaginary part of (x + iy)**m
    for m in range(order + 1):
        for band in range(m, order + 1):
            centre = band * (band + 1)
            out[..., centre + m] = polar[band, m] * cos_m
            if m:
                out[..., centre - m] = polar[band, m] * sin_m
        cos_m, sin_m = cos_m * x - sin_m * y, cos_m * y + sin_m * x
    return out


def cosine_lobe(order: int = ORDER) -> Float64:
    """Zonal factors `A_l` of the clamped cosine, one per band: pi, 2pi/3, pi/4, 0, -pi/24, ...

    Ramamoorthi & Hanrahan 2001, "An Efficient Representation for Irradiance Environment Maps", equation 8, where they
    wear a hat.
    """
    factors = np.zeros(order + 1)
    for band in range(order + 1):
        if band == 1:
            factors[band] = 2 * pi / 3
        elif band % 2 == 0:
            half = band // 2
            sign = -1.0 if half % 2 == 0 else 1.0
            factors[band] = (
                2 * pi * sign / ((band + 2) * (band - 1)) * factorial(band) / (2**band * factorial(half) ** 2)
            )
    return factors


def per_coefficient(per_band: npt.ArrayLike) -> Float64:
    """Repeat one number per band over the `2l + 1` coefficients of that band."""
    values = np.asarray(per_band, dtype=np.float64)
    return np.repeat(values, [2 * band + 1 for band in range(len(values))])


# Band 2 as a traceless symmetric form: sum_m c_2m Y_2m(w) = w^T Q w. It turns as Q -> R Q R^T, which needs no
# trigonometry; the shader graph and the per-vertex rotation both use it. These are the constants of Y_2m.
K_XY = sqrt(15 / (4 * pi))
K_ZZ = sqrt(5 / (16 * pi))
K_XX = K_XY / 2


def band2_form(coefficients: Float64) -> Float64:
    """Symmetric traceless matrices (..., 3, 3) of band-2 coefficients (..., 5)."""
    xy, yz, zz, zx, xx = np.moveaxis(coefficients, -1, 0)
    form = np.empty((*xy.shape, 3, 3))
    form[..., 0, 0] = K_XX * xx - K_ZZ * zz
    form[..., 1, 1] = -K_XX * xx - K_ZZ * zz
    form[..., 2, 2] = 2 * K_ZZ * zz
    form[..., 0, 1] = form[..., 1, 0] = K_XX * xy
    form[..., 1, 2] = form[..., 2, 1] = K_XX * yz
    form[..., 2, 0] = form[..., 0, 2] = K_XX * zx
    return form


def band2_coefficients(form: Float64) -> Float64:
    """Inverse of `band2_form`: (..., 3, 3) back to (..., 5)."""
    return np.stack(
        [
            form[..., 0, 1] / K_XX,
            form[..., 1, 2] / K_XX,
            form[..., 2, 2] / (2 * K_ZZ),
            form[..., 0, 2] / K_XX,
            (form[..., 0, 0] - form[..., 1, 1]) / (2 * K_XX),
        ],
        axis=-1,
    )
