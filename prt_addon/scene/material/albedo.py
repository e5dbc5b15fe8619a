# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials to albedo: what light takes on where it bounces.

The colour is that of the `reading`: a constant, an image texture or a colour attribute. One that comes from other
nodes, or is mixed of several, is evaluated by Cycles at the vertices, which is said; where that is impossible the viewport
colour stands in, which is said, too.
"""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np
import numpy.typing as npt

from ...core.errors import PictureError
from ...core.surface import AlbedoPattern, CornerColours, Interpolation, TexturePatch
from ..blender.images import linear_pixels
from ..blender.nodes import feeding_socket, has_loop
from ..mesh.meshes import Surface, corner_vertices, layer_array
from .cycles_colour import Unread, corner_colours
from .reading import BLACK, Colour, Constant, Inside, Source, read_material

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
    """A colour that comes from nodes which are not read.

    Args:
        why: what is not read, to stand after a colon.
        colour: what could not be followed; None if it is the whole material.
        shown: whether Cycles would show it; it shows missing images in pink.
    """

    def __init__(self, why: str, colour: Colour | None = None, shown: bool = True) -> None:
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
    shown = {
        index: Unread(materials[index], reason.colour)
        for index, reason in unread.items()
        if reason.shown and not has_loop(materials[index].node_tree)
    }
    colours = corner_colours(ob, matrix, shown) if shown else None
    patterns: list[AlbedoPattern] = []
    warnings = []
    for index, reason in unread.items():
        name = materials[index].name
        if colours is None or index not in shown:
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
    reading = read_material(material, "CYCLES")
    colour = reading.colour
    if colour is None and not reading.why_not:
        return BLACK.rgb
    if colour is None:
        raise _NotFollowed(reading.why_not)
    if isinstance(colour, Constant):
        return colour.rgb
    if not isinstance(colour, Source):
        where = f"lies in group '{colour.group.name}'" if isinstance(colour, Inside) else "is mixed of several"
        raise _NotFollowed(f"its colour {where}", colour)
    source, node = colour.socket, colour.socket.node
    if node.bl_idname == "ShaderNodeRGB":
        return tuple(source.default_value[:3])
    if node.bl_idname == "ShaderNodeTexImage" and node.image and node.projection == "FLAT" and source.name == "Color":
        uv = _corner_values(mesh, _uv_map(node, mesh, colour), "vector", 2)[corners]
        return TexturePatch(triangles, uv, _texels(node.image, colour), _interpolation(node), node.extension)
    layer = _colour_layer(node, mesh) if source.name == "Color" else None
    if layer:
        return CornerColours(triangles, _corner_values(mesh, layer, "color", 4)[corners][..., :3])
    why = f"its colour comes from '{node.label or node.name}'"
    raise _NotFollowed(why, colour)


def _texels(image: bpy.types.Image, colour: Colour) -> Float32:
    try:
        return linear_pixels(image)
    except PictureError as error:
        there = all(image.size)
        why = f"image '{image.name}' is not a single picture in sRGB or linear light" if there else str(error)
        raise _NotFollowed(why.rstrip("."), colour, shown=there) from error


def _interpolation(node: bpy.types.Node) -> Interpolation:
    return "Closest" if node.interpolation == "Closest" else "Linear"


def _uv_map(node: bpy.types.Node, mesh: bpy.types.Mesh, colour: Colour) -> str:
    """The UV map an Image Texture is looked up by."""
    active = next((layer.name for layer in mesh.uv_layers if layer.active_render), "")
    source = feeding_socket(node.inputs["Vector"])
    if source is None or (source.node.bl_idname == "ShaderNodeTexCoord" and source.name == "UV"):
        name = active
    elif source.node.bl_idname == "ShaderNodeUVMap":
        name = source.node.uv_map or active
    else:
        raise _NotFollowed(f"its texture is placed by '{source.node.name}'", colour)
    if name not in mesh.attributes:
        raise _NotFollowed(f"mesh '{mesh.name}' lacks the UV map of its texture", colour)
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
