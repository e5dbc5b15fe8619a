# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds what renders besides plain meshes: curves, text, metaballs, instances, particles.

Each puts something red of about one unit's size around (0, 0, 1), above a ground at the origin, and returns the object
whose visibility rules it and the area that it shows (None where it has no closed form). Sheets look down: the backs of
surfaces bounce no light.
"""

import math


def red_of(stage):
    return stage.diffuse("Red", (0.9, 0.0, 0.0))


def data_object(bpy, stage, name, data):
    data.materials.append(red_of(stage))
    ob = bpy.data.objects.new(name, data)
    ob.location, ob.rotation_euler = (0, 0, 1), (math.pi, 0, 0)
    bpy.context.scene.collection.objects.link(ob)
    return ob


def filled_curve(bpy, stage):
    curve = bpy.data.curves.new("Disc", "CURVE")
    curve.dimensions, curve.fill_mode = "2D", "BOTH"
    spline = curve.splines.new("POLY")
    spline.points.add(3)
    spline.use_cyclic_u = True
    for point, (x, y) in zip(spline.points, [(-1, -1), (1, -1), (1, 1), (-1, 1)], strict=True):
        point.co = (x, y, 0, 1)
    return data_object(bpy, stage, "Curve", curve), 4.0


def bevelled_curve(bpy, stage):
    curve = bpy.data.curves.new("Tube", "CURVE")
    curve.dimensions, curve.bevel_depth, curve.bevel_resolution = "3D", 0.5, 16
    spline = curve.splines.new("POLY")
    spline.points.add(1)
    spline.points[0].co, spline.points[1].co = (-1, 0, 0, 1), (1, 0, 0, 1)
    return data_object(bpy, stage, "Tube", curve), 2 * math.pi * 0.5 * 2.0


def text(bpy, stage):
    letters = bpy.data.curves.new("Letters", "FONT")
    letters.body, letters.size, letters.align_x, letters.align_y = "MM", 2.0, "CENTER", "CENTER"
    return data_object(bpy, stage, "Text", letters), None


def metaball(bpy, stage):
    meta = bpy.data.metaballs.new("Meta")
    meta.resolution = 0.1
    meta.elements.new(type="BALL").radius = 1.5
    return data_object(bpy, stage, "Meta", meta), None


def nurbs(bpy, stage):
    surface = bpy.data.curves.new("Patch", "SURFACE")
    for y in (-1, -0.3, 0.3, 1):
        spline = surface.splines.new("NURBS")
        spline.points.add(3)
        for point, x in zip(spline.points, (-1, -0.3, 0.3, 1), strict=True):
            point.co = (x, y, 0, 1)
    ob = data_object(bpy, stage, "Patch", surface)
    ob.rotation_euler = (0, 0, 0)  # its front is below already
    for spline in surface.splines:
        for point in spline.points:
            point.select = True
    bpy.context.view_layer.objects.active = ob
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.curve.make_segment()
    bpy.ops.object.mode_set(mode="OBJECT")
    surface.splines[0].use_endpoint_u = surface.splines[0].use_endpoint_v = True
    return ob, 4.0


def unseen(bpy, ob):
    """Take an object out of the scene, for something else to show it."""
    holder = bpy.data.collections.new("Unseen")
    holder.objects.link(ob)
    bpy.context.scene.collection.objects.unlink(ob)


def red_square(stage, size):
    mesh = stage.grid(1, size)
    mesh.flip_normals()
    return stage.object_of("Square", mesh, red_of(stage))


def collection_instances(bpy, stage):
    unseen(bpy, red_square(stage, 1.0))
    empty = bpy.data.objects.new("Instancer", None)
    empty.instance_type, empty.instance_collection = "COLLECTION", bpy.data.collections["Unseen"]
    empty.location, empty.scale = (0, 0, 1), (0.5, 0.5, 0.5)
    bpy.context.scene.collection.objects.link(empty)
    return empty, 1.0


def geometry_node_instances(bpy, stage):
    """Instances of the little squares of another object on the four points of a hidden mesh."""
    square = red_square(stage, 0.4)
    unseen(bpy, square)
    tree = bpy.data.node_groups.new("Scatter", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    entry, leave = tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")
    scatter, info = tree.nodes.new("GeometryNodeInstanceOnPoints"), tree.nodes.new("GeometryNodeObjectInfo")
    info.inputs["Object"].default_value = square
    info.inputs["As Instance"].default_value = True
    tree.links.new(entry.outputs[0], scatter.inputs["Points"])
    tree.links.new(info.outputs["Geometry"], scatter.inputs["Instance"])
    tree.links.new(scatter.outputs[0], leave.inputs[0])
    ob = stage.object_of("Scattered", stage.grid(1, 0.5), location=(0, 0, 1))
    ob.modifiers.new("Scatter", "NODES").node_group = tree
    return ob, 4 * 0.64


def vertex_instances(bpy, stage):
    points = stage.object_of("Points", stage.grid(1, 0.5), location=(0, 0, 1))
    square = red_square(stage, 0.4)
    square.parent = points
    points.instance_type = "VERTS"
    points.show_instancer_for_render = points.show_instancer_for_viewport = False
    square.location = (0.1, 0, 0)  # does not render itself
    return points, 4 * 0.64


def face_instances(bpy, stage):
    points, area = vertex_instances(bpy, stage)
    points.instance_type = "FACES"
    return points, area / 4


def particles(bpy, stage):
    square = red_square(stage, 0.4)
    unseen(bpy, square)
    emitter = stage.object_of("Emitter", stage.grid(1, 0.5), location=(0, 0, 1))
    settings = emitter.modifiers.new("Particles", "PARTICLE_SYSTEM").particle_system.settings
    settings.type, settings.count, settings.emit_from, settings.use_emit_random = "HAIR", 4, "VERT", False
    settings.render_type, settings.instance_object = "OBJECT", square
    settings.use_advanced_hair, settings.particle_size, settings.hair_length = True, 1.0, 1.0
    emitter.show_instancer_for_render = emitter.show_instancer_for_viewport = False
    return emitter, 4 * 0.64


BUILDERS = [
    filled_curve,
    bevelled_curve,
    text,
    metaball,
    nurbs,
    collection_instances,
    geometry_node_instances,
    vertex_instances,
    face_instances,
    particles,
]
