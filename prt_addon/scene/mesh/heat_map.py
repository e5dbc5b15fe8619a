# SPDX-License-Identifier: GPL-3.0-or-later
"""The error of a bake as colours on its mesh: a temporary layer, blue where too dark, red where too bright."""

from __future__ import annotations

import bpy
import numpy as np
import numpy.typing as npt

from .meshes import ObjectReceivers

LAYER = "PRT Error"
FULL_COLOUR = 0.25
"""The error, as a share of the object's true radiance, that is shown in full red or blue."""

_WAS_ACTIVE = "prt_active_before_error"


def write(mesh: bpy.types.Mesh, receivers: ObjectReceivers, errors: npt.NDArray[np.float64]) -> None:
    """Show signed errors (receivers,) as the mesh's active colour layer, in place of an earlier map."""
    remove(mesh)
    mesh[_WAS_ACTIVE] = mesh.color_attributes.active_color_name
    mesh.attributes.new(LAYER, "FLOAT_COLOR", receivers.domain)
    mesh.attributes[LAYER].data.foreach_set("color", _colours(errors)[receivers.element_receiver].reshape(-1))
    mesh.color_attributes.active_color_name = LAYER
    mesh.update()


def remove(mesh: bpy.types.Mesh) -> bool:
    """Remove the map, and make active what was before; True if there was one."""
    found = mesh.attributes.get(LAYER)
    if found:
        mesh.attributes.remove(found)
        mesh.color_attributes.active_color_name = mesh.get(_WAS_ACTIVE, "")
    if _WAS_ACTIVE in mesh:
        del mesh[_WAS_ACTIVE]
    return found is not None


def _colours(errors: npt.NDArray[np.float64]) -> npt.NDArray[np.float32]:
    """(n, 4) white where nothing is wrong, linear to full colour."""
    error = np.clip(errors / FULL_COLOUR, -1.0, 1.0)
    rgba = np.ones((len(error), 4), dtype=np.float32)
    rgba[:, 1] = 1.0 - np.abs(error)
    rgba[:, 0] = np.where(error < 0.0, rgba[:, 1], 1.0)
    rgba[:, 2] = np.where(error > 0.0, rgba[:, 1], 1.0)
    return rgba
