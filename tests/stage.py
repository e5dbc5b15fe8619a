# SPDX-License-Identifier: GPL-3.0-or-later
"""Puts things in front of Blender's camera for tests, and reads the picture back. Used inside Blender only."""

import bpy
import headless
import numpy as np
from headless import use_nodes

RESOLUTION = 64


def object_of(name, mesh, material=None, location=(0.0, 0.0, 0.0)):
    """An object of a mesh in the scene's collection."""
    ob = bpy.data.objects.new(name, mesh)
    ob.location = location
    if material:
        mesh.materials.append(material)
    bpy.context.scene.collection.objects.link(ob)
    bpy.context.view_layer.update()
    return ob


def from_bmesh(name, build, smooth=True):
    """A mesh made by a function of bmesh."""
    import bmesh

    bm = bmesh.new()
    build(bm)
    mesh = bpy.data.meshes.new(name)
    bm.to_mesh(mesh)
    bm.free()
    mesh.polygons.foreach_set("use_smooth", [smooth] * len(mesh.polygons))
    return mesh


def icosphere(subdivisions=4, radius=1.0, smooth=True):
    import bmesh

    return from_bmesh(
        "Sphere", lambda bm: bmesh.ops.create_icosphere(bm, subdivisions=subdivisions, radius=radius), smooth
    )


def grid(segments=10, size=1.0):
    import bmesh

    return from_bmesh("Grid", lambda bm: bmesh.ops.create_grid(bm, x_segments=segments, y_segments=segments, size=size))


def crease(mesh):
    """Bend a sheet along its middle, and shade it flat: its transport is on corners."""
    for vertex in mesh.vertices:
        vertex.co.z = 0.3 * abs(vertex.co.x)
    mesh.polygons.foreach_set("use_smooth", [False] * len(mesh.polygons))
    mesh.update()


def cube(size=2.0):
    import bmesh

    return from_bmesh("Cube", lambda bm: bmesh.ops.create_cube(bm, size=size), smooth=False)


def rig():
    """An object of one upright bone, "Bone", and the active one."""
    ob = object_of("Rig", bpy.data.armatures.new("Rig"))
    bpy.context.view_layer.objects.active = ob
    bpy.ops.object.mode_set(mode="EDIT")
    ob.data.edit_bones.new("Bone").tail = (0.0, 0.0, 1.0)
    bpy.ops.object.mode_set(mode="OBJECT")
    return ob


def diffuse(name="Clay", colour=(0.8, 0.5, 0.2)):
    """A material of one Diffuse BSDF."""
    material = bpy.data.materials.new(name)
    use_nodes(material)
    tree = material.node_tree
    tree.nodes.clear()
    shader = tree.nodes.new("ShaderNodeBsdfDiffuse")
    shader.inputs["Color"].default_value = (*colour, 1.0)
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    return material


def picture(name, pixels):
    """A float image of (height, width, 3) linear pixels, row 0 at the bottom."""
    height, width = pixels.shape[:2]
    image = bpy.data.images.new(name, width, height, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    rgba = np.ones((height, width, 4), dtype=np.float32)
    rgba[..., :3] = pixels
    image.pixels.foreach_set(rgba.reshape(-1))
    image.pack()
    return image


def six_coloured_sky(width=128):
    """Pixels of an order-2 sky with another colour on each axis: every wrong turn and mirror shows."""
    return six_colours(_directions(width))


def six_colours(w):
    """What that sky shows along unit vectors (..., 3)."""
    colours = {(0, 1): (3, 0, 0), (0, -1): (0, 2, 0), (1, 1): (0, 0, 4), (1, -1): (2, 2, 0), (2, 1): (0, 3, 3)}
    colours[2, -1] = (1, 0, 2)
    return sum(np.multiply.outer(((1 + sign * w[..., k]) / 2) ** 2, rgb) for (k, sign), rgb in colours.items())


SUN = np.array((0.5, -0.4, 0.7)) / np.linalg.norm((0.5, -0.4, 0.7))


def sunny_sky(width=512):
    """Pixels of a blue sky, and of a yellow sun of three degrees towards `SUN` that sends as much light."""
    w = _directions(width)
    sky = (1.0 + 0.5 * w[..., 2:]) * (0.3, 0.4, 0.6)
    sky[w @ SUN > np.cos(np.radians(3.0))] += (300.0, 250.0, 150.0)
    return sky.astype(np.float32)


def _directions(width):
    """(width / 2, width, 3) unit vectors towards the texels of a panorama, row 0 at the bottom."""
    u = (np.arange(width) + 0.5) / width
    v = (np.arange(width // 2) + 0.5) / (width // 2)
    azimuth, elevation = np.meshgrid(2 * np.pi * (0.5 - u), np.pi * (v - 0.5))
    return np.stack(
        [np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)], axis=-1
    )


def without_negatives(colours):
    """(..., 3) as the shader shows them: towards the grey of the mean, until no channel is negative; black at worst."""
    least, mean = colours.min(axis=-1, keepdims=True), colours.mean(axis=-1, keepdims=True)
    share = np.clip(-least / np.maximum(mean - least, 1e-9), 0.0, 1.0)
    return np.maximum(colours + share * (mean - colours), 0.0)


def environment(image, strength=1.0, mapping=True):
    """A world lit by an image; returns (world, Mapping node or None)."""
    world = bpy.data.worlds.new("Sky")
    bpy.context.scene.world = world
    use_nodes(world)
    tree = world.node_tree
    tree.nodes.clear()
    output = tree.nodes.new("ShaderNodeOutputWorld")
    background = tree.nodes.new("ShaderNodeBackground")
    background.inputs["Strength"].default_value = strength
    texture = tree.nodes.new("ShaderNodeTexEnvironment")
    texture.image = image
    tree.links.new(texture.outputs["Color"], background.inputs["Color"])
    tree.links.new(background.outputs[0], output.inputs["Surface"])
    node = None
    if mapping:
        node = tree.nodes.new("ShaderNodeMapping")
        coordinate = tree.nodes.new("ShaderNodeTexCoord")
        tree.links.new(coordinate.outputs["Generated"], node.inputs["Vector"])
        tree.links.new(node.outputs["Vector"], texture.inputs["Vector"])
    return world, node


def lengthen(world, count):
    """Put nodes before the Background of a world until it has so many: each inverts the colour."""
    nodes, links = world.node_tree.nodes, world.node_tree.links
    background = next(node for node in nodes if node.bl_idname == "ShaderNodeBackground")
    output = background.inputs["Color"].links[0].from_socket
    while len(nodes) < count:
        node = nodes.new("ShaderNodeInvert")
        links.new(output, node.inputs["Color"])
        output = node.outputs[0]
    links.new(output, background.inputs["Color"])


def top_camera(scale=3.0, resolution=RESOLUTION):
    """An orthographic camera that looks straight down; pixel (row, column) is where `pixel_points` says."""
    scene = bpy.context.scene
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    scene.collection.objects.link(camera)
    camera.location = (0.0, 0.0, 10.0)
    camera.data.type, camera.data.ortho_scale = "ORTHO", scale
    scene.camera = camera
    scene.render.resolution_x = scene.render.resolution_y = resolution
    scene.render.film_transparent = True
    scene.render.filter_size = 0.01
    scene.view_settings.view_transform = "Raw"
    scene.eevee.taa_render_samples = 1
    scene.cycles.use_denoising = False
    return camera


def furnace(rim, pixels):
    """A sphere of a Glossy BSDF, 2 wide in the picture, under a sky of 1: its shader; which pixels show it where the cosine of the view is
    above the rim's; and that cosine at each.
    """
    world, _ = environment(picture("Constant", np.ones((4, 8, 3))))
    world.cycles.sampling_method = "NONE"
    top_camera(scale=2.0, resolution=pixels)
    radius2 = (pixel_points(scale=2.0, resolution=pixels) ** 2).sum(axis=-1)
    shown = radius2 < 1.0 - rim**2
    material = diffuse("Metal")
    shader = material.node_tree.nodes.new("ShaderNodeBsdfAnisotropic")
    material.node_tree.links.new(shader.outputs[0], material.node_tree.nodes["Material Output"].inputs["Surface"])
    object_of("Sphere", icosphere(6), material)
    cycles = bpy.context.scene.cycles
    cycles.pixel_filter_type, cycles.filter_width = "GAUSSIAN", 0.01  # the middle of each pixel, or the rim is blurred
    cycles.use_adaptive_sampling, cycles.sample_clamp_indirect, cycles.blur_glossy = False, 0.0, 0.0
    return shader, shown, np.sqrt(1.0 - radius2[shown])


def pixel_points(scale=3.0, resolution=RESOLUTION):
    """(resolution, resolution, 2) world x and y of pixel centres under `top_camera`."""
    line = ((np.arange(resolution) + 0.5) / resolution - 0.5) * scale
    return np.stack(np.meshgrid(line, line), axis=-1)


def render(path, engine="EEVEE", samples=256):
    """(height, width, 4) linear pixels of a frame, row 0 at the bottom."""
    scene = bpy.context.scene
    scene.render.engine = headless.eevee_engine() if engine == "EEVEE" else engine
    scene.cycles.samples = samples
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    return read_exr(path)


def without_normal_detail():
    """Have EEVEE leave the soft light as it is where normals are bent."""
    for detail in (tree for tree in bpy.data.node_groups if tree.name == "PRT Detail"):
        entry, end = (
            next(node for node in detail.nodes if node.bl_idname == f"NodeGroup{one}") for one in ("Input", "Output")
        )
        detail.links.new(entry.outputs["Shading"], end.inputs["Shading"])


def read_exr(path):
    """(height, width, 4) float32 of a written frame."""
    image = bpy.data.images.load(str(path), check_existing=False)
    flat = np.empty(image.size[0] * image.size[1] * 4, dtype=np.float32)
    image.pixels.foreach_get(flat)
    pixels = flat.reshape(image.size[1], image.size[0], 4)
    bpy.data.images.remove(image)
    return pixels


def node_snapshot(tree):
    """All that makes a node tree: its nodes with their settings and constants, and its links."""
    nodes = {}
    for node in tree.nodes:
        settings = {
            p.identifier: repr(getattr(node, p.identifier))
            for p in node.bl_rna.properties
            if p.type in {"BOOLEAN", "INT", "FLOAT", "STRING", "ENUM"}
        }
        constants = [
            repr(list(s.default_value) if hasattr(s.default_value, "__len__") else s.default_value)
            for s in node.inputs
            if hasattr(s, "default_value")
        ]
        nodes[node.name] = (settings, constants)
    links = sorted(
        (link.from_node.name, link.from_socket.identifier, link.to_node.name, link.to_socket.identifier)
        for link in tree.links
    )
    return nodes, links


def baked_bytes(scene):
    """All that a bake writes, byte by byte: layers and records of meshes, and properties of the world."""
    meshes = {}
    for ob in scene.objects:
        if ob.type == "MESH":
            layers = {}
            for layer in ob.data.attributes:
                if layer.name.startswith("_PRT_"):
                    values = np.empty(len(layer.data) * 4, dtype=np.float32)
                    layer.data.foreach_get("color", values)
                    layers[layer.name] = layer.domain, values.tobytes()
            record = ob.data.get("prt_bake")
            meshes[ob.name] = layers, record and repr(record.to_dict())
    world = {
        key: repr(getattr(value, "to_list", lambda v=value: v)())
        for key, value in scene.world.items()
        if key.startswith("prt_light_")
    }
    return meshes, world


def file_snapshot():
    """All that a bake might change, and how the file's data-blocks are called."""
    collections = [prop.identifier for prop in bpy.data.bl_rna.properties if prop.type == "COLLECTION"]
    scene = bpy.context.scene
    return {
        "blocks": {
            name: sorted((each.name, each.users, each.use_fake_user) for each in getattr(bpy.data, name))
            for name in collections
            if name not in {"window_managers", "screens", "workspaces"}
        },
        "meshes": {mesh.name: _mesh_snapshot(mesh) for mesh in bpy.data.meshes},
        "materials": {
            material.name: (_uses_nodes(material) and node_snapshot(material.node_tree), sorted(material.keys()))
            for material in bpy.data.materials
        },
        "objects": {
            ob.name: (
                ob.mode,
                ob.select_get(view_layer=bpy.context.view_layer),
                ob.data.name if ob.data else None,
                [slot.material and slot.material.name for slot in ob.material_slots],
                [_modifier_snapshot(modifier) for modifier in ob.modifiers],
            )
            for ob in bpy.data.objects
        },
        "worlds": {world.name: _world_snapshot(world) for world in bpy.data.worlds},
        "scene": (scene.frame_current, sorted(scene.keys())),
    }


def _uses_nodes(material):
    """Since 5.0 all do; before, one that did once keeps nodes that count for nothing."""
    return bpy.app.version >= (5, 0, 0) or material.use_nodes


def _mesh_snapshot(mesh):
    layers = {}
    for layer in mesh.attributes:
        if layer.name.startswith("_PRT_"):
            values = np.empty(len(layer.data) * 4, dtype=np.float32)
            layer.data.foreach_get("color", values)
            layers[layer.name] = layer.domain, values.tobytes()
        else:
            layers[layer.name] = layer.domain, layer.data_type
    colours = mesh.color_attributes
    keys = {key: repr(getattr(value, "to_dict", lambda v=value: v)()) for key, value in mesh.items()}
    return layers, keys, colours.active_color_name, colours.default_color_name


def _modifier_snapshot(modifier):
    settings: dict[str, str | None] = {
        prop.identifier: repr(getattr(modifier, prop.identifier))
        for prop in modifier.bl_rna.properties
        if prop.type in {"BOOLEAN", "INT", "FLOAT", "STRING", "ENUM"}
        and prop.identifier not in {"execution_time", "persistent_uid"}
    }
    settings["node_group"] = getattr(getattr(modifier, "node_group", None), "name", None)
    return settings


def _world_snapshot(world):
    keys = {
        key: repr(getattr(value, "to_list", lambda v=value: v)()) for key, value in world.items() if key != "prt_light"
    }
    drivers = [
        (curve.data_path, curve.array_index, curve.driver.expression)
        for curve in (world.animation_data.drivers if world.animation_data else ())
    ]
    record = world.get("prt_light")
    return (
        node_snapshot(world.node_tree),
        keys,
        record and repr(record.to_dict()),
        world.animation_data is None,
        drivers,
    )
