# SPDX-License-Identifier: GPL-3.0-or-later
"""Shows transport as colours on its mesh: one coefficient, or all of a band together."""

from __future__ import annotations

from typing import Literal

import bpy
import numpy as np
import numpy.typing as npt

from ...core.layout import LAYERS
from ...core.notices import Kind, Notice
from ...core.sphere import sh
from ..blender.libraries import is_local
from . import layers, temporary_layer
from .carrier import transport_mesh

Part = Literal["T0", "T1", "T2", "T3", "T4", "T5", "T6", "T7", "T8", "BAND1", "BAND2"]

_CARRIED = Kind(
    "{name} cannot show its transport: that lies behind modifiers, or on a shared mesh. Apply its modifiers (Object > Apply > "
    "Visual Geometry to Mesh) or make it a single user, and bake again.",
    "{count} objects cannot show their transport, as it lies behind modifiers, or on shared meshes: apply these, or make them "
    "single users, and bake again: {names}.",
)
_LINKED = Kind(
    "{name} cannot show its transport: its mesh is linked from a library.",
    "{count} objects cannot show their transport, as their meshes are linked from libraries: {names}.",
)


def show(ob: bpy.types.Object, part: Part) -> list[Notice]:
    """Show a part as the active colour layer of a baked object's own mesh; what cannot be shown is returned."""
    mesh = ob.data
    if transport_mesh(ob) != mesh:
        return [Notice(_CARRIED, ob.name)]
    if not is_local(mesh):
        return [Notice(_LINKED, ob.name)]
    rgba = np.ones((len(mesh.attributes[LAYERS[0]].data), 4), dtype=np.float32)
    rgba[:, :3] = colours(layers.read(mesh), part)
    temporary_layer.show(mesh, temporary_layer.TRANSPORT, layers.domain_of(mesh), rgba)
    return []


def colours(transport: npt.NDArray[np.float32], part: Part) -> npt.NDArray[np.float64]:
    """(N, 3) linear colours of transport (N, 9, 3), in its own axes.

    T_0 and bands are shares of what an open receiver has, white is 1: a band by its length over m, which no rotation
    changes. Other coefficients have a sign: grey of one half is 0, black and white are the most that an open one can have.
    """
    if part.startswith("BAND"):
        band = int(part[-1])
        return np.linalg.norm(transport[:, sh.band_slice(band)].astype(np.float64), axis=1) / _open(band)
    index = int(part[1:])
    share = transport[:, index].astype(np.float64) / _open(int(np.sqrt(index)))
    return (1.0 + share) / 2.0 if index else share


def _open(band: int) -> float:
    """The length over m of what an open receiver has: `A_l / pi * sqrt((2l + 1) / (4 pi))`, by the addition theorem."""
    return float(sh.cosine_lobe(band)[band] / np.pi * np.sqrt((2 * band + 1) / (4.0 * np.pi)))
