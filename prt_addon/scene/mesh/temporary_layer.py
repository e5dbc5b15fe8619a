# SPDX-License-Identifier: GPL-3.0-or-later
"""Shows a colour layer on a mesh for a while, as its active one: an error, or transport itself."""

from __future__ import annotations

import bpy
import numpy as np
import numpy.typing as npt

from .meshes import Domain

ERROR, TRANSPORT = "PRT Error", "PRT Transport"

_WAS_ACTIVE = "prt_active_before_error"  # and before transport: files of version 0.1 have it by this name


def show(mesh: bpy.types.Mesh, name: str, domain: Domain, colours: npt.NDArray[np.float32]) -> None:
    """Show colours (elements of the domain, 4) under one of the names, in place of whatever is shown so far."""
    take_back(mesh)
    mesh[_WAS_ACTIVE] = mesh.color_attributes.active_color_name
    mesh.attributes.new(name, "FLOAT_COLOR", domain)
    mesh.attributes[name].data.foreach_set("color", colours.reshape(-1))
    mesh.color_attributes.active_color_name = name
    mesh.update()


def take_back(mesh: bpy.types.Mesh, names: tuple[str, ...] = (ERROR, TRANSPORT)) -> bool:
    """Remove what is shown under these names, and make active what was before; True if there was any."""
    shown = [name for name in names if name in mesh.attributes]
    for name in shown:
        mesh.attributes.remove(mesh.attributes[name])
    if shown:
        mesh.color_attributes.active_color_name = mesh.get(_WAS_ACTIVE, "")
    if _WAS_ACTIVE in mesh and not (ERROR in mesh.attributes or TRANSPORT in mesh.attributes):
        del mesh[_WAS_ACTIVE]
    return bool(shown)
