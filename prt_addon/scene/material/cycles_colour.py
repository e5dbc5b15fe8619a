# SPDX-License-Identifier: GPL-3.0-or-later
"""Has Cycles evaluate materials whose nodes we do not read: their colours at the corners of a mesh.

Blender's own colour bake runs on a copy of the evaluated mesh, alone in a scene of its own (see `cycles_scene`).

Where the colour of one shader is wanted, a copy of the material shows it as a Diffuse BSDF, so that metallic,
specular and alpha do not change it. Else the whole material is evaluated: the colours of its diffuse and of its glossy
reflection are added, because the first of a metal is black, and divided by its opacity.

Limits: Generated coordinates are those of the evaluated mesh, Object Info's Random differs, and nodes that look at
other objects (Ambient Occlusion, Bevel) find none.

One evaluation takes some hundredths of a second at least, as Blender sets up a render for it. A thousand instances of
one thing are therefore evaluated once, unless a node of its materials may depend on its place.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np
import numpy.typing as npt

from ...core.arrays import Float32
from ..blender.cycles_scene import cycles_scene, selected_alone
from ..blender.light_path import answer_light_path, reads_light_path
from ..blender.rna import plain_properties
from ..mesh.meshes import layer_array
from .colour_nodes import connect, remove_parts
from .reading import Colour

_LAYER = "prt_cycles_colour"

_DEPEND_ON_PLACE = {
    "ShaderNodeAmbientOcclusion",
    "ShaderNodeAttribute",
    "ShaderNodeBevel",
    "ShaderNodeCameraData",
    "ShaderNodeHairInfo",
    "ShaderNodeNewGeometry",
    "ShaderNodeObjectInfo",
    "ShaderNodeParticleInfo",
    "ShaderNodePointInfo",
    "ShaderNodeScript",
    "ShaderNodeVectorTransform",
    "ShaderNodeWireframe",
}
"""Nodes whose value may be another for another instance."""


@dataclass(frozen=True)
class Unread:
    """A material that Cycles is to evaluate; `colour` is the colour that is wanted of it, None for the whole material."""

    material: bpy.types.Material
    colour: Colour | None = None


class CyclesRequest(ABC):
    """A mesh that waits for Cycles: a copy, as the object it was evaluated for may be gone by then."""

    def __init__(self, ob: bpy.types.Object, matrix: npt.NDArray[np.float64], slots: Mapping[int, Unread]) -> None:
        self._mesh = bpy.data.meshes.new_from_object(ob)
        self._matrix, self._slots = matrix, slots
        self._colour, self._pass_index, self._properties = tuple(ob.color), ob.pass_index, plain_properties(ob)
        self._answer: Any = None
        self._asked = False

    def answer(self) -> Any:
        """What Cycles finds, of the subclass's kind; None if Blender cannot bake now: Cycles is disabled, or the context forbids it."""
        if not self._asked:
            self._asked, self._answer = True, self._evaluated()
        return self._answer

    def close(self) -> None:
        """Remove the copy."""
        bpy.data.meshes.remove(self._mesh)

    @abstractmethod
    def _baked(self, mesh: bpy.types.Mesh) -> Any:
        """Bake the mesh, whose object stands alone in a scene of Cycles and is active."""

    def _evaluated(self) -> Any:
        mesh, slots = self._mesh, self._slots
        copies: list[bpy.types.Material] = []
        groups: list[bpy.types.NodeTree] = []
        try:
            while len(mesh.materials) <= max(slots):
                mesh.materials.append(None)
            for index in range(len(mesh.materials)):
                unread = slots.get(index)
                mesh.materials[index] = _as_bounced(unread, copies, groups) if unread else None
            with cycles_scene("PRT Colours") as scene, selected_alone(scene, mesh) as stand_in:
                stand_in.matrix_world = self._matrix.T.tolist()  # bpy wants columns
                stand_in.color, stand_in.pass_index = self._colour, self._pass_index
                for name, value in self._properties.items():
                    stand_in[name] = value
                return self._baked(mesh)
        except (RuntimeError, TypeError):  # the operator refuses; the engine is not registered
            return None
        finally:
            for copy in copies:
                remove_parts(copy.node_tree)
                bpy.data.materials.remove(copy)
            bpy.data.batch_remove(groups)


class ColourRequest(CyclesRequest):
    """Answers with (corners, 3) linear colours on faces of the material slots; those of other faces mean nothing."""

    def _baked(self, mesh: bpy.types.Mesh) -> Float32:
        diffuse = _pass_at_corners(mesh, "DIFFUSE")
        whole = any(unread.colour is None for unread in self._slots.values())
        glossy = _pass_at_corners(mesh, "GLOSSY") if whole else np.zeros_like(diffuse)
        opacity = diffuse[:, 3:]
        opaque = np.where(opacity > 0.0, opacity, np.float32(1.0))
        colour: Float32 = (diffuse[:, :3] + glossy[:, :3]) / opaque
        return colour


class CyclesRequests:
    """All requests of one state of the scene. What looks the same everywhere is evaluated once, for all of its instances.

    Args:
        kind: of request.
    """

    def __init__(self, kind: type[CyclesRequest]) -> None:
        self._kind = kind
        self._requests: list[CyclesRequest] = []
        self._shared: dict[object, CyclesRequest] = {}

    def add(self, ob: bpy.types.Object, matrix: npt.NDArray[np.float64], slots: Mapping[int, Unread]) -> CyclesRequest:
        """For an evaluated object's mesh under a (4, 4) matrix.

        Args:
            ob: the evaluated object.
            matrix: (4, 4) where it stands.
            slots: which material slots, and their materials.
        """
        key = _key(ob, slots)
        if key in self._shared:
            return self._shared[key]
        request = self._kind(ob, matrix, slots)
        self._requests.append(request)
        if key:
            self._shared[key] = request
        return request

    def close(self) -> None:
        """Remove all that the requests left in the file."""
        for request in self._requests:
            request.close()
        self._requests.clear()
        self._shared.clear()


def _key(ob: bpy.types.Object, slots: Mapping[int, Unread]) -> object:
    """By what an instance is recognised; None if a node may depend on its place."""
    if not all(_same_everywhere(unread.material.node_tree) for unread in slots.values()):
        return None
    wanted = tuple((index, unread.material.name_full, unread.colour is None) for index, unread in slots.items())
    return ob.data.as_pointer(), len(ob.data.loops), len(ob.data.polygons), wanted


def _same_everywhere(tree: bpy.types.NodeTree | None) -> bool:
    """Whether no node of a tree may depend on the object's place."""
    for node in tree.nodes if tree else ():
        if node.bl_idname in _DEPEND_ON_PLACE:
            return False
        if node.bl_idname == "ShaderNodeTexCoord" and (
            node.object or any(node.outputs[name].is_linked for name in ("Camera", "Window", "Reflection"))
        ):
            return False
        if node.bl_idname == "ShaderNodeGroup" and not _same_everywhere(node.node_tree):
            return False
    return True


def _as_bounced(
    unread: Unread, copies: list[bpy.types.Material], groups: list[bpy.types.NodeTree]
) -> bpy.types.Material:
    """A material as light sees it that bounces; copies that this takes are noted."""
    by_path = unread.material.node_tree and reads_light_path(unread.material.node_tree)
    if not unread.colour and not by_path:
        return unread.material
    copy = _matte_copy(unread.material, unread.colour) if unread.colour else unread.material.copy()
    copies.append(copy)
    if by_path:
        answer_light_path(copy.node_tree, groups)
    return copy


def _matte_copy(material: bpy.types.Material, colour: Colour) -> bpy.types.Material:
    """A copy of a material whose surface is a Diffuse BSDF of a colour that was read of it."""
    copy = material.copy()
    tree = copy.node_tree
    shader = tree.nodes.new("ShaderNodeBsdfDiffuse")
    connect(tree, colour, shader.inputs["Color"])
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    output.target, output.is_active_output = "CYCLES", True
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    return copy


def _pass_at_corners(mesh: bpy.types.Mesh, kind: str) -> Float32:
    """(corners, 4) a colour pass of the active object, whose mesh this is."""
    if _LAYER not in mesh.attributes:
        mesh.attributes.new(_LAYER, "FLOAT_COLOR", "CORNER")
    mesh.color_attributes.active_color_name = _LAYER
    bpy.ops.object.bake(type=kind, pass_filter={"COLOR"}, target="VERTEX_COLORS", use_clear=True)
    return layer_array(mesh, _LAYER, "color", 4)
