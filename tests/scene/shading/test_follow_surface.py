# SPDX-License-Identifier: GPL-3.0-or-later
"""Relit surfaces keep pace with the user's own, and with the lamps of the file."""

from tests.scene.shading.test_surfaces import lamp, principled


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


def test_settings_of_shaders_are_followed(blender, part, scene, stage):
    """Numbers and choices of a Principled BSDF; what is linked anew is rebuilt."""
    material = principled(blender)
    ob = stage.object_of("Cube", stage.cube(), material)
    part("shading").add_shading([ob])
    tree = material.node_tree
    own = tree.nodes["Principled BSDF"]

    def copies():
        return [node for node in tree.nodes if node.get("prt_copy_of") == own.name]

    own.inputs["Roughness"].default_value, own.inputs["Alpha"].default_value = 0.125, 0.75
    own.distribution = "GGX"
    blender.context.view_layer.update()
    assert len(copies()) == 2
    for copy in copies():
        assert copy.inputs["Roughness"].default_value == 0.125 and copy.inputs["Alpha"].default_value == 0.75
    assert [copy.distribution for copy in copies() if copy.bl_idname == own.bl_idname] == ["GGX"]
    value = tree.nodes.new("ShaderNodeValue")
    tree.links.new(value.outputs[0], own.inputs["Metallic"])
    blender.context.view_layer.update()
    assert all(copy.inputs["Metallic"].links[0].from_node == value for copy in copies())


def test_the_first_lamp_is_followed(blender, part, scene, stage):
    """Where there are no lamps, their light takes no node, and EEVEE no time."""
    material = principled(blender)
    ob = stage.object_of("Cube", stage.cube(), material)
    part("shading").add_shading([ob])

    def asks_for_lamps():
        groups = [node.node_tree for node in material.node_tree.nodes if node.bl_idname == "ShaderNodeGroup"]
        return any(tree.get("prt_part") == "PRT Lamps" for tree in groups)

    assert not asks_for_lamps()
    light = lamp(blender, "POINT", 10.0)
    blender.context.view_layer.update()
    assert asks_for_lamps()
    blender.data.objects.remove(light)
    blender.context.view_layer.update()
    assert not asks_for_lamps()
