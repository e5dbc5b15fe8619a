# SPDX-License-Identifier: GPL-3.0-or-later
"""Hair, points and what geometry nodes make block light, or are named where they cannot take part."""

import numpy as np
import pytest

from tests.scene.bake.builders import collection_instances, geometry_node_instances
from tests.scene.bake.measures import shadow


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
    assert list(part("our_nodes").our_nodes(red.node_tree))
    blender.ops.prt.remove()
    assert not list(part("our_nodes").our_nodes(red.node_tree))


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
    """It renders as strands, which nothing but a render has: no shadow, and a sentence."""
    emitter = stage.object_of("Emitter", stage.grid(1, 0.5), location=(0, 0, 5))
    settings = emitter.modifiers.new("Hair", "PARTICLE_SYSTEM").particle_system.settings
    settings.type, settings.count = "HAIR", 10
    said = [notice.sentence for notice in part("read").read_bake(blender.context, [floor]).notices]
    assert any(one.startswith("'Emitter' has hair of particles") for one in said)
    settings.count = 0
    assert not part("read").read_bake(blender.context, [floor]).notices
