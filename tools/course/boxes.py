# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds the course's boxes: three on a floor before a wall, one mesh whose vertices carry its colours, to be reflected."""

from __future__ import annotations

import headless
import numpy as np
from headless import bmesh, bpy
from mathutils import Euler, Matrix

COLOUR = "Color"
_SHEETS = (
    # size, place, turn, colour
    ((3.6, 3.6), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.8, 0.8, 0.8)),
    ((3.6, 1.6), (0.0, 1.8, 0.8), (np.pi / 2.0, 0.0, 0.0), (0.8, 0.6, 0.2)),
)
_BOXES = (
    # size, place on the floor, turn about the axis, colour
    ((0.9, 0.9, 0.9), (0.6, 0.2), 0.5, (0.7, 0.1, 0.08)),
    ((0.7, 0.7, 1.4), (-0.75, 0.65), -0.35, (0.1, 0.3, 0.7)),
    ((0.45, 0.45, 0.45), (-0.35, -0.75), 0.9, (0.15, 0.55, 0.15)),
)
_EDGE = 0.08
"""Length of edges: shadows are as sharp as vertices are dense."""


def build() -> bpy.types.Object:
    """The boxes as an object of the scene, selected and active."""
    bm = bmesh.new()
    colour = bm.verts.layers.float_color.new(COLOUR)
    for size, place, turn, rgb in _SHEETS:
        _add_sheet(bm, size, Matrix.Translation(place) @ Euler(turn).to_matrix().to_4x4())
        _paint_the_rest(bm, colour, rgb)
    for box, (x, y), angle, rgb in _BOXES:
        middle = Matrix.Translation((x, y, box[2] / 2.0)) @ Matrix.Rotation(angle, 4, "Z")
        _add_box(bm, middle @ Matrix.Diagonal((*box, 1.0)), max(box))
        _paint_the_rest(bm, colour, rgb)
    bmesh.ops.triangulate(bm, faces=bm.faces)
    mesh = bpy.data.meshes.new("Boxes")
    bm.to_mesh(mesh)
    bm.free()
    mesh.color_attributes.active_color = mesh.color_attributes[COLOUR]
    mesh.materials.append(_coloured())
    boxes = bpy.data.objects.new("Boxes", mesh)
    bpy.context.scene.collection.objects.link(boxes)
    boxes.select_set(True)
    bpy.context.view_layer.objects.active = boxes
    return boxes


def _add_sheet(bm: bmesh.types.BMesh, size: tuple[float, float], matrix: Matrix) -> None:
    cells = [round(length / _EDGE) for length in size]
    scaled = matrix @ Matrix.Diagonal((size[0] / 2.0, size[1] / 2.0, 1.0, 1.0))
    bmesh.ops.create_grid(bm, x_segments=cells[0], y_segments=cells[1], size=1.0, matrix=scaled)


def _add_box(bm: bmesh.types.BMesh, matrix: Matrix, longest: float) -> None:
    corners = bmesh.ops.create_cube(bm, size=1.0, matrix=matrix)["verts"]
    edges = list({edge for vertex in corners for edge in vertex.link_edges})
    bmesh.ops.subdivide_edges(bm, edges=edges, cuts=round(longest / _EDGE), use_grid_fill=True)


def _paint_the_rest(bm: bmesh.types.BMesh, colour: bmesh.types.BMLayerItem, rgb: tuple[float, ...]) -> None:
    """Vertices that have no colour yet: they are white."""
    for vertex in bm.verts:
        if min(vertex[colour]) == 1.0:
            vertex[colour] = (*rgb, 1.0)


def _coloured() -> bpy.types.Material:
    """Matte, and of the vertices' colour."""
    material = bpy.data.materials.new("Coloured")
    headless.use_nodes(material)
    tree = material.node_tree
    tree.nodes.clear()
    attribute, shader, output = (
        tree.nodes.new(f"ShaderNode{kind}") for kind in ("Attribute", "BsdfDiffuse", "OutputMaterial")
    )
    attribute.attribute_name = COLOUR
    tree.links.new(attribute.outputs["Color"], shader.inputs["Color"])
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    return material
