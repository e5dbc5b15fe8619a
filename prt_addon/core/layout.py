# SPDX-License-Identifier: GPL-3.0-or-later
"""Defines how transport is stored: the layers on a mesh, and what each of their four floats means.

RGB of layer i is T_i, all light; alpha is D_i, the part of it that came straight from the sky, which has no colour: what
bounced is RGB less alpha. Alpha of the first layer is D_0 less 1 where the coefficients are in the scene's axes, less 2 where
they are in the object's own. D_0 is in [0, 0.2821], so that one float also says whether there is transport at all: what
a shader reads of a mesh without the layer is 1, of geometry that was joined to a baked mesh 0.

Backs of faces have nine numbers without colour, B_i, in three layers more, on meshes whose backs may be seen: RGB of layer k
are B_3k to B_3k+2, but the first of all less 1, so that it marks such meshes likewise. Alphas of the three are a direct share d,
red r and green g: T_i is `B_i (r, g, 3 - r - g)`, D_i is `d B_i`. Twelve floats are all that EEVEE has room for beside textures;
a colour that all coefficients share keeps the hue of what bounced.

Version 1 had alpha 0 in all layers, and 1 in that of `_PRT_1` where the axes were the object's own.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from .arrays import Float32
from .sphere import sh

LAYERS = tuple(f"_PRT_{i}" for i in range(sh.coefficient_count(sh.ORDER)))
"""Names of the float colour layers, one per coefficient. The leading underscore lets glTF carry them."""

BACKS = tuple(f"_PRT_B{k}" for k in range(len(LAYERS) // 3))
"""Names of the layers of backs, three coefficients each."""

FROZEN = "PRT Light"
"""Name of the colour attribute that keeps the light of one moment, for programs that know no transport."""

Space = Literal["SCENE", "OBJECT"]
"""Whose axes coefficients are in."""

MARK: dict[Space, float] = {"SCENE": 1.0, "OBJECT": 2.0}
"""What alpha of the first layer is less than D_0."""

BAKED_BELOW = -0.5
"""Alpha of the first layer, of a mesh with transport of this version."""

OWN_AXES_BELOW = -1.5
"""Alpha of the first layer, where the axes are the object's own."""

_OF_NO_LIGHT = 1.0, 1.0, 1.0
"""Share and colour where no light arrives: neighbours are drawn towards them."""


def packed(index: int, transport: Float32, direct: Float32, space: Space) -> Float32:
    """The four floats of one coefficient.

    Args:
        index: of the coefficient.
        transport: (N,) or (N, 3) T_i.
        direct: (N,) D_i.
        space: whose axes transport is in, which the mark of coefficient 0 says.

    Returns:
        (N, 4).
    """
    rgba = np.empty((len(transport), 4), dtype=np.float32)
    rgba[:, :3] = transport if transport.ndim == 2 else transport[:, None]
    rgba[:, 3] = direct - np.float32(MARK[space]) if index == 0 else direct
    return rgba


def packed_backs(transport: Float32, direct: Float32) -> Float32:
    """The floats of all layers of backs.

    B is the mean of the colours; share and colour are the multiples of B that come closest to D and to T.

    Args:
        transport: (N, 9) or (N, 9, 3) T.
        direct: (N, 9) D.

    Returns:
        (N, 3, 4).
    """
    colours = transport if transport.ndim == 3 else transport[:, :, None].repeat(3, axis=2)
    grey = colours.mean(axis=2)
    rgba = np.empty((len(grey), len(BACKS), 4), dtype=np.float32)
    rgba[:, :, :3] = grey.reshape(len(grey), len(BACKS), 3)
    rgba[:, 0, 0] -= np.float32(MARK["SCENE"])
    square = np.square(grey).sum(axis=1, keepdims=True)
    rgba[:, :, 3] = np.where(square > 0.0, 0.0, _OF_NO_LIGHT)
    fitted = np.stack([direct, colours[:, :, 0], colours[:, :, 1]], axis=1)
    np.divide(np.einsum("nki,ni->nk", fitted, grey), square, out=rgba[:, :, 3], where=square > 0.0)
    return rgba


def unpacked_backs(rgba: Float32) -> Float32:
    """(N, 9, 3) T of backs from the floats (N, 3, 4) of their layers."""
    grey = rgba[:, :, :3].reshape(len(rgba), len(LAYERS)).copy()
    grey[:, 0] += np.float32(MARK["SCENE"])
    red, green = rgba[:, 1, 3], rgba[:, 2, 3]
    transport: Float32 = grey[:, :, None] * np.stack([red, green, 3.0 - red - green], axis=1)[:, None]
    return transport
