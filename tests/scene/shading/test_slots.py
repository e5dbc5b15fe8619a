# SPDX-License-Identifier: GPL-3.0-or-later
"""EEVEE takes 14 attributes of a mesh: what materials read of them is counted as it counts."""

import numpy as np
import pytest


def test_group_stays_within_eevees_attribute_limit(part, scene):
    """Nine mesh attributes: five are left for the user's UV maps and layers."""
    tree = part("relight_group").relight_group()
    mesh_layers = {n.attribute_name for n in tree.nodes if getattr(n, "attribute_type", "") == "GEOMETRY"}
    assert len(mesh_layers) == 9


def reading(bpy, stage, name, count):
    """A material that adds up so many colour attributes, over a normal map and UVs."""
    material = stage.diffuse(name)
    tree = material.node_tree
    total = None
    for number in range(count):
        attribute = tree.nodes.new("ShaderNodeVertexColor")
        attribute.layer_name = f"Paint {number}"
        add = tree.nodes.new("ShaderNodeVectorMath")
        tree.links.new(attribute.outputs["Color"], add.inputs[0])
        if total:
            tree.links.new(total, add.inputs[1])
        total = add.outputs[0]
    shader = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeBsdfDiffuse")
    tree.links.new(total, shader.inputs["Color"])
    return material


@pytest.mark.parametrize("count", [5, 6])
def test_eevee_takes_fourteen_attributes(blender, part, scene, stage, tmp_path, count):
    """Nine of transport and five of the material; one more is pink, so that such a material reads no transport, and is named."""
    stage.environment(stage.picture("Sky", stage.six_coloured_sky(16)))
    ob = stage.object_of("Ball", stage.icosphere(2), reading(blender, stage, "Painted", count))
    for number in range(count):
        layer = ob.data.color_attributes.new(f"Paint {number}", "FLOAT_COLOR", "POINT")
        layer.data.foreach_set("color", np.tile([0.02, 0.1, 0.02, 1.0], len(layer.data)))
    stage.top_camera(resolution=16)
    blender.ops.prt.bake(mode="UNSHADOWED")
    group = next(node for node in ob.data.materials[0].node_tree.nodes if node.name == "PRT Relight").node_tree
    read = [node for node in group.nodes if getattr(node, "attribute_type", "") == "GEOMETRY"]
    said = [one.sentence for one in part("session").session.notices[scene.session_uid]]
    assert len(read) == (9 if count == 5 else 0)
    assert any("reads 6 attributes" in one for one in said) == (count == 6)
    red, green, blue, _ = stage.render(tmp_path / "ball.exr")[8, 8]
    assert green > red and green > blue, "not pink"


def test_attributes_are_counted_as_eevee_does(part, scene, stage):
    """UV maps once, however often; Generated coordinates twice; a Normal Map's tangent; inside of groups."""
    import bpy

    material = stage.diffuse("All")
    tree = material.node_tree
    group = bpy.data.node_groups.new("Group", "ShaderNodeTree")
    group.interface.new_socket("Color", in_out="OUTPUT", socket_type="NodeSocketColor")
    noise, end = group.nodes.new("ShaderNodeTexNoise"), group.nodes.new("NodeGroupOutput")
    group.links.new(noise.outputs[1], end.inputs[0])
    node, image, normal, uv = (
        tree.nodes.new(f"ShaderNode{kind}") for kind in ("Group", "TexImage", "NormalMap", "UVMap")
    )
    node.node_tree = group
    shader = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeBsdfDiffuse")
    mix = tree.nodes.new("ShaderNodeVectorMath")
    tree.links.new(node.outputs[0], mix.inputs[0])
    tree.links.new(image.outputs[0], mix.inputs[1])
    tree.links.new(mix.outputs[0], shader.inputs["Color"])
    tree.links.new(normal.outputs[0], shader.inputs["Normal"])
    output = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeOutputMaterial")
    assert len(part("slots").attributes_read(output)) == 2 + 1 + 1
    tree.links.new(uv.outputs[0], image.inputs["Vector"])
    assert len(part("slots").attributes_read(output)) == 2 + 1 + 1


def with_everything(bpy, stage, count):
    """A material of a Principled BSDF that reads so many colour attributes, with a bent normal and an alpha."""
    material = reading(bpy, stage, "Everything", count)
    tree = material.node_tree
    old = tree.nodes["Diffuse BSDF"]
    shader, bump = tree.nodes.new("ShaderNodeBsdfPrincipled"), tree.nodes.new("ShaderNodeBump")
    tree.links.new(old.inputs["Color"].links[0].from_socket, shader.inputs["Base Color"])
    tree.links.new(bump.outputs[0], shader.inputs["Normal"])
    tree.links.new(shader.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
    tree.nodes.remove(old)
    shader.inputs["Coat Weight"].default_value, shader.inputs["Alpha"].default_value = 0.5, 0.9
    return material


def attributes_in(tree, kind, names=None):
    """Names of the attributes of a kind that a node tree reads, in nested groups, too."""
    names = set() if names is None else names
    for node in tree.nodes:
        if getattr(node, "node_tree", None):
            attributes_in(node.node_tree, kind, names)
        elif node.bl_idname == "ShaderNodeVertexColor" and kind == "GEOMETRY":
            names.add(node.layer_name)
        elif node.bl_idname == "ShaderNodeAttribute" and node.attribute_type == kind:
            names.add(node.attribute_name)
    return names


@pytest.mark.parametrize(("count", "backs"), [(2, 3), (3, 0), (5, 0)])
def test_attributes_of_a_material_with_everything_on(blender, part, scene, stage, tmp_path, count, backs):
    """Lamps, backs, reflections: thirteen of the View Layer and fourteen of the mesh at most, and EEVEE does not show it pink."""
    stage.environment(stage.picture("Sunny", stage.sunny_sky()))
    ob = stage.object_of("Sheet", stage.grid(8), with_everything(blender, stage, count))
    for number in range(count):
        layer = ob.data.color_attributes.new(f"Paint {number}", "FLOAT_COLOR", "POINT")
        layer.data.foreach_set("color", np.tile([0.02, 0.1, 0.02, 1.0], len(layer.data)))
    stage.top_camera(resolution=16)
    blender.ops.prt.bake(mode="SHADOWED", samples=16, lamps="AUTO")
    blender.ops.prt.add_reflections()
    assert [light.users for light in blender.data.lights] == [1]
    tree = ob.data.materials[0].node_tree
    assert len(attributes_in(tree, "VIEW_LAYER")) == 13
    of_the_mesh = attributes_in(tree, "GEOMETRY")
    assert sum(name.startswith("_PRT_B") for name in of_the_mesh) == backs
    assert len(of_the_mesh) == 9 + backs + count <= 14
    assert len(part("slots").attributes_read(tree.get_output_node("EEVEE"))) <= 14
    red, green, blue, _ = stage.render(tmp_path / "sheet.exr")[8, 8]
    assert green > red and green > blue, "not pink"
