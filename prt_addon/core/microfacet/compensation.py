# SPDX-License-Identifier: GPL-3.0-or-later
"""Gives rough mirrors back the light that they lose: what meets more than one of them (Kulla & Conty 2017).

"Revisiting Physically Based Shading at Imageworks", SIGGRAPH course. A lobe is added to the BRDF whose albedo is what the
first lobe lacks, `1 - E(mu)`, so that white mirrors return all light; of coloured ones each further bounce takes its share.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ..arrays import Float64

_NOTHING = 1e-9  # a share of light that is not worth a division


def lost_lobe(albedo_out: npt.ArrayLike, albedo_in: npt.ArrayLike, average: npt.ArrayLike) -> Float64:
    """f_ms, the lobe of white mirrors: `(1 - E(mu_out)) (1 - E(mu_in)) / (pi (1 - E_avg))`, in 1/sr; shapes broadcast."""
    lost = np.maximum(1.0 - np.asarray(average, dtype=np.float64), _NOTHING)
    return (1.0 - np.asarray(albedo_out)) * (1.0 - np.asarray(albedo_in)) / (np.pi * lost)


def bounce_colour(fresnel_average: npt.ArrayLike, average: npt.ArrayLike) -> Float64:
    """The factor of f_ms for coloured mirrors: `F_avg**2 E_avg / (1 - F_avg (1 - E_avg))`.

    Light that has met one mirror and not left has been coloured once. At every further one it is coloured again, and then
    leaves by the share E_avg: a geometric series. Both lobes together return `F_avg E_avg / (1 - F_avg (1 - E_avg))` of
    light from everywhere, if F does not depend on the angle.

    Args:
        fresnel_average: F_avg in [0, 1], per channel.
        average: E_avg in (0, 1]; shapes broadcast.
    """
    return np.asarray(fresnel_average) * course_bounce_colour(fresnel_average, average)


def course_bounce_colour(fresnel_average: npt.ArrayLike, average: npt.ArrayLike) -> Float64:
    """The same factor as the GAMES202 course has it, `f_add = F_avg E_avg / (1 - F_avg (1 - E_avg))`: one factor F_avg short.

    It is the whole of the light that leaves, used as the colour of the part that is left after one bounce. Both lobes
    together then return too much, by the share `(1 - E_avg) (1 - F_avg)`. Kept for comparison with what the course shows.
    """
    fresnel, average = np.asarray(fresnel_average, dtype=np.float64), np.asarray(average, dtype=np.float64)
    return fresnel * average / (1.0 - fresnel * (1.0 - average))
