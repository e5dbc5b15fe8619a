# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the light of now as a colour on the mesh, for programs that show vertex colours and no transport."""

from __future__ import annotations

from typing import Literal, get_args

import bpy
import numpy as np
import numpy.typing as npt

from ...core.layout import FROZEN
from ...core.notices import Kind, Notice
from ...core.shown import linear_to_srgb, shown
from ...core.sphere.rotation import rotation_matrix
from ..blender.libraries import is_local
from ..light import light
from ..mesh import layers
from ..mesh.carrier import show_light, transport_mesh
from ..mesh.carrier_group import LightKind
from ..mesh.meshes import own_axes

Encoding = Literal["LINEAR", "SRGB", "BYTE"]
ENCODINGS = get_args(Encoding)

_LINKED = Kind(
    "The light of {name} is not frozen: it, or its mesh, is linked from a library.",
    "The light of {count} objects is not frozen, as they, or their meshes, are linked from libraries: {names}.",
)
_CUT_OFF = Kind(
    "The light of {name} is brighter than bytes can hold in {share} of its elements, and is cut off there: lower the world's "
    "strength, or freeze floats.",
    "The light of {count} objects is brighter than bytes can hold, and is cut off: lower the world's strength, or freeze floats: {names}.",
)


def freeze(ob: bpy.types.Object, world: bpy.types.World, encoding: Encoding) -> list[Notice]:
    """Write what a white surface shows now into one colour attribute of a baked object, in place of an earlier one.

    It lies where the transport does: on the object's own mesh, or on its carrier, from which the modifier copies it onto what
    the stack comes to.

    Args:
        ob: the baked object.
        world: that carries the light.
        encoding: floats in linear light or as sRGB has them, or bytes, which are sRGB in Blender.

    Returns:
        What cannot be written, or is not as it should be.

    Raises:
        LightError, VersionError: if the world carries no light.
    """
    mesh = transport_mesh(ob)
    carried = mesh != ob.data
    if not is_local(mesh) or (carried and not is_local(ob)):
        return [Notice(_LINKED, ob.name)]
    sky = light.shown_light(world)
    if layers.space_of(mesh) == "OBJECT":
        sky = rotation_matrix(own_axes(ob.matrix_world).T) @ sky
    colours = shown(layers.read(mesh), sky)
    bright = float((colours.max(axis=1) > 1.0).mean()) if len(colours) and encoding == "BYTE" else 0.0
    kind: LightKind = "BYTE_COLOR" if encoding == "BYTE" else "FLOAT_COLOR"
    _write(mesh, linear_to_srgb(colours) if encoding == "SRGB" else colours, kind)
    if carried:
        show_light(ob, kind)
    return [Notice(_CUT_OFF, ob.name, {"share": f"{bright:.0%}"})] if bright > 0.0 else []


def _write(mesh: bpy.types.Mesh, colours: npt.NDArray[np.float64], kind: LightKind) -> None:
    attributes = mesh.color_attributes
    active, rendered = attributes.active_color_name, attributes.default_color_name
    if FROZEN in mesh.attributes:
        mesh.attributes.remove(mesh.attributes[FROZEN])
    mesh.attributes.new(FROZEN, kind, layers.domain_of(mesh))
    rgba = np.ones((len(colours), 4), dtype=np.float32)
    rgba[:, :3] = np.minimum(colours, 1.0) if kind == "BYTE_COLOR" else colours
    mesh.attributes[FROZEN].data.foreach_set("color", rgba.reshape(-1))  # bytes are encoded by Blender
    attributes.active_color_name, attributes.default_color_name = active or FROZEN, rendered or FROZEN
    mesh.update()
