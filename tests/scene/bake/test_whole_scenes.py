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
    plan = part("read").read_bake(bpy.context, [ground])
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


def shadow(part, blender, *objects):
    """Mean shadowed T_0 of the objects, as a share of the open sky's."""
    blender.context.view_layer.update()
    problem = part("problem")
    plan = part("read").read_bake(blender.context, list(objects), problem.BakeSettings("SHADOWED", 256))
    transport = part("bake").bake(plan.problem).transport
    first = np.concatenate([transport[one.group][:, 0] for one in plan.objects])
    return float(first.mean() / 0.28209479)


@pytest.fixture
def floor(scene, stage):
    """A floor at the origin that sees all of the sky."""
    stage.environment(stage.picture("Sky", stage.six_coloured_sky(16)))
    return stage.object_of("Floor", stage.grid(4, 0.5))


def roof_over(stage, name="Roof"):
    return stage.object_of(name, stage.grid(1, 2.0), location=(0, 0, 0.5))


def hidden_here(ob):
    ob.hide_set(True)


def disabled_here(ob):
    ob.hide_viewport = True


def made_by_a_modifier(ob):
    """Half a roof, whose other half renders only."""
    for vertex in ob.data.vertices:
        vertex.co.x = max(vertex.co.x, 0.0)
    mirror = ob.modifiers.new("Mirror", "MIRROR")
    mirror.show_viewport = False


def hidden_with_modifiers(ob):
    made_by_a_modifier(ob)
    ob.hide_viewport = True


@pytest.mark.parametrize("change", [hidden_here, disabled_here, made_by_a_modifier, hidden_with_modifiers])
def test_renders_count_and_not_the_viewport(blender, part, floor, stage, change):
    """The same shadow as of a roof that the viewport shows, too; none once it does not render."""
    roof = roof_over(stage)
    whole = shadow(part, blender, floor)
    assert whole < 0.3
    change(roof)
    assert shadow(part, blender, floor) == pytest.approx(whole, abs=0.01)
    roof.hide_render = True
    assert shadow(part, blender, floor) == pytest.approx(1.0, abs=1e-3)


def test_levels_of_renders_are_baked(blender, part, floor, stage):
    """Subdivision 0 here and 3 in renders: the values are those of the round thing."""
    ob = stage.object_of("Ball", stage.cube(1.0), location=(0, 0, 3))
    modifier = ob.modifiers.new("Subdivision", "SUBSURF")
    modifier.levels, modifier.render_levels = 0, 3
    [one] = part("read").read_bake(blender.context, [ob]).objects
    assert one.carried.counts[0] == 386 and one.elements == (8, 24)


def test_a_background_set_blocks_light(blender, part, scene, floor, stage):
    roof = roof_over(stage)
    whole = shadow(part, blender, floor)
    backdrop = blender.data.scenes.new("Backdrop")
    backdrop.collection.objects.link(roof)
    scene.collection.objects.unlink(roof)
    assert shadow(part, blender, floor) == pytest.approx(1.0, abs=1e-3)
    scene.background_set = backdrop
    assert shadow(part, blender, floor) == pytest.approx(whole)


def test_emitters_that_are_not_shown_do_not_block(blender, part, floor, stage):
    roof = roof_over(stage)
    roof.modifiers.new("Particles", "PARTICLE_SYSTEM").particle_system.settings.type = "HAIR"
    assert shadow(part, blender, floor) < 0.3
    roof.show_instancer_for_render = False
    assert shadow(part, blender, floor) == pytest.approx(1.0, abs=1e-3)


def test_rays_that_do_not_see_it(blender, part, floor, stage):
    """Hidden from diffuse or shadow rays it blocks nothing; hidden from all others, or a holdout, it does."""
    roof = roof_over(stage)
    whole = shadow(part, blender, floor)
    for name in ("visible_diffuse", "visible_shadow"):
        setattr(roof, name, False)
        assert shadow(part, blender, floor) == pytest.approx(1.0, abs=1e-3), name
        setattr(roof, name, True)
    for name in ("visible_camera", "visible_glossy", "visible_transmission", "visible_volume_scatter"):
        setattr(roof, name, False)
    roof.is_holdout = True
    assert shadow(part, blender, floor) == pytest.approx(whole)


def test_what_casts_no_shadow_still_receives(blender, part, floor, stage):
    """Alone, or beside others that it does not shade."""
    floor.visible_shadow = False
    assert shadow(part, blender, floor) == pytest.approx(1.0, abs=1e-3)
    roof = roof_over(stage)
    roof.visible_shadow = False
    assert shadow(part, blender, floor, roof) == pytest.approx(1.0, abs=1e-3)


def volume(nodes, links):
    scatter, output = nodes.new("ShaderNodeVolumeScatter"), nodes.new("ShaderNodeOutputMaterial")
    links.new(scatter.outputs[0], output.inputs["Volume"])


def test_fog_is_no_surface(blender, part, scene, floor, stage):
    """It blocks no light, and its material is left alone."""
    material = stage.diffuse("Fog")
    material.node_tree.nodes.clear()
    volume(material.node_tree.nodes, material.node_tree.links)
    fog = stage.object_of("Fog", stage.cube(), material)
    assert shadow(part, blender, floor) == pytest.approx(1.0, abs=1e-3)
    fog.select_set(True)
    floor.select_set(True)
    blender.ops.prt.bake(mode="SHADOWED", samples=16)
    assert not list(part("shading").our_nodes(material.node_tree))


def test_outlines_do_not_blacken_what_they_enclose(blender, part, floor, stage):
    """A turned-over hull whose back faces are culled lets light in; from outside it blocks."""
    hull = stage.cube(1.5)
    hull.flip_normals()
    material = stage.diffuse("Outline")
    outline = stage.object_of("Outline", hull, material)
    assert shadow(part, blender, floor) < 0.01
    material.use_backface_culling = True
    outline.data.flip_normals()
    assert shadow(part, blender, floor) == pytest.approx(1.0, abs=1e-3)
    outline.data.flip_normals()
    assert shadow(part, blender, floor) < 0.01, "rays from within meet the fronts of a turned-over hull"


def strands_of(bpy, count, radius):
    """Upright hair over the floor."""
    curves = bpy.data.hair_curves.new("Grass")
    curves.add_curves([3] * count * count)
    points = np.random.default_rng(0).uniform(-1.0, 1.0, (count * count, 1, 2))
    heights = np.broadcast_to(np.array([0.02, 0.15, 0.3])[None, :, None], (len(points), 3, 1))
    position = np.concatenate([np.broadcast_to(points, (len(points), 3, 2)), heights], axis=-1)
    curves.attributes["position"].data.foreach_set("vector", position.astype(np.float32).ravel())
    curves.attributes.new("radius", "FLOAT", "POINT")
    curves.attributes["radius"].data.foreach_set("value", np.full(3 * len(points), radius, dtype=np.float32))
    ob = bpy.data.objects.new("Grass", curves)
    bpy.context.scene.collection.objects.link(ob)
    return ob


def test_hair_blocks_light_as_in_cycles(blender, scene, floor, stage, tmp_path):
    """The floor under grass, against Cycles."""
    floor.data = stage.grid(40, 0.5)
    strands_of(blender, 30, 0.01)
    floor.data.materials.append(stage.diffuse("White", (0.8, 0.8, 0.8)))
    floor.select_set(True)
    blender.ops.prt.bake(mode="SHADOWED", samples=256)
    camera = stage.top_camera(1.0, 32)
    camera.location.z = 0.2
    scene.cycles_curves.shape = "THICK"
    scene.cycles.max_bounces = scene.cycles.diffuse_bounces = 0
    for ob in scene.objects:
        ob.visible_camera = ob == floor
    truth = stage.render(tmp_path / "truth.exr", "CYCLES", 128)[..., :3].mean()
    blender.data.objects["Grass"].hide_render = True
    here = stage.render(tmp_path / "here.exr")[..., :3].mean()
    assert here == pytest.approx(truth, rel=0.06)


def test_points_block_light(blender, part, floor, stage):
    """A cloud of balls over the floor, as many and as large as its vertices say."""
    tree = blender.data.node_groups.new("Points", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    entry, leave = tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")
    points = tree.nodes.new("GeometryNodeMeshToPoints")
    points.inputs["Radius"].default_value = 0.3
    tree.links.new(entry.outputs[0], points.inputs[0])
    tree.links.new(points.outputs[0], leave.inputs[0])
    cloud = stage.object_of("Cloud", stage.grid(8, 2.0), location=(0, 0, 0.5))
    cloud.modifiers.new("Points", "NODES").node_group = tree
    assert 0.02 < shadow(part, blender, floor) < 0.3


def test_materials_that_nodes_set(blender, part, scene, stage):
    """They colour what bounces, they are relit, and restored."""
    stage.environment(stage.picture("Sky", stage.six_coloured_sky(16)))
    tree = blender.data.node_groups.new("Paint", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    entry, leave = tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")
    paint = tree.nodes.new("GeometryNodeSetMaterial")
    paint.inputs["Material"].default_value = red = stage.diffuse("Red", (0.9, 0.0, 0.0))
    tree.links.new(entry.outputs[0], paint.inputs[0])
    tree.links.new(paint.outputs[0], leave.inputs[0])
    ob = stage.object_of("Painted", stage.cube(), stage.diffuse("Grey", (0.5, 0.5, 0.5)))
    ob.modifiers.new("Paint", "NODES").node_group = tree
    plan = part("read").read_bake(blender.context, [ob], part("problem").BakeSettings("INTERREFLECTED"))
    np.testing.assert_allclose(plan.scene.occluders.albedo.constant, [[0.9, 0.0, 0.0]] * 12, rtol=1e-6)
    assert blender.ops.prt.bake(samples=16) == {"FINISHED"}
    assert list(part("shading").our_nodes(red.node_tree))
    blender.ops.prt.remove()
    assert not list(part("shading").our_nodes(red.node_tree))


def test_instances_are_named(blender, part, floor, stage):
    """They are in no layer of their own: how many, and what to do; none where their source is baked for itself."""
    collection_instances(blender, stage)
    [notice] = part("read").read_bake(blender.context, [floor]).notices
    assert notice.sentence.startswith("'Instancer' shows 1 instances: they block light")
    square = blender.data.objects["Square"]
    blender.context.scene.collection.objects.link(square)
    square.prt.space = "OBJECT"
    assert not part("read").read_bake(blender.context, [floor, square]).notices


def test_geometry_nodes_that_leave_instances_alone(blender, part, scene, floor, stage):
    """An object whose own geometry they replace has no faces: it is named, and its instances block light."""
    ob, _ = geometry_node_instances(blender, stage)
    ob.select_set(True)
    floor.select_set(True)
    assert blender.ops.prt.bake(mode="SHADOWED", samples=16) == {"FINISHED"}
    said = [one.sentence for one in part("session").session.notices[scene.session_uid]]
    assert "'Scattered' has no faces, and is not baked." in said
    assert any(one.startswith("'Scattered' shows 4 instances") for one in said)


def test_hair_of_particles_is_named(blender, part, scene, floor, stage):
    """It renders as strands, which nothing but a render knows: no shadow, and a sentence."""
    emitter = stage.object_of("Emitter", stage.grid(1, 0.5), location=(0, 0, 5))
    settings = emitter.modifiers.new("Hair", "PARTICLE_SYSTEM").particle_system.settings
    settings.type, settings.count = "HAIR", 10
    said = [notice.sentence for notice in part("read").read_bake(blender.context, [floor]).notices]
    assert any(one.startswith("'Emitter' has hair of particles") for one in said)
    settings.count = 0
    assert not part("read").read_bake(blender.context, [floor]).notices
