# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials to albedo: what light takes on where it bounces.

The diffuse colour of a material is read from its own nodes: a constant, an image texture or a colour attribute. A
colour that comes from other nodes, and a material of several shaders, is evaluated by Cycles at the vertices, which is
said; where that is impossible the viewport colour stands in, which is said, too.

Transport is diffuse and opaque, whichever way the colour is found. A metal bounces its base colour as if it were matte,
glass likewise; in materials of several shaders the colours of all reflections add up. Alpha and Transparent BSDFs are
ignored: what is half transparent blocks light, and bounces it, like a whole surface. Light that materials emit does
not take part.
"""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np
import numpy.typing as npt

from ..core.albedo import AlbedoPattern, CornerColours, Interpolation, TexturePatch
from ..core.errors import PictureError
from .cycles_colour import Unread, corner_colours
from .images import linear_pixels
from .meshes import Surface, corner_vertices, layer_array
from .nodes import diffuse_colour, feeding_socket, upstream, uses_nodes

Float32 = npt.NDArray[np.float32]

DEFAULT_COLOUR = (0.8, 0.8, 0.8)
"""Of surfaces without a material, as Blender shows them."""


@dataclass(frozen=True)
class SurfaceAlbedo:
    """Albedo of one object's triangles: constants (T, 3), patterns over some of them, and what could not be followed."""

    constant: Float32
    patterns: list[AlbedoPattern]
    warnings: list[str]


_NO_REFLECTION = {
    "ShaderNodeAddShader",
    "ShaderNodeBsdfTransparent",
    "ShaderNodeEmission",
    "ShaderNodeHoldout",
    "ShaderNodeMixShader",
}
"""Shaders that have no colour to bounce themselves."""


class _NotFollowed(Exception):
    """A colour that comes from nodes which are not read.

    Args:
        why: what is not read, to stand after a colon.
        colour: the colour input that could not be followed; None if it is the whole material.
        shown: whether Cycles would show it; it shows missing images in pink.
    """

    def __init__(self, why: str, colour: bpy.types.NodeSocket | None = None, shown: bool = True) -> None:
        super().__init__(why)
        self.colour, self.shown = colour, shown


def read_albedo(
    ob: bpy.types.Object, mesh: bpy.types.Mesh, surface: Surface, matrix: npt.NDArray[np.float64]
) -> SurfaceAlbedo:
    """Albedo of an evaluated object's surface, material slot by material slot.

    Args:
        mesh: of the object.
        surface: of the mesh.
        matrix: (4, 4) where it stands; an instance's object does not know.
    """
    constant = np.empty((len(surface.triangles), 3), dtype=np.float32)
    constant[:] = DEFAULT_COLOUR
    patterns: list[AlbedoPattern] = []
    unread: dict[int, _NotFollowed] = {}
    slots = [slot.material for slot in ob.material_slots]
    used = {int(index): slots[min(index, len(slots) - 1)] for index in np.unique(surface.material) if slots}
    for index, material in used.items():
        if material is None:
            continue
        triangles = np.flatnonzero(surface.material == index)
        try:
            found = _material_albedo(material, mesh, surface.corners[triangles], triangles)
        except _NotFollowed as reason:
            unread[index] = reason
            found = tuple(material.diffuse_color[:3])
        if isinstance(found, tuple):
            constant[triangles] = found
        else:
            patterns.append(found)
    evaluated, warnings = _evaluate(ob, surface, matrix, used, unread)
    return SurfaceAlbedo(constant, patterns + evaluated, warnings)


def _evaluate(
    ob: bpy.types.Object,
    surface: Surface,
    matrix: npt.NDArray[np.float64],
    materials: dict[int, bpy.types.Material],
    unread: dict[int, _NotFollowed],
) -> tuple[list[AlbedoPattern], list[str]]:
    """What Cycles makes of the slots that could not be read, and a sentence on each."""
    shown = {index: Unread(materials[index], reason.colour) for index, reason in unread.items() if reason.shown}
    colours = corner_colours(ob, matrix, shown) if shown else None
    patterns: list[AlbedoPattern] = []
    warnings = []
    for index, reason in unread.items():
        name = materials[index].name
        if colours is None or not reason.shown:
            warnings.append(f"Material '{name}': {reason}; light takes on its viewport colour.")
            continue
        triangles = np.flatnonzero(surface.material == index)
        patterns.append(CornerColours(triangles, colours[surface.corners[triangles]]))
        warnings.append(f"Material '{name}': {reason}; Cycles evaluated it at the vertices.")
    return patterns, warnings


def _material_albedo(
    material: bpy.types.Material, mesh: bpy.types.Mesh, corners: npt.NDArray[np.int32], triangles: npt.NDArray[np.int64]
) -> tuple[float, ...] | AlbedoPattern:
    """One colour, or a pattern over the triangles."""
    if not uses_nodes(material):
        return tuple(material.diffuse_color[:3])
    output = material.node_tree.get_output_node("CYCLES")
    entry = diffuse_colour(output)
    if entry is None:
        raise _NotFollowed("it has no Principled or Diffuse BSDF", shown=output is not None)
    if len(_reflecting(output)) > 1:
        raise _NotFollowed(f"it is made of {len(_reflecting(output))} shaders")
    source = feeding_socket(entry)
    if source is None:
        return tuple(entry.default_value[:3])
    node = source.node
    if node.bl_idname == "ShaderNodeRGB":
        return tuple(source.default_value[:3])
    if node.bl_idname == "ShaderNodeTexImage" and node.image and node.projection == "FLAT" and source.name == "Color":
        uv = _corner_values(mesh, _uv_map(node, mesh, entry), "vector", 2)[corners]
        return TexturePatch(triangles, uv, _texels(node.image, entry), _interpolation(node), node.extension)
    layer = _colour_layer(node, mesh) if source.name == "Color" else None
    if layer:
        return CornerColours(triangles, _corner_values(mesh, layer, "color", 4)[corners][..., :3])
    raise _NotFollowed(f"its colour comes from '{node.label or node.name}'", entry)


def _reflecting(output: bpy.types.Node) -> list[bpy.types.Node]:
    """The shaders, or groups of them, behind a Material Output that may reflect light."""
    shaders = [node for node in upstream(output) if any(socket.type == "SHADER" for socket in node.outputs)]
    return [node for node in shaders if node.bl_idname not in _NO_REFLECTION]


def _texels(image: bpy.types.Image, entry: bpy.types.NodeSocket) -> Float32:
    try:
        return linear_pixels(image)
    except PictureError as error:
        there = all(image.size)
        why = f"image '{image.name}' is not a single picture in sRGB or linear light" if there else str(error)
        raise _NotFollowed(why.rstrip("."), entry, shown=there) from error


def _interpolation(node: bpy.types.Node) -> Interpolation:
    return "Closest" if node.interpolation == "Closest" else "Linear"


def _uv_map(node: bpy.types.Node, mesh: bpy.types.Mesh, entry: bpy.types.NodeSocket) -> str:
    """The UV map an Image Texture is looked up by."""
    active = next((layer.name for layer in mesh.uv_layers if layer.active_render), "")
    source = feeding_socket(node.inputs["Vector"])
    if source is None or (source.node.bl_idname == "ShaderNodeTexCoord" and source.name == "UV"):
        name = active
    elif source.node.bl_idname == "ShaderNodeUVMap":
        name = source.node.uv_map or active
    else:
        raise _NotFollowed(f"its texture is placed by '{source.node.name}'", entry)
    if name not in mesh.attributes:
        raise _NotFollowed(f"mesh '{mesh.name}' lacks the UV map of its texture", entry)
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
    values = layer_array(mesh, layer, key, width)
    if mesh.attributes[layer].domain == "CORNER":
        return values
    return values[corner_vertices(mesh)]
