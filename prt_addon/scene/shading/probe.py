# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the light probe: a sphere that shows, along its normals, what the SH light holds in that direction.

It is a mesh like any baked one, except that its transport is the basis itself instead of its integral over what a
surface sees: it turns with the world and goes with a saved file by the same means. It is hidden in renders, so that it
shadows nothing; bakes and reports pass it over even if it is selected.
"""

from __future__ import annotations

import bmesh
import bpy
import numpy as np

from ...core.problem import BakeSettings
from ...core.sphere import sh
from ..blender.nodes import turn_nodes
from ..mesh import layers
from ..mesh.meshes import layer_array
from ..mesh.record import RECORD
from . import shading

NAME = "PRT Light Probe"
_MARK = "prt_probe"


def ensure_probe(scene: bpy.types.Scene) -> bpy.types.Object:
    """The scene's probe, made if there is none, at the 3D cursor."""
    probe = next((ob for ob in scene.objects if is_probe(ob.data)), None) or _made(scene)
    _write_basis(probe.data)  # whatever was written there meanwhile
    probe.location = scene.cursor.location
    return probe


def is_probe(data: bpy.types.ID | None) -> bool:
    """Whether an object's data is the mesh of a probe."""
    return data is not None and _MARK in data


def remove_probes() -> None:
    """Remove all probes from the file, with their meshes and material."""
    for mesh in [mesh for mesh in bpy.data.meshes if is_probe(mesh)]:
        materials = list(mesh.materials)
        bpy.data.batch_remove([ob for ob in bpy.data.objects if ob.data == mesh])
        bpy.data.meshes.remove(mesh)
        bpy.data.batch_remove([material for material in materials if not material.users])


def _made(scene: bpy.types.Scene) -> bpy.types.Object:
    mesh = bpy.data.meshes.new(NAME)
    mesh[_MARK] = True
    bm = bmesh.new()
    bmesh.ops.create_uvsphere(bm, u_segments=64, v_segments=32, radius=1.0)
    bm.to_mesh(mesh)
    bm.free()
    mesh.shade_smooth()
    mesh.materials.append(_white())
    probe = bpy.data.objects.new(NAME, mesh)
    probe.hide_render = True
    scene.collection.objects.link(probe)
    shading.add_shading([probe])
    return probe


def _write_basis(mesh: bpy.types.Mesh) -> None:
    """Let each vertex show the light along its direction, in the object's own axes."""
    directions = layer_array(mesh, "position", "vector", 3).astype(np.float64)
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    basis = sh.basis(directions).astype(np.float32)
    settings = BakeSettings(mode="UNSHADOWED")
    layers.write(mesh, "POINT", basis, basis, np.arange(len(basis)), settings, "OBJECT")
    del mesh[RECORD]  # it was never baked


def _white() -> bpy.types.Material:
    material = bpy.data.materials.new(NAME)
    turn_nodes(material, True)
    tree = material.node_tree
    tree.nodes.clear()
    shader, output = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("BsdfDiffuse", "OutputMaterial"))
    output.location.x = 240.0
    shader.inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    return material
