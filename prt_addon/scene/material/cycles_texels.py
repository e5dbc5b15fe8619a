# SPDX-License-Identifier: GPL-3.0-or-later
"""Has Cycles evaluate materials whose nodes we do not read, all over the faces of a mesh: a picture of them.

Each face gets a square of the picture to itself, so that it does not matter how the mesh is unwrapped. The more faces, the
coarser.
"""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np
import numpy.typing as npt

from ...core.arrays import Float32
from ..blender.images import linear_pixels
from ..mesh.meshes import face_starts, index_array
from .cycles_colour import CyclesRequest

_TEXELS = 1 << 20
"""Of the whole picture, about."""

_LEAST, _MOST = 4, 512
"""Texels along the side of a square."""

_EDGE = 1.0
"""Texels between a square's border and the face in it, which the bake fills."""

_UV = "prt_squares"


@dataclass(frozen=True)
class FacePicture:
    """A picture of a mesh's faces.

    uv: (corners, 2) float32, where each face corner lies in it.
    texels: (H, W, 3) float32, row 0 at the bottom.
    """

    uv: Float32
    texels: Float32


class TexelRequest(CyclesRequest):
    """Answers with a `FacePicture` of the faces of the material slots; those of other faces mean nothing."""

    def _baked(self, mesh: bpy.types.Mesh) -> FacePicture:
        wanted = np.isin(index_array(mesh.polygons, "material_index"), list(self._slots))
        uv, size = _squares(face_starts(mesh), len(mesh.loops), wanted)
        layer = mesh.uv_layers.new(name=_UV, do_init=False)
        if layer is None:
            raise RuntimeError("The mesh has no room for a UV map.")
        layer.uv.foreach_set("vector", uv.ravel())
        image = bpy.data.images.new(_UV, size, size, float_buffer=True, is_data=True)
        others = bpy.data.materials.new(_UV)
        try:
            for index, material in enumerate(mesh.materials):
                if material is None:
                    mesh.materials[index] = others
            for material in {*mesh.materials}:
                _aim_at(material, image)
            bpy.ops.object.bake(
                type="DIFFUSE", pass_filter={"COLOR"}, target="IMAGE_TEXTURES", uv_layer=layer.name, margin=2
            )
            return FacePicture(uv, linear_pixels(image))
        finally:
            bpy.data.materials.remove(others)
            bpy.data.images.remove(image)


def _squares(starts: npt.NDArray[np.int32], corners: int, wanted: npt.NDArray[np.bool_]) -> tuple[Float32, int]:
    """(corners, 2) coordinates that give each wanted face a square, its corners on a circle in it; and texels along a side.

    A polygon's triangles do not overlap there, as they do not in the polygon. Other faces shrink to a point.
    """
    columns = max(1, int(np.ceil(np.sqrt(wanted.sum()))))
    side = int(np.clip(np.sqrt(_TEXELS) / columns, _LEAST, _MOST))
    counts = np.diff(np.append(starts, corners))
    face = np.repeat(np.arange(len(starts)), counts)
    turn = 2.0 * np.pi * (np.arange(corners) - starts[face]) / counts[face]
    circle = np.stack([np.cos(turn), np.sin(turn)], axis=-1) * (side / 2.0 - _EDGE)
    row, column = np.divmod(np.cumsum(wanted) - 1, columns)
    centre = (np.stack([column, row], axis=-1) + 0.5) * side
    texels = np.where(wanted[face, None], centre[face] + circle, 0.0)
    return (texels / (columns * side)).astype(np.float32), columns * side


def _aim_at(material: bpy.types.Material, image: bpy.types.Image) -> None:
    """Have a bake of a material fill an image."""
    if material.node_tree is None:
        material.use_nodes = True  # before 5.0
    node = material.node_tree.nodes.new("ShaderNodeTexImage")
    node.image = image
    material.node_tree.nodes.active = node
