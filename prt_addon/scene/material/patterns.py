# SPDX-License-Identifier: GPL-3.0-or-later
"""Follows an output of a node to what it gives on the triangles of a mesh: one value, an image texture, or an attribute."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import bpy
import numpy as np
import numpy.typing as npt

from ...core.arrays import Float32
from ...core.errors import PictureError
from ...core.files import digest
from ...core.notices import Notice
from ...core.surface import CornerColours, Interpolation, Pattern, TexturePatch
from ..blender.images import alpha_pixels, linear_pixels
from ..blender.light_path import DIFFUSE_RAY
from ..blender.nodes import feeding_socket, is_remapped, mapping_matrix
from ..mesh.meshes import corner_vertices, layer_array
from .reading import RGB, Colour, Inside, MaterialReading, Source, read_material

Dependencies = list[bytes | npt.NDArray[Any]]


class NotRead(Exception):
    """A colour that comes from nodes which are not read.

    Args:
        why: what is not read, to stand after a colon.
        colour: what could not be followed; None if it is the whole material.
    """

    def __init__(self, why: str, colour: Colour | None = None) -> None:
        super().__init__(why)
        self.colour = colour


@dataclass(frozen=True)
class ReadPattern:
    """A pattern, and all that it depends on, alike on all machines."""

    pattern: Pattern
    dependencies: Dependencies

    @classmethod
    def at_corners(cls, triangles: npt.NDArray[np.int64], colours: Float32) -> ReadPattern:
        """Values (P, 3, C) at the corners of triangles (P,)."""
        return cls(CornerColours(triangles, colours), [triangles, _either_way_round(colours)])

    @property
    def channels(self) -> int:
        """Of its values."""
        values = self.pattern.image if isinstance(self.pattern, TexturePatch) else self.pattern.colours
        return int(values.shape[-1])

    def mapped(self, change: Callable[[Float32], Float32], name: str) -> ReadPattern:
        """The same pattern of other values.

        Args:
            change: from (..., C) to (..., C'), the same everywhere and linear.
            name: what the change is known by.
        """
        pattern = self.pattern
        if isinstance(pattern, TexturePatch):
            return ReadPattern(replace(pattern, image=change(pattern.image)), [*self.dependencies, name.encode()])
        return ReadPattern(replace(pattern, colours=change(pattern.colours)), [*self.dependencies, name.encode()])


@dataclass(frozen=True)
class SurfaceValues:
    """What was read of one object's triangles: its albedo, or its opacity.

    constant: (T, C), one value a triangle.
    patterns: over some of them.
    notices: on what could not be followed, each with the name of its material.
    identity: digest of all of it.
    """

    constant: Float32
    patterns: list[Pattern]
    notices: list[Notice]
    identity: bytes

    @classmethod
    def of(cls, constant: Float32, patterns: Sequence[ReadPattern], notices: list[Notice]) -> SurfaceValues:
        """With the digest of the constants and of all that the patterns depend on."""
        dependencies = [source for one in patterns for source in one.dependencies]
        return cls(constant, [one.pattern for one in patterns], notices, digest(constant, *dependencies))


class PatternReader:
    """Reads materials and follows outputs of their nodes in one state of the scene.

    Each material is read and each texture decoded once, however many objects show it.
    """

    def __init__(self) -> None:
        self._readings: dict[str, MaterialReading] = {}
        self._textures: dict[tuple[str, str], tuple[Float32, bytes]] = {}

    def reading(self, material: bpy.types.Material) -> MaterialReading:
        """How a material looks to Cycles."""
        name = material.name_full
        if name not in self._readings:
            self._readings[name] = read_material(material, "CYCLES")
        return self._readings[name]

    def follow(
        self,
        colour: Colour,
        mesh: bpy.types.Mesh,
        corners: npt.NDArray[np.int32],
        triangles: npt.NDArray[np.int64],
    ) -> RGB | ReadPattern:
        """What a colour that is neither mixed nor constant gives.

        Args:
            colour: that was read of a material.
            mesh: that the triangles are of.
            corners: (P, 3) its face corners that the triangles have.
            triangles: (P,) their numbers.

        Raises:
            NotRead: if other nodes make it.
        """
        if not isinstance(colour, Source):
            where = f"lies in group '{colour.group.name}'" if isinstance(colour, Inside) else "is mixed of several"
            raise NotRead(f"its colour {where}", colour)
        source, node = colour.socket, colour.socket.node
        if node.bl_idname == "ShaderNodeRGB":
            return tuple(source.default_value[:3])
        if node.bl_idname == "ShaderNodeValue":
            return (float(source.default_value),) * 3
        if node.bl_idname == "ShaderNodeLightPath" and source.name != "Ray Length":
            return (DIFFUSE_RAY.get(source.name, 0.0),) * 3
        if _is_flat_picture(node):
            return self._picture(colour, source, mesh, corners, triangles)
        layer = _colour_layer(node, mesh) if source.name in {"Color", "Alpha"} else None
        if layer:
            channels = slice(3) if source.name == "Color" else slice(3, 4)
            return ReadPattern.at_corners(triangles, corner_values(mesh, layer, "color", 4)[corners][..., channels])
        raise NotRead(f"its colour comes from '{node.label or node.name}'", colour)

    def _picture(
        self,
        colour: Colour,
        source: bpy.types.NodeSocket,
        mesh: bpy.types.Mesh,
        corners: npt.NDArray[np.int32],
        triangles: npt.NDArray[np.int64],
    ) -> ReadPattern:
        node = source.node
        uv = _placed(*_uv_source(node, mesh, colour), corners)
        texels, identity = self._texture(node.image, source.name, colour)
        interpolation: Interpolation = "Closest" if node.interpolation == "Closest" else "Linear"
        way = f"{interpolation} {node.extension}".encode()
        patch = TexturePatch(triangles, uv, texels, interpolation, node.extension)
        return ReadPattern(patch, [triangles, _either_way_round(uv), way, identity])

    def _texture(self, image: bpy.types.Image, output: str, colour: Colour) -> tuple[Float32, bytes]:
        """The texels of an Image Texture's output, and the digest of them."""
        key = image.name_full, output
        if key not in self._textures:
            try:
                texels = linear_pixels(image) if output == "Color" else alpha_pixels(image)
            except PictureError as error:
                raise NotRead(
                    f"image '{image.name}' is not a single picture in sRGB or linear light", colour
                ) from error
            with np.errstate(over="ignore"):  # infinite is as white as 1
                half = texels.astype(np.float16)  # the last bits of decoded texels differ between processors
            self._textures[key] = texels, digest(half)
        return self._textures[key]


def corner_values(mesh: bpy.types.Mesh, layer: str, key: str, width: int) -> Float32:
    """(corners, width) of an attribute on points or corners."""
    values = layer_array(mesh, layer, key, width)
    if mesh.attributes[layer].domain == "CORNER":
        return values
    return values[corner_vertices(mesh)]


def _is_flat_picture(node: bpy.types.Node) -> bool:
    """Whether a node is an Image Texture laid out by coordinates, whose colours nothing changes."""
    return bool(
        node.bl_idname == "ShaderNodeTexImage" and node.image and node.projection == "FLAT" and not is_remapped(node)
    )


def _either_way_round(corners: npt.NDArray[Any]) -> bytes:
    """Digest of values at the three corners of triangles, which are read the other way round where mirrored."""
    return min(digest(corners), digest(corners[:, ::-1]))


def _uv_source(node: bpy.types.Node, mesh: bpy.types.Mesh, colour: Colour) -> tuple[Float32, bpy.types.Node | None]:
    """The (corners, 2) UV map that an Image Texture is looked up by, and the Mapping node between, if there is one."""
    active = next((layer.name for layer in mesh.uv_layers if layer.active_render), "")
    source = feeding_socket(node.inputs["Vector"])
    mapping = None
    if source and source.node.bl_idname == "ShaderNodeMapping" and _is_plain(source.node):
        mapping = source.node
        source = feeding_socket(mapping.inputs["Vector"])
        if source is None:
            raise NotRead(f"its texture is placed by '{mapping.name}' alone", colour)
    if source is None or (source.node.bl_idname == "ShaderNodeTexCoord" and source.name == "UV"):
        name = active
    elif source.node.bl_idname == "ShaderNodeUVMap" and not source.node.from_instancer:
        name = source.node.uv_map or active
    else:
        raise NotRead(f"its texture is placed by '{source.node.name}'", colour)
    if name not in mesh.attributes:
        raise NotRead(f"mesh '{mesh.name}' lacks the UV map of its texture", colour)
    return corner_values(mesh, str(name), "vector", 2), mapping


def _is_plain(mapping: bpy.types.Node) -> bool:
    """Whether a Mapping node maps by numbers: nothing else feeds it."""
    return mapping.vector_type != "NORMAL" and not any(
        feeding_socket(entry) for entry in mapping.inputs if entry.name != "Vector"
    )


def _placed(uv: Float32, mapping: bpy.types.Node | None, corners: npt.NDArray[np.int32]) -> Float32:
    """(P, 3, 2) coordinates at the corners of triangles, moved as a Mapping node of numbers does."""
    found = uv[corners]
    if mapping is None:
        return found
    matrix, offset = mapping_matrix(mapping)
    points = np.concatenate([found, np.zeros((*found.shape[:2], 1), dtype=np.float32)], axis=-1).astype(np.float64)
    return np.ascontiguousarray((points @ matrix.T + offset)[..., :2], dtype=np.float32)


def _colour_layer(node: bpy.types.Node, mesh: bpy.types.Mesh) -> str | None:
    """The colour attribute that a node reads, if it is one and the mesh has it."""
    if node.bl_idname == "ShaderNodeVertexColor":
        name = node.layer_name or mesh.color_attributes.default_color_name
    elif node.bl_idname == "ShaderNodeAttribute" and node.attribute_type == "GEOMETRY":
        name = node.attribute_name
    else:
        return None
    return str(name) if name in mesh.color_attributes else None
