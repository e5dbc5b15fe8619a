# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials to albedo: what light takes on where it bounces.

The diffuse colour of a material is read from its own nodes: a constant, an image texture or a colour attribute. A metal
bounces its base colour as if it were matte, and alpha is ignored: transport is diffuse and opaque.
"""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np
import numpy.typing as npt

from ..core.albedo import AlbedoPattern, CornerColours, Interpolation, TexturePatch
from ..core.errors import PictureError
from .images import linear_pixels
from .meshes import Surface
from .nodes import diffuse_colour, feeding_socket

Float32 = npt.NDArray[np.float32]

DEFAULT_COLOUR = (0.8, 0.8, 0.8)
"""Of surfaces without a material, as Blender shows them."""


@dataclass(frozen=True)
class SurfaceAlbedo:
    """Albedo of one object's triangles: constants (T, 3), patterns over some of them, and what could not be followed."""

    constant: Float32
    patterns: list[AlbedoPattern]
    warnings: list[str]


class _NotFollowed(Exception):
    """A colour that comes from nodes which are not read; the message names them."""


def read_albedo(ob: bpy.types.Object, mesh: bpy.types.Mesh, surface: Surface) -> SurfaceAlbedo:
    """Albedo of an evaluated object's surface, material slot by material slot."""
    constant = np.empty((len(surface.triangles), 3), dtype=np.float32)
    constant[:] = DEFAULT_COLOUR
    patterns: list[AlbedoPattern] = []
    warnings = []
    slots = [slot.material for slot in ob.material_slots]
    for index in np.unique(surface.material):
        material = slots[min(index, len(slots) - 1)] if slots else None
        if material is None:
            continue
        triangles = np.flatnonzero(surface.material == index)
        try:
            found = _material_albedo(material, mesh, surface.corners[triangles], triangles)
        except (_NotFollowed, PictureError) as reason:
            found = tuple(material.diffuse_color[:3])
            warnings.append(
                f"The colour that light takes on from material '{material.name}' is its viewport colour: {reason}"
            )
        if isinstance(found, tuple):
            constant[triangles] = found
        else:
            patterns.append(found)
    return SurfaceAlbedo(constant, patterns, warnings)


def _material_albedo(
    material: bpy.types.Material, mesh: bpy.types.Mesh, corners: npt.NDArray[np.int32], triangles: npt.NDArray[np.int64]
) -> tuple[float, ...] | AlbedoPattern:
    """One colour, or a pattern over the triangles."""
    if not material.use_nodes:
        return tuple(material.diffuse_color[:3])
    entry = diffuse_colour(material.node_tree.get_output_node("CYCLES"))
    if entry is None:
        raise _NotFollowed("it has no Principled or Diffuse BSDF.")
    source = feeding_socket(entry)
    if source is None:
        return tuple(entry.default_value[:3])
    node = source.node
    if node.bl_idname == "ShaderNodeRGB":
        return tuple(source.default_value[:3])
    if node.bl_idname == "ShaderNodeTexImage" and node.image and node.projection == "FLAT" and source.name == "Color":
        uv = _corner_values(mesh, _uv_map(node, mesh), "vector", 2)[corners]
        return TexturePatch(triangles, uv, linear_pixels(node.image), _interpolation(node), node.extension)
    layer = _colour_layer(node, mesh) if source.name == "Color" else None
    if layer:
        return CornerColours(triangles, _corner_values(mesh, layer, "color", 4)[corners][..., :3])
    raise _NotFollowed(f"its colour comes from '{node.name}', which is not an image or a colour attribute.")


def _interpolation(node: bpy.types.Node) -> Interpolation:
    return "Closest" if node.interpolation == "Closest" else "Linear"


def _uv_map(node: bpy.types.Node, mesh: bpy.types.Mesh) -> str:
    """The UV map an Image Texture is looked up by."""
    active = next((layer.name for layer in mesh.uv_layers if layer.active_render), "")
    source = feeding_socket(node.inputs["Vector"])
    if source is None or (source.node.bl_idname == "ShaderNodeTexCoord" and source.name == "UV"):
        name = active
    elif source.node.bl_idname == "ShaderNodeUVMap":
        name = source.node.uv_map or active
    else:
        raise _NotFollowed(f"its texture is placed by '{source.node.name}', which is not a UV map.")
    if name not in mesh.attributes:
        raise _NotFollowed(f"mesh '{mesh.name}' lacks the UV map of its texture.")
    return str(name)


def _colour_layer(node: bpy.types.Node, mesh: bpy.types.Mesh) -> str | None:
    """The colour attribute that a node reads, if it is one and the mesh has it."""
    if node.bl_idname == "ShaderNodeVertexColor":
        name = node.layer_name or mesh.color_attributes.default_color_name
    elif node.bl_idname == "ShaderNodeAttribute" and node.attribute_type == "GEOMETRY":
        name = node.attribute_name
    else:
        return None
    return str(name) if name in mesh.color_attributes else None


def _corner_values(mesh: bpy.types.Mesh, layer: str, key: str, width: int) -> Float32:
    """(corners, width) of an attribute on points or corners."""
    attribute = mesh.attributes[layer]
    values = np.empty(len(attribute.data) * width, dtype=np.float32)
    attribute.data.foreach_get(key, values)
    values = values.reshape(-1, width)
    if attribute.domain == "CORNER":
        return values
    vertex = np.empty(len(mesh.loops), dtype=np.int32)
    mesh.loops.foreach_get("vertex_index", vertex)
    return values[vertex]
