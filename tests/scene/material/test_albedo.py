# SPDX-License-Identifier: GPL-3.0-or-later
"""Albedo is read from real materials: colours, textures, attributes, and what light takes on from them."""

import numpy as np
import pytest

from tests.recording import recording
from tests.scene.material.materials import (
    lower_left_red,
    middle,
    node_into_colour,
    plan_albedo,
    principled,
    triangle_of,
)


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
    mine = triangle_of(plan, textured)
    (corner,) = plan.scene.occluders.vertices[plan.scene.occluders.triangles[mine]]
    nearest = int(np.argmin(corner[:, 0] + corner[:, 1]))  # the lower left corner, where the texel is red
    u, v = (np.array([1.0 if nearest == k else 0.0], dtype=np.float32) * 0.9 for k in (1, 2))
    np.testing.assert_allclose(albedo.at(mine, u, v), [[1, 0, 0]])

    coloured = stage.object_of("C", stage.grid(1, 1.0), stage.diffuse("Coloured"), (10, 0, 0))
    layer = coloured.data.color_attributes.new("Paint", "FLOAT_COLOR", "POINT")
    layer.data.foreach_set("color", np.tile([0.5, 0.25, 0.125, 1.0], len(layer.data)))
    tree = coloured.data.materials[0].node_tree
    node = tree.nodes.new("ShaderNodeVertexColor")
    node.layer_name = "Paint"
    tree.links.new(node.outputs["Color"], tree.nodes["Diffuse BSDF"].inputs["Color"])
    albedo, plan = plan_albedo(part, blender, coloured)
    np.testing.assert_allclose(albedo.at(triangle_of(plan, coloured), *middle()), [[0.5, 0.25, 0.125]], rtol=1e-6)


def test_colour_of_a_metal_and_of_what_is_transparent(blender, part, scene, stage):
    """Metallic and alpha change neither way of finding the colour."""
    colour = (0.6, 0.3, 0.1, 1.0)
    direct = principled(blender, Base_Color=colour, Metallic=1.0, Alpha=0.25)
    by_cycles = principled(blender, Metallic=1.0, Alpha=0.25)
    combined = node_into_colour(by_cycles, "ShaderNodeCombineColor", 0)
    for k in range(3):
        combined.inputs[k].default_value = colour[k]
    for material in (direct, by_cycles):
        ob = stage.object_of("Metal", stage.grid(1), material)
        albedo, _ = plan_albedo(part, blender, ob)
        np.testing.assert_allclose(albedo.at(np.array([0]), *middle()), [colour[:3]], rtol=1e-4)
        blender.data.objects.remove(ob)


def test_light_takes_on_the_colour_it_bounced_off(blender, part, scene, stage):
    """A red wall, unselected, beside a white floor: the floor turns red near it, and only there."""
    floor = stage.object_of("Floor", stage.grid(20, 2.0), stage.diffuse("White", (0.8, 0.8, 0.8)))
    wall = stage.object_of("Wall", stage.grid(20, 2.0), stage.diffuse("Red", (0.8, 0.05, 0.05)), (-2.0, 0, 1.0))
    wall.rotation_euler = (0, 1.5707963, 0)
    stage.environment(stage.picture("Constant", np.ones((8, 16, 3))))
    floor.select_set(True)
    blender.ops.prt.bake(mode="INTERREFLECTED", samples=256, bounces=3)
    transport = part("layers").read(floor.data)
    assert not part("layers").is_baked(wall.data)
    x = np.array([vertex.co.x for vertex in floor.data.vertices])
    redness = transport[:, 0, 0] / transport[:, 0, 2]
    near, far = redness[np.abs(x + 1.8) < 0.15].mean(), redness[x > 1.9].mean()
    assert near > 1.15 > 1.05 > far >= 1.0


@pytest.mark.parametrize("kind", ["POINT", "TEXTURE", "VECTOR"])
def test_a_mapped_texture_on_four_vertices(blender, part, scene, stage, kind):
    """The picture is looked up where Cycles does, and not at the vertices alone."""
    ob = stage.object_of("Floor", stage.grid(1, 1.0), stage.diffuse("Tiles"))
    layer = ob.data.uv_layers.new()
    layer.data.foreach_set("uv", np.array([[0, 0], [1, 0], [1, 1], [0, 1]], dtype=np.float32).ravel())
    tree = ob.data.materials[0].node_tree
    texture, mapping, uv = (tree.nodes.new(f"ShaderNode{name}") for name in ("TexImage", "Mapping", "UVMap"))
    texture.image = stage.picture("Texels", np.random.default_rng(3).random((16, 16, 3)))
    texture.interpolation = "Closest"
    mapping.vector_type = kind
    values = {"Location": (0.3, -0.2, 0.1), "Rotation": (0.2, -0.1, 0.7), "Scale": (1.7, 0.6, 1.0)}
    for name, value in values.items():
        if name in mapping.inputs:
            mapping.inputs[name].default_value = value
    tree.links.new(uv.outputs[0], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs[0], texture.inputs["Vector"])
    shader = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeBsdfDiffuse")
    tree.links.new(texture.outputs["Color"], shader.inputs["Color"])
    albedo, plan = plan_albedo(part, blender, ob)
    assert not plan.notices

    fine = stage.object_of("Fine", stage.grid(24, 1.0), ob.data.materials[0], (5, 0, 0))
    places = np.array([list(vertex.co) for vertex in fine.data.vertices])
    corner = np.array([loop.vertex_index for loop in fine.data.loops])
    fine.data.uv_layers.new().data.foreach_set("uv", ((places[corner, :2] + 1) / 2).astype(np.float32).ravel())
    request = part("cycles_colour").ColourRequest(
        fine.evaluated_get(blender.context.evaluated_depsgraph_get()),
        np.eye(4),
        {0: part("cycles_colour").Unread(ob.data.materials[0])},
    )
    truth = request.answer()
    request.close()
    corners = np.array([list(v.co) for v in ob.data.vertices])
    triangle_corner = [list(triangle.vertices) for triangle in ob.data.loop_triangles]
    inside, agree = 0, 0
    for row, vertices in enumerate(triangle_corner):
        a, b, c = corners[vertices][:, :2]
        uvs = np.linalg.solve(np.stack([b - a, c - a], axis=1), (places[:, :2] - a).T).T
        keep = (uvs > 0.01).all(axis=1) & (uvs.sum(axis=1) < 0.99)
        found = albedo.at(np.full(keep.sum(), row), *uvs[keep].T.astype(np.float32))
        by_vertex = np.zeros((len(places), 3))
        by_vertex[corner] = truth
        inside += keep.sum()
        agree += np.isclose(found, by_vertex[keep], atol=2e-3).all(axis=1).sum()
    assert inside > 400 and agree > 0.97 * inside, "texels' edges round either way"


def test_a_texture_is_decoded_once(blender, part, scene, stage, monkeypatch):
    """Twenty planes with one picture hold it once."""
    material = stage.diffuse("Tiles")
    texture = material.node_tree.nodes.new("ShaderNodeTexImage")
    texture.image = stage.picture("Texels", np.random.default_rng(3).random((16, 16, 3)))
    shader = next(node for node in material.node_tree.nodes if node.bl_idname == "ShaderNodeBsdfDiffuse")
    material.node_tree.links.new(texture.outputs["Color"], shader.inputs["Color"])
    for x in range(20):
        stage.object_of(f"Plane {x}", stage.grid(1), material, (3.0 * x, 0, 0)).data.uv_layers.new()
    module = part("patterns")
    read: list[object] = []
    monkeypatch.setattr(module, "linear_pixels", recording(module.linear_pixels, read))
    albedo, _ = plan_albedo(part, blender, scene.objects[0])
    assert len(read) == 1 and len(albedo.patterns) == 20
    assert len({id(pattern.image) for pattern in albedo.patterns}) == 1
