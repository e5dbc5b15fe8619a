# SPDX-License-Identifier: GPL-3.0-or-later
"""Light that bounces: the series `T = T0 + G T0 + G G T0 + ...` (Kajiya 1986, "The Rendering Equation", section 3;
Sloan, Kautz & Snyder 2002, "Precomputed Radiance Transfer", section 5)."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from .gather import Gather

Float32 = npt.NDArray[np.float32]

MAX_BOUNCES = 100
"""Where "until converged" gives up. At an albedo of 0.9 a closed room is then within 3e-5 of its limit."""


def interreflected(
    direct: Float32,
    gather: Gather,
    bounces: int = 3,
    tolerance: float = 0.0,
) -> Float32:
    """Sum the series term by term: each bounce carries only what the one before it returned.

    Args:
        direct: (N, 9) T0, what arrives without a bounce.
        gather: G.
        bounces: how often light bounces, if tolerance is 0.
        tolerance: if above 0, stop once no coefficient changes by as much; `bounces` is ignored.

    Returns:
        (N, 9, 3) float32, RGB.
    """
    term = np.broadcast_to(direct[:, None, :], (len(direct), gather.channels, direct.shape[1]))
    transport = term.copy()
    for _ in range(MAX_BOUNCES if tolerance > 0.0 else bounces):
        term = gather(term)
        transport += term
        if tolerance > 0.0 and np.abs(term).max(initial=0.0) < tolerance:
            break
    rgb = np.broadcast_to(transport, (len(direct), 3, direct.shape[1]))
    return np.ascontiguousarray(rgb.transpose(0, 2, 1))
