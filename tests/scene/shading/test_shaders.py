# SPDX-License-Identifier: GPL-3.0-or-later
"""Every shader node that Blender has is known, to those who read materials and to those who rebuild them; what is not is left as it is."""

from typing import Any

import numpy as np
import pytest

RED, BLUE = (1.0, 0.0, 0.0, 1.0), (0.0, 0.0, 1.0, 1.0)


@pytest.fixture
def shaders(part):
    return part("shaders")


@pytest.fixture
def lone(blender, scene, part, stage):
    """Relight a ball of a material whose surface is one node: the material, and the sentences."""

    def look(kind, name="Alone"):
        material = stage.diffuse(name)
        tree = material.node_tree
        node, output = tree.nodes.new(kind), tree.nodes["Material Output"]
        tree.links.new(next(one for one in node.outputs if one.type == "SHADER"), output.inputs["Surface"])
        ob = stage.object_of(name, stage.icosphere(1), material)
        return material, [notice.sentence for notice in part("shading").add_shading([ob])]

    return look


@pytest.fixture
def newer_shader(shaders, monkeypatch):
    """A shader node that nobody knows, as those are that a newer Blender will bring. EEVEE shows this one matte."""
    monkeypatch.delitem(shaders.SHADERS, "ShaderNodeBsdfSheen")
    return "ShaderNodeBsdfSheen"


def shader_nodes(blender):
    """All types of nodes in materials that give a shader by themselves."""
    tree = blender.data.node_groups.new("All", "ShaderNodeTree")
    found = {}
    for name in dir(blender.types):
        try:
            node = tree.nodes.new(name)
        except RuntimeError:  # no node, or one of other trees
            continue
        if any(output.type == "SHADER" for output in node.outputs):
            found[name] = node
    return found


def test_every_shader_node_is_known(blender, scene, shaders):
    """One that a new version of Blender brings fails here: it is to be built, or said to need nothing."""
    nodes = shader_nodes(blender)
    assert len(nodes) > 20
    assert set(nodes) == set(shaders.SHADERS) | shaders.COMBINING
    for name, shader in shaders.SHADERS.items():
        wanted = {shader.colour, *shader.glow} - {""}
        assert wanted <= set(nodes[name].inputs.keys()), name


def test_every_known_shader_is_built_or_needs_nothing(blender, part, shaders, lone):
    """What reflects shows the baked light, what does not or is glass stays as it is, and none is said to be unknown."""
    for kind, shader in shaders.SHADERS.items():
        material, sentences = lone(kind, kind)
        tree = material.node_tree
        helpers = [node for node in tree.nodes if "prt_part" in node and node.bl_idname == "ShaderNodeGroup"]
        assert bool(helpers) == (shader.relit != "UNCHANGED"), kind
        assert not any("cannot be relit" in sentence for sentence in sentences), kind
        if shader.relit == "UNCHANGED" and shader.through != "GLASS" and not kind.startswith("ShaderNodeVolume"):
            assert any("reflects no light" in sentence for sentence in sentences), kind


def test_what_is_unknown_is_left_and_named(blender, part, lone, newer_shader):
    """Nothing of ours is in the material, which is not turned grey."""
    material, sentences = lone(newer_shader)
    assert not list(part("our_nodes").our_nodes(material.node_tree))
    assert [one for one in sentences if "'Sheen BSDF' cannot be relit, and EEVEE goes on showing it as it is" in one]
    assert not any("grey" in one for one in sentences)


def test_what_is_known_beside_it_is_relit(blender, part, stage, scene, newer_shader, tmp_path):
    """Half of a surface: under an open sky of one colour both halves look as before.

    EEVEE draws lots for which of two matte shaders it shows, sample by sample.
    """
    material = stage.diffuse(colour=RED[:3])
    tree = material.node_tree
    mix, other = tree.nodes.new("ShaderNodeMixShader"), tree.nodes.new(newer_shader)
    tree.links.new(tree.nodes["Diffuse BSDF"].outputs[0], mix.inputs[1])
    other.inputs["Color"].default_value = BLUE
    tree.links.new(other.outputs[0], mix.inputs[2])
    tree.links.new(mix.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
    stage.object_of("Floor", stage.grid(2, 2.0), material)
    stage.environment(stage.picture("Constant", np.ones((8, 16, 3))))
    stage.top_camera(2.0, 8)
    scene.eevee.taa_render_samples = 64
    before = stage.render(tmp_path / "before.exr")[..., :3].mean(axis=(0, 1))
    assert blender.ops.prt.bake(mode="UNSHADOWED") == {"FINISHED"}
    after = stage.render(tmp_path / "after.exr")[..., :3].mean(axis=(0, 1))
    np.testing.assert_allclose(after, before, atol=3e-2)
    assert "PRT Diffuse" in blender.data.node_groups
    np.testing.assert_allclose(before, (0.5, 0.0, 0.5), atol=3e-2)


def test_a_tower_of_mixes_is_relit_as_far_as_it_is_read(blender, part, stage, scene):
    """What lies deeper is shown as it is, and said."""
    material = stage.diffuse()
    tree = material.node_tree
    shader = tree.nodes["Diffuse BSDF"].outputs[0]
    for _ in range(130):
        node = tree.nodes.new("ShaderNodeAddShader")
        tree.links.new(shader, node.inputs[0])
        shader = node.outputs[0]
    tree.links.new(shader, tree.nodes["Material Output"].inputs["Surface"])
    [notice] = part("shading").add_shading([stage.object_of("Ball", stage.icosphere(1), material)])
    assert "what is mixed more than 100 deep cannot be relit" in notice.sentence


SPECULAR: dict[str, dict[str, Any]] = {
    "plain": {"Specular": (0.3, 0.2, 0.1, 1.0), "Roughness": 0.5},
    "glowing": {"Emissive Color": (0.1, 0.2, 0.4, 1.0)},
    "thin": {"Transparency": 0.4, "Emissive Color": (0.1, 0.2, 0.4, 1.0), "Specular": (0.5, 0.5, 0.5, 1.0)},
    "coated": {"Clear Coat": 1.0, "Clear Coat Roughness": 0.3},
}


@pytest.fixture
def specular(blender, stage):
    """A material of a Specular BSDF."""

    def make(**values):
        material = stage.diffuse("Specular")
        tree = material.node_tree
        shader = tree.nodes.new("ShaderNodeEeveeSpecular")
        for name, value in {"Base Color": (0.4, 0.2, 0.1, 1.0), **values}.items():
            shader.inputs[name].default_value = value
        tree.links.new(shader.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
        return material

    return make


@pytest.mark.parametrize("case", SPECULAR)
def test_specular_in_the_open_is_as_eevee_shows_it(blender, stage, scene, specular, tmp_path, case):
    """Under a sky of one colour, which nothing hides, the baked light is EEVEE's own."""
    stage.object_of("Floor", stage.grid(2, 2.0), specular(**SPECULAR[case]))
    stage.environment(stage.picture("Constant", np.ones((8, 16, 3))), 0.6)
    stage.top_camera(2.0, 8)
    before = stage.render(tmp_path / "before.exr")[4, 4]
    assert blender.ops.prt.bake(mode="SHADOWED", samples=256) == {"FINISHED"}
    np.testing.assert_allclose(stage.render(tmp_path / "after.exr")[4, 4], before, atol=1e-2)


def test_specular_in_a_closed_room_is_black(blender, stage, scene, specular, tmp_path):
    """Neither diffuse nor as gloss does EEVEE's own light of the sky show; what lets light through goes on doing so."""
    stage.environment(stage.picture("Constant", np.ones((8, 16, 3))))
    room = stage.object_of("Room", stage.cube(4.0), specular(Roughness=0.5, **{"Clear Coat": 1.0}))
    room.data.flip_normals()
    stage.top_camera(1.0)
    scene.camera.location = (0.0, 0.0, 1.5)
    assert blender.ops.prt.bake(mode="INTERREFLECTED", samples=64) == {"FINISHED"}
    frame = stage.render(tmp_path / "room.exr")
    assert frame[..., :3].max() < 5e-3
    assert frame[..., 3].min() > 0.99
