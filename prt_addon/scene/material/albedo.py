# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads the albedo of materials: the colour that light takes on where it bounces.

The colour is that of the `reading`: a constant, an image texture or a colour attribute. One that comes from other
nodes, or is mixed of several, is evaluated by Cycles at the vertices, which is said; where that is impossible the viewport
colour stands in, which is said, too.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import bpy
import numpy as np
import numpy.typing as npt

from ...core.errors import PictureError
from ...core.files import digest
from ...core.notices import Kind, Notice
from ...core.surface import AlbedoPattern, CornerColours, Interpolation, TexturePatch
from ..blender.images import linear_pixels
from ..blender.nodes import feeding_socket, has_loop, is_remapped, mapping_matrix
from ..mesh.meshes import Surface, corner_vertices, layer_array
from .cycles_colour import ColourRequest, ColourRequests, Unread
from .lost_pictures import why_not_shown
from .reading import BLACK, Colour, Constant, Inside, Source, read_material

Float32 = npt.NDArray[np.float32]

DEFAULT_COLOUR = (0.8, 0.8, 0.8)
"""Of surfaces without a material, as Blender shows them."""


@dataclass(frozen=True)
class SurfaceAlbedo:
    """Albedo of one object's triangles: constants (T, 3), patterns over some of them, and what could not be read.

    notices: each with the name of its material.
    identity: digest of all that light takes on.
    """

    constant: Float32
    patterns: list[AlbedoPattern]
    notices: list[Notice]
    identity: bytes


_EVALUATED = Kind(
    "Material {name}: {why}; Cycles evaluated it at the vertices.",
    "{count} materials have colours from nodes that are not read: Cycles evaluated them at the vertices ({names}).",
    "INFO",
)
_GUESSED = Kind(
    "Material {name}: {why}; light takes on its viewport colour.",
    "{count} materials have colours that cannot be evaluated: light takes on their viewport colours ({names}).",
)
_LOST = Kind(
    _GUESSED.one,
    "{count} materials have lost their pictures, so that light takes on their viewport colours: find them with File > "
    "External Data > Find Missing Files ({names}).",
)


class _NotFollowed(Exception):
    """A colour that comes from nodes which are not read.

    Args:
        why: what is not read, to stand after a colon.
        colour: what could not be followed; None if it is the whole material.
    """

    def __init__(self, why: str, colour: Colour | None = None) -> None:
        super().__init__(why)
        self.colour = colour


@dataclass(frozen=True)
class _Texture:
    """A decoded picture, and the digest of it."""

    texels: Float32
    identity: bytes


class AlbedoReader:
    """Reads albedo of one state of the scene: each texture once, and as far as materials can be read.

    The rest waits for Cycles, which cannot work while another render goes on: `AlbedoDraft.complete` has it evaluated. Close the
    reader after that.
    """

    def __init__(self) -> None:
        self._requests = ColourRequests()
        self._textures: dict[str, _Texture] = {}

    def __enter__(self) -> AlbedoReader:
        return self

    def __exit__(self, *_: object) -> None:
        self._requests.close()

    def read(
        self, ob: bpy.types.Object, mesh: bpy.types.Mesh, surface: Surface, matrix: npt.NDArray[np.float64]
    ) -> AlbedoDraft:
        """Albedo of an evaluated object's surface, material slot by material slot.

        Args:
            mesh: of the object.
            surface: of the mesh.
            matrix: (4, 4) where it stands; an instance's object does not know.
        """
        draft = AlbedoDraft(np.empty((len(surface.triangles), 3), dtype=np.float32), surface)
        draft.constant[:] = DEFAULT_COLOUR
        for index, material in used_materials(ob, mesh, surface).items():
            if material is not None:
                self._read_slot(draft, index, material, mesh)
        shown = {
            index: Unread(reason.material, reason.colour)
            for index, reason in draft.unread.items()
            if reason.shown and not has_loop(reason.material.node_tree)
        }
        if shown:
            draft.shown = set(shown)
            draft.request = self._requests.add(ob, matrix, shown)
        return draft

    def _read_slot(self, draft: AlbedoDraft, index: int, material: bpy.types.Material, mesh: bpy.types.Mesh) -> None:
        triangles = np.flatnonzero(draft.surface.material == index)
        corners = draft.surface.corners[triangles]
        try:
            found = self._material_albedo(material, mesh, corners, triangles, draft)
        except _NotFollowed as reason:
            lost = why_not_shown(material, reason.colour)
            draft.unread[index] = _Unfollowed(material, lost or str(reason), reason.colour, not lost)
            found = tuple(material.diffuse_color[:3])
        if isinstance(found, tuple):
            draft.constant[triangles] = found
        else:
            draft.patterns.append(found)

    def _material_albedo(
        self,
        material: bpy.types.Material,
        mesh: bpy.types.Mesh,
        corners: npt.NDArray[np.int32],
        triangles: npt.NDArray[np.int64],
        draft: AlbedoDraft,
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
        if _is_flat_picture(source):
            uv = _placed(*_uv_source(node, mesh, colour), corners)
            texture = self._texture(node.image, colour)
            draft.textures.append(texture.identity)
            return TexturePatch(triangles, uv, texture.texels, _interpolation(node), node.extension)
        layer = _colour_layer(node, mesh) if source.name == "Color" else None
        if layer:
            return CornerColours(triangles, _corner_values(mesh, layer, "color", 4)[corners][..., :3])
        raise _NotFollowed(f"its colour comes from '{node.label or node.name}'", colour)

    def _texture(self, image: bpy.types.Image, colour: Colour) -> _Texture:
        """Decoded once, however many objects show it."""
        known = self._textures.get(image.name_full)
        if known is None:
            texels = _texels(image, colour)
            with np.errstate(over="ignore"):  # infinite is as white as 1
                half = texels.astype(np.float16)  # the last bits of decoded texels differ between processors
            known = self._textures[image.name_full] = _Texture(texels, digest(half))
        return known


@dataclass(frozen=True)
class _Unfollowed:
    """What could not be read of a material, and why. Not shown: Cycles cannot show it either, as a picture is lost."""

    material: bpy.types.Material
    why: str
    colour: Colour | None
    shown: bool


@dataclass
class AlbedoDraft:
    """What was read of a surface's albedo, and what still waits for Cycles, by material slot.

    textures: digests of the pictures of texture patches, in their order.
    shown: the unread slots that Cycles evaluates.
    """

    constant: Float32
    surface: Surface
    patterns: list[AlbedoPattern] = field(default_factory=list)
    textures: list[bytes] = field(default_factory=list)
    unread: dict[int, _Unfollowed] = field(default_factory=dict)
    shown: set[int] = field(default_factory=set)
    request: ColourRequest | None = None

    def complete(self) -> SurfaceAlbedo:
        """Have Cycles evaluate what is left; to be called once nothing renders any more."""
        colours = self.request.corner_colours() if self.request else None
        notices = []
        for index, one in self.unread.items():
            evaluated = colours is not None and index in self.shown
            kind = _EVALUATED if evaluated else _GUESSED if one.shown else _LOST
            notices.append(Notice(kind, one.material.name, {"why": one.why}))
            if colours is not None and evaluated:
                triangles = np.flatnonzero(self.surface.material == index)
                self.patterns.append(CornerColours(triangles, colours[self.surface.corners[triangles]]))
        return SurfaceAlbedo(self.constant, self.patterns, notices, digest(*self._sources()))

    def _sources(self) -> Iterator[bytes | npt.NDArray[Any]]:
        """All that light takes on."""
        textures = iter(self.textures)
        yield self.constant
        for pattern in self.patterns:
            yield pattern.triangles
            if isinstance(pattern, TexturePatch):
                yield _either_way_round(pattern.uv)
                yield f"{pattern.interpolation} {pattern.extension}".encode()
                yield next(textures)
            else:
                yield _either_way_round(pattern.colours)


def used_materials(
    ob: bpy.types.Object, mesh: bpy.types.Mesh, surface: Surface
) -> dict[int, bpy.types.Material | None]:
    """The original material of each slot that an evaluated object's surface shows.

    A node modifier may have set them: then they are the mesh's, and the object has no slot of its own for them.
    """
    slots = [slot.material for slot in ob.material_slots]
    materials = slots + list(mesh.materials)[len(slots) :]
    if not materials:
        return {}
    used = {int(index): materials[min(max(index, 0), len(materials) - 1)] for index in np.unique(surface.material)}
    return {index: material and material.original for index, material in used.items()}


def _either_way_round(corners: npt.NDArray[Any]) -> bytes:
    """Digest of values at the three corners of triangles, which are read the other way round where mirrored."""
    return min(digest(corners), digest(corners[:, ::-1]))


def _texels(image: bpy.types.Image, colour: Colour) -> Float32:
    try:
        return linear_pixels(image)
    except PictureError as error:
        raise _NotFollowed(f"image '{image.name}' is not a single picture in sRGB or linear light", colour) from error


def _interpolation(node: bpy.types.Node) -> Interpolation:
    return "Closest" if node.interpolation == "Closest" else "Linear"


def _uv_source(node: bpy.types.Node, mesh: bpy.types.Mesh, colour: Colour) -> tuple[Float32, bpy.types.Node | None]:
    """The (corners, 2) UV map that an Image Texture is looked up by, and the Mapping node between, if there is one."""
    active = next((layer.name for layer in mesh.uv_layers if layer.active_render), "")
    source = feeding_socket(node.inputs["Vector"])
    mapping = None
    if source and source.node.bl_idname == "ShaderNodeMapping" and _is_plain(source.node):
        mapping = source.node
        source = feeding_socket(mapping.inputs["Vector"])
        if source is None:
            raise _NotFollowed(f"its texture is placed by '{mapping.name}' alone", colour)
    if source is None or (source.node.bl_idname == "ShaderNodeTexCoord" and source.name == "UV"):
        name = active
    elif source.node.bl_idname == "ShaderNodeUVMap" and not source.node.from_instancer:
        name = source.node.uv_map or active
    else:
        raise _NotFollowed(f"its texture is placed by '{source.node.name}'", colour)
    if name not in mesh.attributes:
        raise _NotFollowed(f"mesh '{mesh.name}' lacks the UV map of its texture", colour)
    return _corner_values(mesh, str(name), "vector", 2), mapping


def _is_flat_picture(source: bpy.types.NodeSocket) -> bool:
    """Whether an output is the colour of a picture that is laid flat over the mesh, by a UV map and nothing else."""
    node = source.node
    return (
        node.bl_idname == "ShaderNodeTexImage"
        and node.image is not None
        and node.projection == "FLAT"
        and source.name == "Color"
        and not is_remapped(node)
    )


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


def _corner_values(mesh: bpy.types.Mesh, layer: str, key: str, width: int) -> Float32:
    """(corners, width) of an attribute on points or corners."""
    values = layer_array(mesh, layer, key, width)
    if mesh.attributes[layer].domain == "CORNER":
        return values
    return values[corner_vertices(mesh)]
