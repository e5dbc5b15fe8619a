# SPDX-License-Identifier: GPL-3.0-or-later
"""Sums the light of all bounces: the series `T = T0 + G T0 + G G T0 + ...` (Kajiya 1986, "The Rendering Equation",
section 3; Sloan, Kautz & Snyder 2002, "Precomputed Radiance Transfer", section 5).

Only the last gather, whose result is seen, reads all hits: `T = T0 + G (T0 + G' T0 + G'' G' T0 + ...)`. Those within are
thin, each in its own way: their noise differs from receiver to receiver and from bounce to bounce, and little of it is
left in the mean over all that the last one reads (final gathering: Reichert 1992, "A Two-Pass Radiosity Method Driven by
Lights and Viewer Position"). Measured at 256 rays, it lengthens the error by less than 2 % in the open, by 12 % in a
white room behind a slit, and by 22 % at worst.
"""

from __future__ import annotations

import numpy as np

from ..arrays import Float32
from .gather import Gather

MAX_BOUNCES = 100
"""Where "until converged" gives up. At an albedo of 0.9 a closed room is then within 3e-5 of its limit."""


def interreflected(
    direct: Float32,
    gather: Gather,
    bounces: int = 3,
    tolerance: float = 0.0,
) -> Float32:
    """Let light bounce.

    Args:
        direct: (N, 9) T0, what arrives without a bounce.
        gather: G, and thin G'.
        bounces: how often light bounces, if tolerance is 0.
        tolerance: if above 0, stop once one more bounce changes no coefficient by as much; `bounces` is ignored.

    Returns:
        (N, 9, 3) float32, RGB.
    """
    unbounced = np.broadcast_to(direct[:, None, :], (len(direct), gather.channels, direct.shape[1]))
    light = term = unbounced
    for number in range((MAX_BOUNCES if tolerance > 0.0 else bounces) - 1):
        term = gather(term, thin=number)
        if tolerance > 0.0 and np.abs(term).max(initial=0.0) < tolerance:
            break
        light = light + term
    transport = unbounced + gather(light) if bounces or tolerance > 0.0 else unbounced
    rgb = np.broadcast_to(transport, (len(direct), 3, direct.shape[1]))
    return np.ascontiguousarray(rgb.transpose(0, 2, 1))
