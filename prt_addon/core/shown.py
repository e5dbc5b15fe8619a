# SPDX-License-Identifier: GPL-3.0-or-later
"""Computes what the shader shows of transport under a light, by the node group's formula
(`scene.shading.relight_group`).
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from .arrays import Float64


def shown(transport: npt.NDArray[np.floating[Any]], light: Float64) -> Float64:
    """Compute the radiance of a white surface.

    Args:
        transport: (N, 9, 3) T_i.
        light: (9, 3) L_i in the same axes, turned and scaled.

    Returns:
        (N, 3) the sums of T_i L_i; where a channel is negative, moved towards the grey of the mean until none is.
    """
    radiance: Float64 = np.einsum("nic,ic->nc", transport, light)
    least, mean = radiance.min(axis=1, keepdims=True), radiance.mean(axis=1, keepdims=True)
    share = np.minimum(np.maximum(-least, 0.0) / np.maximum(mean - least, 1e-9), 1.0)
    return np.maximum(radiance + share * (mean - radiance), 0.0)


def linear_to_srgb(linear: Float64) -> Float64:
    """The sRGB transfer function of IEC 61966-2-1, encoded; values from 0, also above 1."""
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.maximum(linear, 0.0) ** (1.0 / 2.4) - 0.055)
