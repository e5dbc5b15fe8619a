# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the GAMES202 course's two files from a baked mesh and its world, and reads them back onto them."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
import numpy.typing as npt

from ...core.errors import MeshError
from ...core.exchange import games202
from ...core.layout import LAYERS
from ...core.problem import BakeSettings
from ...core.sphere.rotation import rotation_matrix
from ..light import light
from ..mesh import carrier, layers
from ..mesh.carrier import transport_mesh
from ..mesh.meshes import index_array, own_axes
from ..mesh.record import check_version

LIGHT_FILE, TRANSPORT_FILE = "light.txt", "transport.txt"


def export_files(ob: bpy.types.Object, world: bpy.types.World, directory: Path) -> None:
    """Write the light and the transport as both are turned now, one row per corner of the mesh's triangles.

    The files have one number per coefficient: coloured transport is averaged over its channels.

    Raises:
        MeshError: if the mesh is not baked.
        VersionError: if a newer version baked it.
        LightError, OSError: if there is no light, or the folder cannot be written.
    """
    mesh = transport_mesh(ob)
    check_version(ob, mesh)
    if not layers.is_baked(mesh):
        raise MeshError(f"Object '{ob.name}' is not baked: bake it, then export.")
    corners, vertices = _triangle_corners(mesh)
    elements = vertices if layers.domain_of(mesh) == "POINT" else corners
    rows = layers.read(mesh).mean(axis=2, dtype=np.float64)[elements] @ _to_world(ob).T
    games202.write_both(
        directory / LIGHT_FILE, light.shown_light(world), directory / TRANSPORT_FILE, rows, len(mesh.vertices)
    )


def import_files(ob: bpy.types.Object, world: bpy.types.World, directory: Path) -> games202.Flavour:
    """Read both files onto a matching mesh and the world; the light then stands still, as the files know no turn.

    Returns:
        In which of the two scales in circulation the transport was.

    Raises:
        LightError, VersionError: if the world cannot carry the light.
        InterchangeError, OSError: if a file is missing, broken or made for another mesh; nothing was changed.
    """
    light.check_world(world)
    corners, _ = _triangle_corners(ob.data)
    coefficients = games202.read_light(directory / LIGHT_FILE)
    rows, flavour = games202.read_transport(directory / TRANSPORT_FILE, len(corners))
    transport = np.zeros((len(ob.data.loops), rows.shape[1]), dtype=np.float32)
    transport[corners] = rows
    settings = BakeSettings(mode="SHADOWED", samples=0)  # whatever the files' own tool did
    mesh = ob.data
    if carrier.is_shared(ob):
        mesh = carrier.hang(ob, carrier.Geometry.of(mesh), "CORNER")
    else:
        carrier.take_off(ob)
    carrier.sweep()
    layers.write(mesh, "CORNER", transport, transport, np.arange(len(transport)), settings)
    light.write_still_light(world, coefficients)
    return flavour


def _to_world(ob: bpy.types.Object) -> npt.NDArray[np.float64]:
    """(9, 9) matrix that takes the coefficients on a baked object into the world's axes."""
    if layers.space_of(transport_mesh(ob)) == "SCENE":
        return np.eye(len(LAYERS))
    return rotation_matrix(own_axes(ob.matrix_world))


def _triangle_corners(mesh: bpy.types.Mesh) -> tuple[npt.NDArray[np.int32], npt.NDArray[np.int32]]:
    """The face corner and the vertex at each corner of each triangle, in the order of the faces: (3 T,) each."""
    mesh.calc_loop_triangles()
    corners, vertices = (index_array(mesh.loop_triangles, name, 3).ravel() for name in ("loops", "vertices"))
    return corners, vertices
