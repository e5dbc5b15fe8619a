# SPDX-License-Identifier: GPL-3.0-or-later
"""Five scenes that the gallery measures under every sky: a prop, a terrain, a plant of cut-outs, a product with metal, a room."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from math import cos, pi, radians, sin

import demo_scene
import numpy as np
from demo_scene import add_object, plain_material
from headless import bmesh, bpy, mathutils

Build = Callable[[], None]
Place = tuple[float, float, float]


def suzanne() -> None:
    """Suzanne of matte clay on a matte plinth: closed props."""
    demo_scene.build()
    for material in bpy.data.materials:
        if material.node_tree:
            material.node_tree.nodes["Principled BSDF"].inputs["Specular IOR Level"].default_value = 0.0


def terrain() -> None:
    """Hills of some hundred thousand faces, in grass and rock by their height."""
    _start((0.0, -7.5, 4.2), (radians(62.0), 0.0, 0.0))
    mesh = _of("Terrain", lambda bm: bmesh.ops.create_grid(bm, x_segments=240, y_segments=240, size=3.0))
    noise = mathutils.noise
    for vertex in mesh.vertices:
        vertex.co.z = 0.8 * noise.multi_fractal(vertex.co * 0.5, 0.9, 2.2, 6)
    height = np.array([vertex.co.z for vertex in mesh.vertices])
    share = np.clip((height - height.mean()) / height.std() * 0.5 + 0.5, 0.0, 1.0)[:, None]
    colours = np.ones((len(height), 4), dtype=np.float32)
    colours[:, :3] = (1.0 - share) * (0.12, 0.22, 0.05) + share * (0.45, 0.4, 0.36)
    mesh.color_attributes.new("Ground", "FLOAT_COLOR", "POINT").data.foreach_set("color", colours.ravel())
    material = plain_material("Ground", (0.0, 0.0, 0.0))
    attribute = material.node_tree.nodes.new("ShaderNodeVertexColor")
    attribute.layer_name = "Ground"
    shader = material.node_tree.nodes["Principled BSDF"]
    material.node_tree.links.new(attribute.outputs["Color"], shader.inputs["Base Color"])
    add_object("Terrain", mesh, material)


def plant() -> None:
    """A pot of bent leaves, single sheets that are cut out by an alpha."""
    _start((0.0, -6.5, 2.4), (radians(78.0), 0.0, 0.0))
    _floor()
    add_object(
        "Pot",
        _lathed("Pot", [(0.5, 0.0), (0.72, 0.9), (0.62, 0.9), (0.6, 0.75), (0.02, 0.75)]),
        plain_material("Pot", (0.6, 0.25, 0.15)),
    )
    leaf, random = _cut_out("Leaf", (0.12, 0.4, 0.08)), np.random.default_rng(4)
    for number in range(48):
        mesh = _of("Leaf", _leaf, uv=True)
        for vertex in mesh.vertices:
            along = vertex.co.y + 0.5
            vertex.co = (0.45 * vertex.co.x, along, 0.25 * vertex.co.x**2 - 0.35 * along * along)
        ob = add_object(f"Leaf {number}", mesh, leaf)
        ob.scale = (random.uniform(1.0, 1.8),) * 3
        ob.location = (*random.normal(0.0, 0.12, 2), 0.75 + random.uniform(0.0, 0.9))
        ob.rotation_euler = (random.uniform(0.2, 1.2), 0.0, 2.399963 * number)


def product() -> None:
    """A bottle of glossy plastic with a ring and a cap of rough metal, and a coated box."""
    _start((0.0, -7.0, 2.6), (radians(76.0), 0.0, 0.0))
    _floor()
    bottle = [(0.55, 0.0), (0.62, 0.08), (0.62, 1.3), (0.25, 1.7), (0.22, 2.0), (0.01, 2.0)]
    add_object(
        "Bottle", _lathed("Bottle", bottle), plain_material("Plastic", (0.1, 0.25, 0.6), 0.5, 0.3)
    ).location.x = -0.6
    cap = add_object(
        "Cap", _lathed("Cap", [(0.28, 0.0), (0.28, 0.4), (0.01, 0.42)]), _metal("Gold", (0.9, 0.65, 0.3), 0.6)
    )
    cap.location = (-0.6, 0.0, 1.95)
    box = _of("Box", lambda bm: bmesh.ops.create_cube(bm, size=1.0))
    ob = add_object("Box", box, plain_material("Card", (0.7, 0.66, 0.6), 0.5, 0.5))
    ob.location, ob.rotation_euler.z = (0.85, 0.2, 0.5), radians(25.0)
    bevel = ob.modifiers.new("Bevel", "BEVEL")
    bevel.width, bevel.segments = 0.06, 4
    ob.modifiers.new("Finer", "SUBSURF").render_levels = 4
    ob.modifiers["Finer"].subdivision_type = "SIMPLE"
    ball = _of("Ball", lambda bm: bmesh.ops.create_icosphere(bm, subdivisions=5, radius=0.35))
    add_object("Ball", ball, _metal("Steel", (0.6, 0.6, 0.62), 0.7)).location = (0.3, -1.1, 0.35)


def room() -> None:
    """A white room with a red and a green wall, lit through one window; a bed of boxes in it."""
    _start((0.0, -1.9, 1.5), (radians(86.0), 0.0, 0.0), lens=20.0)
    white = plain_material("Plaster", (0.75, 0.74, 0.7))
    walls: dict[str, tuple[bpy.types.Material, Place, Place]] = {
        "Ground": (white, (0.0, 0.0, -0.1), (4.4, 4.4, 0.2)),
        "Ceiling": (white, (0.0, 0.0, 3.1), (4.4, 4.4, 0.2)),
        "Back": (white, (0.0, 2.1, 1.5), (4.0, 0.2, 3.0)),
        "Front": (white, (0.0, -2.1, 1.5), (4.0, 0.2, 3.0)),
        "Left": (plain_material("Red", (0.6, 0.1, 0.08)), (-2.1, 0.0, 1.5), (0.2, 4.4, 3.0)),
        "Sill": (plain_material("Green", (0.15, 0.45, 0.12)), (2.1, 0.0, 0.45), (0.2, 4.4, 0.9)),
        "Lintel": (white, (2.1, 0.0, 2.75), (0.2, 4.4, 0.5)),
        "Pier": (white, (2.1, 1.7, 1.7), (0.2, 1.0, 1.6)),
        "Pillar": (white, (2.1, -1.7, 1.7), (0.2, 1.0, 1.6)),
        "Bed": (plain_material("Cloth", (0.3, 0.35, 0.6)), (-0.9, 0.9, 0.3), (1.6, 1.8, 0.6)),
        "Chest": (plain_material("Wood", (0.4, 0.22, 0.1)), (1.2, 1.4, 0.5), (0.8, 0.6, 1.0)),
    }
    for name, (material, location, size) in walls.items():
        _block(name, material, location, size)


SCENES: dict[str, Build] = {
    "Suzanne": suzanne,
    "Terrain": terrain,
    "Plant": plant,
    "Product": product,
    "Room": room,
}
"""Each fills the empty file, with a sky that `gallery.change_sky` can change."""


def _start(location: Place, rotation: Place, lens: float = 50.0) -> None:
    """A sky and a camera."""
    scene = bpy.context.scene
    demo_scene.add_sky(scene)
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    scene.collection.objects.link(camera)
    camera.location, camera.rotation_euler, camera.data.lens = location, rotation, lens
    scene.camera = camera
    scene.render.resolution_x, scene.render.resolution_y = 640, 360
    scene.view_settings.view_transform = "AgX"


def _floor() -> None:
    mesh = _of("Floor", lambda bm: bmesh.ops.create_grid(bm, x_segments=120, y_segments=120, size=2.6))
    add_object("Floor", mesh, plain_material("Plaster", (0.78, 0.76, 0.72)))


def _of(name: str, build: Callable[[bmesh.types.BMesh], object], uv: bool = False) -> bpy.types.Mesh:
    mesh, bm = bpy.data.meshes.new(name), bmesh.new()
    if uv:
        bm.loops.layers.uv.new()
    build(bm)
    bm.to_mesh(mesh)
    bm.free()
    return mesh


def _leaf(bm: bmesh.types.BMesh) -> None:
    bmesh.ops.create_grid(bm, x_segments=6, y_segments=14, size=0.5, calc_uvs=True)


def _block(name: str, material: bpy.types.Material, location: Place, size: Place) -> None:
    """A box of faces some eight centimetres wide."""

    def build(bm: bmesh.types.BMesh) -> None:
        bmesh.ops.create_cube(bm, size=1.0, matrix=mathutils.Matrix.Diagonal((*size, 1.0)))
        for axis in range(3):
            for cut in np.arange(0.08, size[axis], 0.08) - size[axis] / 2.0:
                plane = mathutils.Vector([float(axis == k) for k in range(3)])
                bmesh.ops.bisect_plane(bm, geom=[*bm.verts, *bm.edges, *bm.faces], plane_co=plane * cut, plane_no=plane)

    ob = add_object(name, _of(name, build), material)
    ob.data.polygons.foreach_set("use_smooth", [False] * len(ob.data.polygons))
    ob.location = location


def _lathed(name: str, profile: list[tuple[float, float]]) -> bpy.types.Mesh:
    """A profile of radii and heights turned about z, rounded by steps of three centimetres."""
    points = [profile[0]]
    for end in profile[1:]:
        start = points[-1]
        steps = max(1, round(np.hypot(end[0] - start[0], end[1] - start[1]) / 0.03))
        points += [tuple(np.add(start, np.subtract(end, start) * (k + 1) / steps)) for k in range(steps)]
    spokes = 96

    def build(bm: bmesh.types.BMesh) -> None:
        rings = [
            [bm.verts.new((r * cos(2 * pi * k / spokes), r * sin(2 * pi * k / spokes), z)) for k in range(spokes)]
            for r, z in points
        ]
        for lower, upper in pairwise(rings):
            for k in range(spokes):
                after = (k + 1) % spokes
                bm.faces.new((lower[k], lower[after], upper[after], upper[k]))
        bm.faces.new(rings[-1])
        bm.faces.new(rings[0][::-1])

    return _of(name, build)


def _metal(name: str, colour: tuple[float, float, float], roughness: float) -> bpy.types.Material:
    material = plain_material(name, colour, 0.5, roughness)
    material.node_tree.nodes["Principled BSDF"].inputs["Metallic"].default_value = 1.0
    return material


def _cut_out(name: str, colour: tuple[float, float, float]) -> bpy.types.Material:
    """A material whose alpha is a picture of a leaf."""
    size = 64
    y, x = np.meshgrid(*[(np.arange(size) + 0.5) / size] * 2, indexing="ij")
    pixels = np.ones((size, size, 4), dtype=np.float32)
    pixels[..., :3] = (np.abs(x - 0.5) < 0.5 * np.sin(pi * y) ** 0.7)[..., None]
    image = bpy.data.images.new(name, size, size)
    image.colorspace_settings.name = "Non-Color"
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    material = plain_material(name, colour)
    tree = material.node_tree
    texture = tree.nodes.new("ShaderNodeTexImage")
    texture.image = image
    tree.links.new(texture.outputs["Color"], tree.nodes["Principled BSDF"].inputs["Alpha"])
    return material
