# SPDX-License-Identifier: GPL-3.0-or-later
"""Computes what share of light a mirror reflects, by Schlick's approximation (1994)."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ..arrays import Float64


def grazing_share(cosine: npt.ArrayLike) -> Float64:
    """`(1 - cosine)**5`, how far the colour has gone to white; cosine between ray and mirror's normal, in [0, 1]."""
    return (1.0 - np.asarray(cosine, dtype=np.float64)) ** 5


def schlick(facing: npt.ArrayLike, cosine: npt.ArrayLike) -> Float64:
    """F: reflectance in [0, 1]; `facing` is that of rays along the normal (F0). Shapes broadcast."""
    facing = np.asarray(facing, dtype=np.float64)
    return facing + (1.0 - facing) * grazing_share(cosine)
