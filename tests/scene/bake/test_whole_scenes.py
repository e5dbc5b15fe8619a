# SPDX-License-Identifier: GPL-3.0-or-later
"""All that renders casts shadows and bounces light, whatever it is made of: instances, curves, text, metaballs.

Each builder puts something red of about one unit's size around (0, 0, 1), above a ground at the origin, and returns
the object whose visibility rules it and the area that it shows (None where it has no closed form). Sheets look down:
the backs of surfaces bounce no light.
"""

import math

import numpy as np
import pytest


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


@pytest.fixture
def ground(scene, stage):
    stage.environment(stage.picture("Sky", stage.six_coloured_sky(16)))
    ob = stage.object_of("Ground", stage.grid(2, 0.5))
    ob.select_set(True)
    return ob


def extra_area(part, bpy, ground):
    """World-space area of all triangles beside the ground's."""
    bpy.context.view_layer.update()
    plan = part("gather").gather(bpy.context, [ground])
    a, b, c = (plan.scene.occluders.vertices[plan.scene.occluders.triangles[:, k]] for k in range(3))
    return np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2 - 1.0


@pytest.mark.parametrize("build", BUILDERS)
def test_everything_is_there_once(blender, part, ground, stage, build):
    """As often and as large as it renders; and not at all when hidden from renders."""
    ob, area = build(blender, stage)
    found = extra_area(part, blender, ground)
    assert found == pytest.approx(area, rel=0.01) if area else found > 0.5
    ob.hide_render = True
    assert extra_area(part, blender, ground) == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("build", BUILDERS)
def test_everything_occludes_and_bounces(blender, part, ground, stage, build):
    """The ground below is darker for it, and the light that comes off it is red."""
    build(blender, stage)
    read = part("layers").read
    options = {"samples": 256, "update_light": False, "update_shading": False}
    blender.ops.prt.bake(mode="SHADOWED", **options)
    shadowed = read(ground.data)[:, 0].mean(axis=0)
    assert (shadowed < 0.27).all(), "0.2821 without it"
    blender.ops.prt.bake(mode="INTERREFLECTED", bounces=1, **options)
    red, green, blue = read(ground.data)[:, 0].mean(axis=0) - shadowed
    assert red > 1e-4 and abs(green) < 1e-6 and abs(blue) < 1e-6


def test_metaballs_of_a_family_and_hair(blender, part, ground, stage):
    """The family is one surface; hair strands have none, and are no error."""
    _, _ = metaball(blender, stage)
    one = extra_area(part, blender, ground)
    metaball(blender, stage)[0].location = (50, 0, 1)
    assert extra_area(part, blender, ground) == pytest.approx(2 * one, rel=0.01)
    hair = blender.data.hair_curves.new("Hair")
    hair.add_curves([3])
    blender.context.scene.collection.objects.link(blender.data.objects.new("Hair", hair))
    assert extra_area(part, blender, ground) == pytest.approx(2 * one, rel=0.01)


@pytest.mark.parametrize("build", [filled_curve, text, metaball])
def test_what_casts_no_shadow_casts_none(blender, part, ground, stage, build):
    """Ray Visibility > Shadow is the person's word on it."""
    ob, _ = build(blender, stage)
    ob.visible_shadow = False
    assert extra_area(part, blender, ground) == pytest.approx(0.0, abs=1e-6)


def test_shadow_visibility_of_instances(blender, part, ground, stage):
    """It is that of the object which is shown."""
    empty, _ = collection_instances(blender, stage)
    empty.instance_collection.objects[0].visible_shadow = False
    assert extra_area(part, blender, ground) == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("build", [filled_curve, text, metaball])
def test_what_is_no_mesh_does_not_receive(blender, part, ground, stage, build):
    """Selected or not: there is nothing to store transport on, and it is no error."""
    ob, _ = build(blender, stage)
    ob.select_set(True)
    assert blender.ops.prt.bake(mode="SHADOWED", samples=16, update_shading=False) == {"FINISHED"}
    assert part("layers").is_baked(ground.data)


def test_render_visibility_of_collections(blender, part, scene, ground, stage):
    """What a collection hides from renders, or a view layer excludes, takes no part."""
    ob, area = filled_curve(blender, stage)
    group = blender.data.collections.new("Group")
    scene.collection.children.link(group)
    group.objects.link(ob)
    scene.collection.objects.unlink(ob)
    assert extra_area(part, blender, ground) == pytest.approx(area)
    group.hide_render = True
    assert extra_area(part, blender, ground) == pytest.approx(0.0, abs=1e-6)
    group.hide_render = False
    blender.context.view_layer.layer_collection.children["Group"].exclude = True
    assert extra_area(part, blender, ground) == pytest.approx(0.0, abs=1e-6)


def test_what_only_renders_see_is_said(blender, part, scene, stage):
    """Hidden in the viewport, shown in renders: Blender does not evaluate it here, and the person should know."""
    floor = stage.object_of("Floor", stage.grid(1, 1.0))
    roof = stage.object_of("Roof", stage.grid(1, 1.0), location=(0, 0, 1))
    roof.hide_viewport = True
    warnings = part("gather").gather(blender.context, [floor]).warnings
    assert len(warnings) == 1 and "'Roof'" in warnings[0] and "unhide" in warnings[0]
    roof.hide_render = True
    assert not part("gather").gather(blender.context, [floor]).warnings
