# SPDX-License-Identifier: GPL-3.0-or-later
"""Removes transport from objects, wherever it lies."""

from __future__ import annotations

import bpy

from ...core.errors import MeshError
from ..blender.libraries import check_local
from ..mesh import carrier, layers
from ..mesh.record import RECORD, check_version


def check_removable(ob: bpy.types.Object) -> None:
    """Raises MeshError or VersionError if a mesh object carries transport that cannot be removed."""
    mesh = carrier.transport_mesh(ob)
    if RECORD in mesh or layers.is_baked(mesh):
        owner = ob if carrier.carrier_of(ob) else mesh
        check_local(owner, f"Mesh '{mesh.name}' of '{ob.name}'", "remove", MeshError)
        check_version(ob, mesh)


def remove_transport(ob: bpy.types.Object) -> bool:
    """Remove the layers of an object from its own mesh, and its carrier; True if there was any.

    Call `carrier.sweep` when all objects are done.
    """
    return layers.remove(ob.data) | carrier.take_off(ob)
