# SPDX-License-Identifier: GPL-3.0-or-later
"""Shows the error of a bake as colours on its mesh: a temporary layer, blue where too dark, red where too bright."""

from __future__ import annotations

import bpy
import numpy as np
import numpy.typing as npt

from . import temporary_layer
from .meshes import ObjectReceivers

LAYER = temporary_layer.ERROR
FULL_COLOUR = 0.25
"""The error, as a share of the object's true radiance, that is shown in full red or blue."""


def write(mesh: bpy.types.Mesh, receivers: ObjectReceivers, errors: npt.NDArray[np.float64]) -> None:
    """Show signed errors (receivers,) as the mesh's active colour layer, in place of an earlier map."""
    temporary_layer.show(mesh, LAYER, receivers.domain, _colours(errors)[receivers.element_receiver])


def _colours(errors: npt.NDArray[np.float64]) -> npt.NDArray[np.float32]:
    """(n, 4) white where nothing is wrong, linear to full colour."""
    error = np.clip(errors / FULL_COLOUR, -1.0, 1.0)
    rgba = np.ones((len(error), 4), dtype=np.float32)
    rgba[:, 1] = 1.0 - np.abs(error)
    rgba[:, 0] = np.where(error < 0.0, rgba[:, 1], 1.0)
    rgba[:, 2] = np.where(error > 0.0, rgba[:, 1], 1.0)
    return rgba
