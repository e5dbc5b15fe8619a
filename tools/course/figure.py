# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds the course's figure: a dancer in a skirt on a disc, one mesh, made of bones by Blender's Skin modifier."""

from __future__ import annotations

from itertools import pairwise

import headless
import numpy as np
from headless import bmesh, bpy

_BONES = {
    # joint: where, how thick, which joint it hangs on
    "hips": ((0.0, 0.0, 1.0), 0.15, None),
    "waist": ((0.01, 0.0, 1.17), 0.12, "hips"),
    "chest": ((0.02, 0.0, 1.38), 0.155, "waist"),
    "neck": ((0.03, -0.01, 1.56), 0.06, "chest"),
    "chin": ((0.03, -0.04, 1.66), 0.11, "neck"),
    "head": ((0.04, -0.03, 1.79), 0.165, "chin"),
    "crown": ((0.04, -0.01, 1.92), 0.09, "head"),
    "bun": ((0.05, 0.2, 1.9), 0.085, "head"),
    "left shoulder": ((0.2, 0.0, 1.46), 0.065, "chest"),
    "left elbow": ((0.42, -0.1, 1.62), 0.045, "left shoulder"),
    "left wrist": ((0.34, -0.18, 1.88), 0.035, "left elbow"),
    "left hand": ((0.24, -0.2, 2.0), 0.03, "left wrist"),
    "right shoulder": ((-0.17, 0.0, 1.45), 0.065, "chest"),
    "right elbow": ((-0.38, 0.05, 1.26), 0.045, "right shoulder"),
    "right wrist": ((-0.25, -0.18, 1.12), 0.035, "right elbow"),
    "right hand": ((-0.15, -0.22, 1.08), 0.03, "right wrist"),
    "left hip": ((0.1, 0.0, 0.9), 0.12, "hips"),
    "left knee": ((0.22, -0.2, 0.62), 0.075, "left hip"),
    "left ankle": ((0.05, -0.12, 0.3), 0.045, "left knee"),
    "left toe": ((0.02, -0.2, 0.16), 0.035, "left ankle"),
    "right hip": ((-0.1, 0.0, 0.9), 0.12, "hips"),
    "right knee": ((-0.1, -0.03, 0.5), 0.08, "right hip"),
    "right ankle": ((-0.1, 0.02, 0.1), 0.05, "right knee"),
    "right toe": ((-0.1, -0.16, 0.04), 0.04, "right ankle"),
}
_SPOKES = 96
_SKIRT = [(0.1, 1.2), (0.13, 1.19), (0.16, 1.12), (0.2, 1.05), (0.26, 0.97), (0.33, 0.9), (0.41, 0.83), (0.5, 0.78)]
"""Radius and height from the waist to the hem."""
_THICKNESS, _RUFFLES = 0.015, 11
_DISC = [(radius, 0.0) for radius in np.linspace(0.03, 0.8, 26)] + [(0.815, -0.015), (0.815, -0.06), (0.815, -0.1)]


def build() -> bpy.types.Object:
    """The figure as an object of the scene, selected and active; white, as the course's surfaces are."""
    mesh = _joined(_dancer(), _turned(_DISC, 0.0), _skirt())
    mesh.polygons.foreach_set("use_smooth", [True] * len(mesh.polygons))
    mesh.materials.append(_white())
    figure = bpy.data.objects.new("Figure", mesh)
    bpy.context.scene.collection.objects.link(figure)
    figure.select_set(True)
    bpy.context.view_layer.objects.active = figure
    return figure


def _dancer() -> bpy.types.Mesh:
    """Skin over the bones, subdivided."""
    bones = bpy.data.meshes.new("Bones")
    places = {joint: number for number, joint in enumerate(_BONES)}
    edges = [(places[parent], places[joint]) for joint, (_, _, parent) in _BONES.items() if parent]
    bones.from_pydata([where for where, _, _ in _BONES.values()], edges, [])
    ob = bpy.data.objects.new("Bones", bones)
    bpy.context.scene.collection.objects.link(ob)
    ob.modifiers.new("Skin", "SKIN").branch_smoothing = 0.6
    for vertex, (_, thickness, parent) in zip(bones.skin_vertices[0].data, _BONES.values(), strict=True):
        vertex.radius, vertex.use_root = (thickness, thickness), parent is None
    ob.modifiers.new("Subdivision", "SUBSURF").levels = 2
    bpy.context.view_layer.update()
    skin = bpy.data.meshes.new_from_object(ob.evaluated_get(bpy.context.evaluated_depsgraph_get()))
    bpy.data.objects.remove(ob)
    bpy.data.meshes.remove(bones)
    return skin


def _skirt() -> bpy.types.Mesh:
    """Cloth of some thickness: down to the hem, and up again inside."""
    inside = [(radius - _THICKNESS, height - _THICKNESS) for radius, height in reversed(_SKIRT)]
    return _turned([*_SKIRT, *inside], 0.2)


def _turned(profile: list[tuple[float, float]], ruffle: float) -> bpy.types.Mesh:
    """A profile of radii and heights turned about the axis, waved in proportion to the radius; closed at its start."""
    angle = 2.0 * np.pi * np.arange(_SPOKES) / _SPOKES
    bm = bmesh.new()
    rings = []
    for radius, height in profile:
        wave = radius * ruffle * np.cos(_RUFFLES * angle) * radius
        around = zip((radius + wave) * np.cos(angle), (radius + wave) * np.sin(angle), strict=True)
        rings.append([bm.verts.new((x, y, height + wave[spoke] / 2.0)) for spoke, (x, y) in enumerate(around)])
    bm.faces.new(rings[0])
    for inner, outer in pairwise(rings):
        for spoke in range(_SPOKES):
            after = (spoke + 1) % _SPOKES
            bm.faces.new((inner[spoke], outer[spoke], outer[after], inner[after]))
    mesh = bpy.data.meshes.new("Turned")
    bm.to_mesh(mesh)
    bm.free()
    return mesh


def _joined(*parts: bpy.types.Mesh) -> bpy.types.Mesh:
    """One mesh of several, of triangles alone, as the course's files want it."""
    bm = bmesh.new()
    for part in parts:
        bm.from_mesh(part)
        bpy.data.meshes.remove(part)
    bmesh.ops.triangulate(bm, faces=bm.faces)
    whole = bpy.data.meshes.new("Figure")
    bm.to_mesh(whole)
    bm.free()
    return whole


def _white() -> bpy.types.Material:
    """Matte, and of base colour 1."""
    material = bpy.data.materials.new("White")
    headless.use_nodes(material)
    tree = material.node_tree
    tree.nodes.clear()
    shader, output = tree.nodes.new("ShaderNodeBsdfDiffuse"), tree.nodes.new("ShaderNodeOutputMaterial")
    shader.inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    return material
