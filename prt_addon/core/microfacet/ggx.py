# SPDX-License-Identifier: GPL-3.0-or-later
"""Evaluates GGX: how the normals of a rough surface are spread, and how its facets hide each other.

The distribution is Trowbridge & Reitz's, known as GGX since Walter et al. 2007; masking and shadowing are Smith's, in the
form in which both grow with the depth of a facet (Heitz 2014, "Understanding the Masking-Shadowing Function",
equations 72 and 99). Directions are unit vectors in the frame of the surface, whose normal is +z.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ..arrays import Float64


def alpha_of(roughness: npt.ArrayLike) -> Float64:
    """The width of the distribution: the square of the roughness in [0, 1] that artists set (Burley 2012)."""
    return np.square(np.asarray(roughness, dtype=np.float64))


def distribution(cos_half: npt.ArrayLike, alpha: npt.ArrayLike) -> Float64:
    """D: the area of facets per area of the surface and solid angle of their normal, in 1/sr.

    Args:
        cos_half: cosine between the normal of the facets and that of the surface, in [0, 1].
        alpha: > 0, of a shape that goes with it.
    """
    square = np.square(alpha)
    return square / (np.pi * np.square(np.square(cos_half) * (square - 1.0) + 1.0))


def smith_lambda(cosine: npt.ArrayLike, alpha: npt.ArrayLike) -> Float64:
    """Lambda: the area of facets that are hidden from a direction, per visible area; cosine in (0, 1]."""
    square = np.square(cosine)
    return (np.sqrt(1.0 + np.square(alpha) * (1.0 - square) / square) - 1.0) / 2.0


def masking_shadowing(cos_out: npt.ArrayLike, cos_in: npt.ArrayLike, alpha: npt.ArrayLike) -> Float64:
    """G: the share of facets that both directions see, in [0, 1]; cosines in (0, 1]."""
    return 1.0 / (1.0 + smith_lambda(cos_out, alpha) + smith_lambda(cos_in, alpha))


def single_scattering(outgoing: Float64, incoming: Float64, alpha: npt.ArrayLike) -> Float64:
    """The BRDF of perfect mirrors that light meets once, `D G / (4 cos_out cos_in)`, in 1/sr.

    Args:
        outgoing: (..., 3) unit vectors above the surface.
        incoming: the same, of a shape that broadcasts with it.
        alpha: > 0.
    """
    half = outgoing + incoming
    cos_half = half[..., 2] / np.linalg.norm(half, axis=-1)
    cos_out, cos_in = outgoing[..., 2], incoming[..., 2]
    seen = masking_shadowing(cos_out, cos_in, alpha)
    return distribution(cos_half, alpha) * seen / (4.0 * cos_out * cos_in)
