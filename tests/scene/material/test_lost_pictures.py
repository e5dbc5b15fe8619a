# SPDX-License-Identifier: GPL-3.0-or-later
"""A missing image shows pink in Cycles; light takes on the viewport colour instead, and the picture is named."""

import numpy as np
import pytest

from tests.scene.material.materials import (
    lower_left_red,
    middle,
    node_into_colour,
    plan_albedo,
    sentences,
)


def test_missing_image_is_not_pink(blender, part, scene, stage):
    """Cycles shows it in pink; light must not take that on."""
    material = stage.diffuse("Torn")
    material.diffuse_color = (0.2, 0.4, 0.6, 1.0)
    node = node_into_colour(material, "ShaderNodeTexImage", "Color")
    node.image = blender.data.images.new("Lost", 1, 1)
    node.image.source, node.image.filepath = "FILE", "//lost.png"
    ob = stage.object_of("A", stage.grid(1, 1.0), material)
    lower_left_red(ob)
    albedo, plan = plan_albedo(part, blender, ob)
    np.testing.assert_allclose(albedo.at(np.array([0]), *middle()), [[0.2, 0.4, 0.6]], rtol=1e-6)
    assert "'Lost' cannot be read" in sentences(plan)[0] and "viewport colour" in sentences(plan)[0]


@pytest.mark.parametrize("where", ["mix of shaders", "box projection", "group", "no image"])
def test_lost_pictures_behind_other_nodes_are_not_pink(blender, part, scene, stage, where):
    """Wherever the picture is missing, Cycles does not evaluate a colour that it can only show in pink."""
    material = stage.diffuse("Torn")
    material.diffuse_color = (0.2, 0.4, 0.6, 1.0)
    lost = blender.data.images.new("Lost", 1, 1)
    lost.source, lost.filepath = "FILE", "//lost.png"
    tree = material.node_tree
    if where == "group":
        group = blender.data.node_groups.new("Paint", "ShaderNodeTree")
        group.interface.new_socket("Color", in_out="OUTPUT", socket_type="NodeSocketColor")
        node, output = group.nodes.new("ShaderNodeTexImage"), group.nodes.new("NodeGroupOutput")
        group.links.new(node.outputs["Color"], output.inputs[0])
        outer = tree.nodes.new("ShaderNodeGroup")
        outer.node_tree = group
        tree.links.new(outer.outputs[0], tree.nodes["Diffuse BSDF"].inputs["Color"])
    else:
        node = node_into_colour(material, "ShaderNodeTexImage", "Color")
    node.image = None if where == "no image" else lost
    if where == "box projection":
        node.projection = "BOX"
    if where == "mix of shaders":
        mix, other = tree.nodes.new("ShaderNodeMixShader"), tree.nodes.new("ShaderNodeBsdfDiffuse")
        tree.links.new(tree.nodes["Diffuse BSDF"].outputs[0], mix.inputs[1])
        tree.links.new(other.outputs[0], mix.inputs[2])
        tree.links.new(mix.outputs[0], next(one for one in tree.nodes if one.type == "OUTPUT_MATERIAL").inputs[0])
    ob = stage.object_of("A", stage.grid(1, 1.0), material)
    lower_left_red(ob)
    albedo, plan = plan_albedo(part, blender, ob)
    np.testing.assert_allclose(albedo.at(np.array([0]), *middle()), [[0.2, 0.4, 0.6]], rtol=1e-6)
    named = "no image is chosen" if where == "no image" else "'Lost' cannot be read"
    assert named in sentences(plan)[0] and "viewport colour" in sentences(plan)[0]


def test_lost_pictures_of_many_materials_are_named_as_such(blender, part, scene, stage):
    """Counted by kind, the sentence still says what is wrong and where Blender mends it."""
    lost = blender.data.images.new("Lost", 1, 1)
    lost.source, lost.filepath = "FILE", "//lost.png"
    for name in "AB":
        material = stage.diffuse(f"Torn {name}")
        node_into_colour(material, "ShaderNodeTexImage", "Color").image = lost
        ob = stage.object_of(name, stage.grid(1, 1.0), material)
    _, plan = plan_albedo(part, blender, ob)
    [sentence] = [one.sentence for one in part("notices").counted(plan.notices)]
    assert sentence.startswith("2 materials have lost their pictures") and "Find Missing Files" in sentence
    assert "'Torn A'" in sentence and "'Torn B'" in sentence
