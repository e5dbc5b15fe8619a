# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials get the relight group beside their own nodes, and are given back as they were."""

import numpy as np
import pytest


def test_add_remove_add_restores_the_tree(blender, part, scene, stage):
    """Node by node, setting by setting, link by link."""
    shading = part("shading")
    ob = stage.object_of("Cube", stage.cube(), stage.diffuse())
    tree = ob.data.materials[0].node_tree
    before = stage.node_snapshot(tree)
    for _ in range(2):
        shading.add_shading([ob])
        assert stage.node_snapshot(tree) != before
        assert tree.get_output_node("CYCLES").name in before[0], "Cycles renders the user's own"
        shading.remove_shading([ob])
        assert stage.node_snapshot(tree) == before


def test_adding_twice_is_adding_once(part, scene, stage):
    """A second bake replaces the nodes instead of piling them up."""
    shading = part("shading")
    ob = stage.object_of("Cube", stage.cube(), stage.diffuse())
    shading.add_shading([ob])
    once = stage.node_snapshot(ob.data.materials[0].node_tree)
    shading.add_shading([ob])
    assert stage.node_snapshot(ob.data.materials[0].node_tree) == once


def test_own_eevee_output_becomes_active_again(part, scene, stage):
    """A material that had an EEVEE output of its own gets it back."""
    shading = part("shading")
    ob = stage.object_of("Cube", stage.cube(), stage.diffuse())
    tree = ob.data.materials[0].node_tree
    own = tree.nodes.new("ShaderNodeOutputMaterial")
    own.target = "EEVEE"
    tree.links.new(tree.nodes["Diffuse BSDF"].outputs[0], own.inputs["Surface"])
    before = stage.node_snapshot(tree)
    shading.add_shading([ob])
    assert tree.get_output_node("EEVEE") != own
    shading.remove_shading([ob])
    assert tree.get_output_node("EEVEE") == own
    assert before[0] == stage.node_snapshot(tree)[0]
    assert stage.node_snapshot(tree) == before


def test_objects_without_material_get_one_and_lose_it(blender, part, scene, stage):
    """No slot, or an empty slot: both are as before after removal."""
    shading = part("shading")
    bare = stage.object_of("Bare", stage.cube())
    empty = stage.object_of("Empty", stage.cube())
    empty.data.materials.append(None)
    shading.add_shading([bare, empty])
    assert bare.data.materials[0] and bare.data.materials[0] == empty.data.materials[0]
    shading.remove_shading([bare, empty])
    assert len(bare.data.materials) == 0
    assert list(empty.data.materials) == [None]
    assert not blender.data.materials


def test_material_of_other_baked_objects_stays_hooked_up(blender, part, scene, stage):
    """Removing one object leaves the material that another baked object shows."""
    material = stage.diffuse()
    one = stage.object_of("One", stage.cube(), material)
    stage.object_of("Two", stage.cube(), material, (4, 0, 0))
    stage.environment(stage.picture("Sky", stage.six_coloured_sky(16)))
    blender.ops.prt.bake(mode="UNSHADOWED")
    one.select_set(True)
    blender.ops.prt.remove()
    shading = part("shading")
    assert list(shading.our_nodes(material.node_tree))
    assert not part("layers").is_baked(one.data)


def test_group_stays_within_eevees_attribute_limit(part, scene):
    """Nine mesh attributes: five are left for the user's UV maps and layers."""
    tree = part("relight_group").relight_group()
    mesh_layers = {n.attribute_name for n in tree.nodes if getattr(n, "attribute_type", "") == "GEOMETRY"}
    assert len(mesh_layers) == 9


def test_numbers_are_followed(blender, part, scene, stage):
    """Edit the number, keyframe it, link a node, unlink it: the relit surface keeps pace."""
    ob = stage.object_of("Cube", stage.cube(), stage.diffuse(colour=(0.1, 0.2, 0.3)))
    part("shading").add_shading([ob])
    tree = ob.data.materials[0].node_tree
    albedo = tree.nodes["Diffuse BSDF"].inputs["Color"]

    def ours():
        [helper] = [node for node in tree.nodes if node.get("prt_copy_of") == "Diffuse BSDF"]
        return helper.inputs["Color"]

    assert tuple(ours().default_value) == tuple(albedo.default_value)
    for frame, colour in ((1, (0.5, 0.5, 0.5, 1.0)), (2, (0.25, 0.75, 0.5, 1.0))):
        albedo.default_value = colour
        blender.context.view_layer.update()
        assert tuple(ours().default_value) == colour
        albedo.keyframe_insert("default_value", frame=frame)
    scene.frame_set(1)
    assert tuple(ours().default_value) == (0.5, 0.5, 0.5, 1.0)
    node = tree.nodes.new("ShaderNodeRGB")
    link = tree.links.new(node.outputs[0], albedo)
    blender.context.view_layer.update()
    assert ours().links[0].from_node == node
    tree.links.remove(link)
    blender.context.view_layer.update()
    assert not ours().is_linked


def test_material_without_nodes_keeps_its_colour_and_gets_them_off_again(blender, part, scene, stage, tmp_path):
    """Before 5.0 a material can be its viewport colour alone: shown, bounced, and given back so; Cycles shows it, too."""
    if blender.app.version >= (5, 0, 0):
        pytest.skip("all materials have nodes")
    material = blender.data.materials.new("Plain")
    material.diffuse_color = (0.1, 0.2, 0.3, 1.0)
    ob = stage.object_of("Cube", stage.cube(), material)
    stage.environment(stage.picture("Sky", stage.six_coloured_sky(16)))
    stage.top_camera(resolution=16)
    before = stage.render(tmp_path / "before.exr", "CYCLES", 4)
    part("shading").add_shading([ob])
    np.testing.assert_array_equal(stage.render(tmp_path / "after.exr", "CYCLES", 4), before)
    unbaked = stage.render(tmp_path / "unbaked.exr")[8, 8, :3]
    np.testing.assert_allclose(unbaked / unbaked.sum(), before[8, 8, :3] / before[8, 8, :3].sum(), atol=0.03)
    group = next(node for node in part("shading").our_nodes(material.node_tree) if node.type == "GROUP")
    assert tuple(group.inputs["Base Color"].default_value) == tuple(material.diffuse_color)
    albedo = (
        part("read")
        .read_bake(blender.context, [ob], part("problem").BakeSettings("INTERREFLECTED"))
        .scene.occluders.albedo
    )
    assert tuple(albedo.constant[0]) == tuple(material.diffuse_color)[:3]
    material.diffuse_color = (0.4, 0.2, 0.1, 1.0)
    blender.context.view_layer.update()
    part("shading").follow_surface(material)
    recoloured = stage.render(tmp_path / "recoloured.exr", "CYCLES", 4)[8, 8, :3]
    np.testing.assert_allclose(recoloured / before[8, 8, :3], (4, 1, 1 / 3), rtol=1e-3)
    part("shading").remove_shading([ob])
    assert not part("nodes").nodes_are_on(material)
    assert not list(part("shading").our_nodes(material.node_tree))


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
    """Nine of transport and five of the material; one more is pink, so that the material is left alone, and named."""
    stage.environment(stage.picture("Sky", stage.six_coloured_sky(16)))
    ob = stage.object_of("Ball", stage.icosphere(2), reading(blender, stage, "Painted", count))
    for number in range(count):
        layer = ob.data.color_attributes.new(f"Paint {number}", "FLOAT_COLOR", "POINT")
        layer.data.foreach_set("color", np.tile([0.02, 0.1, 0.02, 1.0], len(layer.data)))
    stage.top_camera(resolution=16)
    blender.ops.prt.bake(mode="UNSHADOWED")
    relit = list(part("shading").our_nodes(ob.data.materials[0].node_tree))
    said = [one.sentence for one in part("session").session.notices[scene.session_uid]]
    assert bool(relit) == (count == 5)
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
