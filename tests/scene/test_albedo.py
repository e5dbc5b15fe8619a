# SPDX-License-Identifier: GPL-3.0-or-later
"""Albedo as light finds it: constants, textures and colour attributes of real materials."""

import numpy as np


def plan_albedo(part, bpy, ob):
    plan = part("scene.gather").gather(bpy.context, [ob], bounces=True)
    return plan.occluders.albedo, plan


def test_constant_texture_and_attribute(blender, part, scene, stage):
    """Three objects, three kinds; looked up at the middle of a triangle."""
    plain = stage.object_of("A", stage.grid(1, 1.0), stage.diffuse(colour=(0.1, 0.2, 0.3)))
    albedo, _ = plan_albedo(part, blender, plain)
    np.testing.assert_allclose(albedo.at(np.array([0]), *middle()), [[0.1, 0.2, 0.3]], rtol=1e-6)

    textured = stage.object_of("B", stage.grid(1, 1.0), stage.diffuse("Textured"), (5, 0, 0))
    lower_left_red(textured)
    tree = textured.data.materials[0].node_tree
    texture = tree.nodes.new("ShaderNodeTexImage")
    texels = np.zeros((2, 2, 3))
    texels[0, 0] = (1.0, 0.0, 0.0)
    texture.image, texture.interpolation = stage.picture("Texels", texels), "Closest"
    tree.links.new(texture.outputs["Color"], tree.nodes["Diffuse BSDF"].inputs["Color"])
    albedo, plan = plan_albedo(part, blender, textured)
    corner = plan.occluders.vertices[plan.occluders.triangles[0]]
    nearest = int(np.argmin(corner[:, 0] + corner[:, 1]))  # the lower left corner, where the texel is red
    u, v = (np.array([1.0 if nearest == k else 0.0], dtype=np.float32) * 0.9 for k in (1, 2))
    np.testing.assert_allclose(albedo.at(np.array([0]), u, v), [[1, 0, 0]])

    coloured = stage.object_of("C", stage.grid(1, 1.0), stage.diffuse("Coloured"), (10, 0, 0))
    layer = coloured.data.color_attributes.new("Paint", "FLOAT_COLOR", "POINT")
    layer.data.foreach_set("color", np.tile([0.5, 0.25, 0.125, 1.0], len(layer.data)))
    tree = coloured.data.materials[0].node_tree
    node = tree.nodes.new("ShaderNodeVertexColor")
    node.layer_name = "Paint"
    tree.links.new(node.outputs["Color"], tree.nodes["Diffuse BSDF"].inputs["Color"])
    albedo, _ = plan_albedo(part, blender, coloured)
    np.testing.assert_allclose(albedo.at(np.array([0]), *middle()), [[0.5, 0.25, 0.125]], rtol=1e-6)


def middle():
    return np.full((2, 1), 1 / 3, dtype=np.float32)


def lower_left_red(ob):
    """UVs that lay the picture over the grid of size 2."""
    mesh = ob.data
    mesh.uv_layers.new()
    co = np.array([mesh.vertices[loop.vertex_index].co[:2] for loop in mesh.loops])
    mesh.uv_layers.active.data.foreach_set("uv", (co / 2 + 0.5).ravel())


def test_unknown_nodes_are_said(blender, part, scene, stage):
    """A procedural colour cannot be followed: the person is told which, and what is taken instead."""
    ob = stage.object_of("A", stage.grid(1, 1.0), stage.diffuse("Noisy"))
    material = ob.data.materials[0]
    material.diffuse_color = (0.2, 0.4, 0.6, 1.0)
    noise = material.node_tree.nodes.new("ShaderNodeTexNoise")
    material.node_tree.links.new(noise.outputs["Color"], material.node_tree.nodes["Diffuse BSDF"].inputs["Color"])
    albedo, plan = plan_albedo(part, blender, ob)
    np.testing.assert_allclose(albedo.constant[0], (0.2, 0.4, 0.6), rtol=1e-6)
    assert len(plan.warnings) == 1 and "Noisy" in plan.warnings[0] and "Noise Texture" in plan.warnings[0]


def test_light_takes_on_the_colour_it_bounced_off(blender, part, scene, stage):
    """A red wall, unselected, beside a white floor: the floor turns red near it, and only there."""
    floor = stage.object_of("Floor", stage.grid(20, 2.0), stage.diffuse("White", (0.8, 0.8, 0.8)))
    wall = stage.object_of("Wall", stage.grid(20, 2.0), stage.diffuse("Red", (0.8, 0.05, 0.05)), (-2.0, 0, 1.0))
    wall.rotation_euler = (0, 1.5707963, 0)
    stage.environment(stage.picture("Constant", np.ones((8, 16, 3))))
    floor.select_set(True)
    blender.ops.prt.bake(mode="INTERREFLECTED", samples=256, bounces=3)
    transport = part("scene.transport_layers").read(floor.data)
    assert not part("scene.transport_layers").is_baked(wall.data)
    x = np.array([vertex.co.x for vertex in floor.data.vertices])
    redness = transport[:, 0, 0] / transport[:, 0, 2]
    near, far = redness[np.abs(x + 1.8) < 0.15].mean(), redness[x > 1.9].mean()
    assert near > 1.15 > 1.05 > far >= 1.0
