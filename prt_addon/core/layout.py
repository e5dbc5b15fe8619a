# SPDX-License-Identifier: GPL-3.0-or-later
"""Defines how transport is stored: the layers on a mesh, and what each of their four floats means.

RGB of layer i is T_i, all light; alpha is D_i, the part of it that came straight from the sky, which has no colour: what
bounced is RGB less alpha. Alpha of the first layer is D_0 less 1 where the coefficients are in the scene's axes, less 2 where
they are in the object's own. D_0 is in [0, 0.2821], so that one float also says whether there is transport at all: what
a shader reads of a mesh without the layer is 1, of geometry that was joined to a baked mesh 0.

Version 1 had alpha 0 in all layers, and 1 in that of `_PRT_1` where the axes were the object's own.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
import numpy.typing as npt

from .sphere import sh

LAYERS = tuple(f"_PRT_{i}" for i in range(sh.coefficient_count(sh.ORDER)))
"""Names of the float colour layers, one per coefficient. The leading underscore lets glTF carry them."""

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

Float32 = npt.NDArray[np.float32]


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
