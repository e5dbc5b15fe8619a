# SPDX-License-Identifier: GPL-3.0-or-later
"""Rotates SH vectors: by one matrix for any order, or quickly for many order-2 vectors at once."""

from __future__ import annotations

from functools import cache

import numpy as np
import numpy.typing as npt

from ..arrays import Float64
from . import sh
from .directions import fibonacci_sphere


@cache
def _sample_band(band: int) -> tuple[Float64, Float64]:
    """Directions and the pseudo-inverse of the band's basis there.

    A Fibonacci set of 4(2l + 1) points keeps the condition number below 1.6; a handful of random directions,
    as the method is often taught with, reaches 1e4.
    """
    directions = fibonacci_sphere(4 * (2 * band + 1))
    inverse = np.linalg.pinv(sh.basis(directions, band)[:, sh.band_slice(band)])
    return directions, inverse


def rotation_matrix(rotation: npt.ArrayLike, order: int = sh.ORDER) -> Float64:
    """Block-diagonal matrix `M(R)` that turns a function on the sphere: `(M c) . Y(w) = c . Y(R^-1 w)`.

    Per band `M = (A^-1 S)^T`, from the basis A at sample directions and S at the turned ones.

    Args:
        rotation: (3, 3) proper rotation.
        order: highest band, 0..8.

    Returns:
        ((order + 1)**2, (order + 1)**2) float64, orthogonal to about 1e-14.
    """
    turn = np.asarray(rotation, dtype=np.float64)
    matrix = np.zeros((sh.coefficient_count(order),) * 2)
    for band in range(order + 1):
        directions, inverse = _sample_band(band)
        here = sh.band_slice(band)
        matrix[here, here] = inverse @ sh.basis(directions @ turn, band)[:, here]
    return matrix


def rotate_order2(coefficients: Float64, frames: Float64) -> Float64:
    """Turn N order-2 vectors by N rotations, by band 1 as a vector and band 2 as a form.

    Args:
        coefficients: (N, 9), in the local frame.
        frames: (N, 3, 3), *rows* are the local axes in world space: `world = local @ frame`.

    Returns:
        (N, 9) float64 in world space.
    """
    out = np.empty_like(coefficients)
    out[:, 0] = coefficients[:, 0]
    vector = coefficients[:, [3, 1, 2]]  # Y_1 is ordered y, z, x
    out[:, [3, 1, 2]] = np.matmul(vector[:, None, :], frames)[:, 0, :]
    form = sh.band2_form(coefficients[:, 4:9])
    out[:, 4:9] = sh.band2_coefficients(np.matmul(frames.transpose(0, 2, 1), np.matmul(form, frames)))
    return out
