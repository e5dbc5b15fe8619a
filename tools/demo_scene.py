# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds the demo's scene: a finely tessellated, glazed Suzanne on a plinth, under a low sun: an HDRI that Blender ships."""

from __future__ import annotations

import headless
from headless import bmesh, bpy, mathutils

HDRI = "sunrise"


def build() -> None:
    """Fill the empty file."""
    scene = bpy.context.scene
    suzanne = add_object(
        "Suzanne", _suzanne(), plain_material("Terracotta", (0.75, 0.28, 0.12), gloss=0.5, roughness=0.35)
    )
    suzanne.rotation_euler = (-0.62, 0.0, 0.0)
    bpy.context.view_layer.update()
    suzanne.location.z = -min((suzanne.matrix_world @ vertex.co).z for vertex in suzanne.data.vertices)
    add_object("Plinth", _plinth(), plain_material("Plaster", (0.78, 0.76, 0.72)))
    add_sky(scene)
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    scene.collection.objects.link(camera)
    camera.location, camera.rotation_euler = (3.3, -8.0, 3.9), (1.19, 0.0, 0.39)
    camera.data.lens = 60.0
    scene.camera = camera
    scene.render.resolution_x, scene.render.resolution_y = 640, 360
    scene.view_settings.view_transform = "AgX"
    scene.view_settings.look = "AgX - Medium High Contrast"
    bpy.context.view_layer.update()


def diffuse_bounces(scene: bpy.types.Scene) -> int:
    """Bounces that Cycles needs for the light that was baked."""
    return int(scene.prt.bounces) if scene.prt.mode == "INTERREFLECTED" else 0


def ensure_camera() -> None:
    """Frame everything if the file has no camera."""
    scene = bpy.context.scene
    if scene.camera:
        return
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    scene.collection.objects.link(camera)
    scene.camera = camera
    camera.rotation_euler = (1.1, 0.0, 0.6)
    bpy.context.view_layer.update()
    meshes = [ob for ob in scene.objects if ob.type == "MESH"]
    corners = [co for ob in meshes for point in ob.bound_box for co in ob.matrix_world @ mathutils.Vector(point)]
    camera.location, _ = camera.camera_fit_coords(bpy.context.evaluated_depsgraph_get(), corners)


def add_object(name: str, mesh: bpy.types.Mesh, material: bpy.types.Material) -> bpy.types.Object:
    """Add a smooth object of a mesh to the scene."""
    mesh.materials.append(material)
    mesh.polygons.foreach_set("use_smooth", [True] * len(mesh.polygons))
    ob = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(ob)
    return ob


def _suzanne() -> bpy.types.Mesh:
    """Suzanne, subdivided to 31k vertices by the modifier, and applied."""
    mesh = bpy.data.meshes.new("Suzanne")
    bm = bmesh.new()
    bmesh.ops.create_monkey(bm)
    bm.to_mesh(mesh)
    bm.free()
    ob = bpy.data.objects.new("Suzanne", mesh)
    bpy.context.scene.collection.objects.link(ob)
    ob.modifiers.new("Subdivision", "SUBSURF").levels = 3
    bpy.context.view_layer.update()
    smooth = bpy.data.meshes.new_from_object(ob.evaluated_get(bpy.context.evaluated_depsgraph_get()))
    bpy.data.objects.remove(ob)
    bpy.data.meshes.remove(mesh)
    return smooth


def _plinth() -> bpy.types.Mesh:
    """A round table top, its rings closer together near the middle, where the shadow is."""
    rings, spokes, radius = 90, 160, 2.6
    bm = bmesh.new()
    bmesh.ops.create_circle(bm, cap_ends=True, cap_tris=True, segments=spokes, radius=radius / rings)
    edge = [e for e in bm.edges if e.is_boundary]
    for ring in range(2, rings + 1):
        edge = _widened(bm, edge, ring / (ring - 1))
    for drop, inset in ((-0.03, 1.008), (-0.25, 1.0)):
        edge = _widened(bm, edge, inset, drop)
    mesh = bpy.data.meshes.new("Plinth")
    bm.to_mesh(mesh)
    bm.free()
    return mesh


def _widened(
    bm: bmesh.types.BMesh, edge: list[bmesh.types.BMEdge], factor: float, drop: float = 0.0
) -> list[bmesh.types.BMEdge]:
    made = bmesh.ops.extrude_edge_only(bm, edges=edge)["geom"]
    for vertex in (item for item in made if isinstance(item, bmesh.types.BMVert)):
        vertex.co.x *= factor
        vertex.co.y *= factor
        vertex.co.z += drop
    bm.normal_update()
    return [item for item in made if isinstance(item, bmesh.types.BMEdge) and all(v in made for v in item.verts)]


def plain_material(
    name: str, colour: tuple[float, float, float], gloss: float = 0.0, roughness: float = 1.0
) -> bpy.types.Material:
    """Matte, or with gloss of a strength and roughness."""
    material = bpy.data.materials.new(name)
    headless.use_nodes(material)
    shader = material.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (*colour, 1.0)
    shader.inputs["Specular IOR Level"].default_value = gloss
    shader.inputs["Roughness"].default_value = roughness
    return material


def add_sky(scene: bpy.types.Scene) -> None:
    """An HDRI with the nodes to turn it."""
    world = bpy.data.worlds.new("Sky")
    scene.world = world
    headless.use_nodes(world)
    tree = world.node_tree
    texture, mapping, coordinate = (
        tree.nodes.new(kind) for kind in ("ShaderNodeTexEnvironment", "ShaderNodeMapping", "ShaderNodeTexCoord")
    )
    for node, x in ((texture, -300.0), (mapping, -500.0), (coordinate, -700.0)):
        node.location = (x, 300.0)
    texture.image = bpy.data.images.load(str(headless.studio_hdri(HDRI)))
    texture.image.pack()
    tree.links.new(coordinate.outputs["Generated"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs["Vector"], texture.inputs["Vector"])
    tree.links.new(texture.outputs["Color"], tree.nodes["Background"].inputs["Color"])
