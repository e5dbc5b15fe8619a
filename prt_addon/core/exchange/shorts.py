# SPDX-License-Identifier: GPL-3.0-or-later
"""Rounds layers of transport to whole numbers of 16 bits, for glTF, which has floats of 32 bits or whole numbers."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

MOST = 32767
"""The whole number that stands for 1, as glTF has it of normalised shorts."""


def rounded(layers: npt.NDArray[np.floating[Any]]) -> tuple[npt.NDArray[np.int16], npt.NDArray[np.float64]]:
    """Whole numbers, and what they are multiplied by once they are normalised to -1 to 1.

    A layer has two scales, one for its colour and one for its alpha: that of the first holds a mark of up to -2, beside which
    a colour of 0.28 would lose three bits.

    Args:
        layers: (N, K, 4) the layers of fronts or of backs.

    Returns:
        (N, K, 4), and (K, 2) scales: the largest magnitudes, 1 where all is 0.
    """
    parts = layers[..., :3], layers[..., 3:]
    scales = np.stack([np.abs(part).max(axis=(0, 2), initial=0.0) for part in parts], axis=-1).astype(np.float64)
    scales = np.where(scales > 0.0, scales, 1.0)
    return np.rint(layers / _per_float(scales) * MOST).astype(np.int16), scales


def restored(normalized: npt.NDArray[np.floating[Any]], scales: npt.NDArray[np.float64]) -> npt.NDArray[np.float32]:
    """The layers (N, K, 4) of normalised numbers, -1 to 1, and of their scales (K, 2)."""
    return (normalized * _per_float(scales)).astype(np.float32)


def _per_float(scales: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """(K, 4) the scale of each float of a layer."""
    return scales[:, [0, 0, 0, 1]]
