# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds the benchmark's scene as objects of Blender. Import `headless` first."""

from __future__ import annotations

import bpy
import headless
import numpy as np
import scenes


def court(receivers: int, sides: str = "FRONTS") -> list[bpy.types.Object]:
    """`scenes.court` in an empty file, smooth, each mesh in its colour; all selected. With fronts alone a vertex is a receiver."""
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    objects = [_object_of(mesh) for mesh in scenes.court(receivers)]
    for ob in objects:
        ob.prt.sides = sides
    bpy.context.view_layer.update()
    return objects


def _object_of(source: scenes.Mesh) -> bpy.types.Object:
    mesh = bpy.data.meshes.new(source.name)
    corners = source.triangles.reshape(-1)
    mesh.vertices.add(len(source.vertices))
    mesh.vertices.foreach_set("co", source.vertices.astype(np.float32).reshape(-1))
    mesh.loops.add(len(corners))
    mesh.loops.foreach_set("vertex_index", corners)
    mesh.polygons.add(len(source.triangles))
    mesh.polygons.foreach_set("loop_start", np.arange(0, len(corners), 3, dtype=np.int32))
    mesh.update(calc_edges=True)
    mesh.shade_smooth()
    material = bpy.data.materials.new(source.name)
    headless.use_nodes(material)
    principled = next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    principled.inputs["Base Color"].default_value = (*source.colour, 1.0)
    mesh.materials.append(material)
    ob = bpy.data.objects.new(source.name, mesh)
    bpy.context.scene.collection.objects.link(ob)
    ob.select_set(True)
    return ob
