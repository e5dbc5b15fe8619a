# SPDX-License-Identifier: GPL-3.0-or-later
"""Of several Material Outputs the user's active one counts, before, while and after a material is relit."""

import pytest

RED, GREEN, BLUE = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


@pytest.fixture
def material(scene, stage):
    """On a cube: two outputs for all engines, of which the second is active."""
    made = stage.diffuse(colour=RED)
    made.node_tree.nodes["Material Output"].name = "First"
    add_output(made.node_tree, "Second", BLUE).is_active_output = True
    stage.object_of("Cube", stage.cube(), made)
    return made


def add_output(tree, name, colour, target="ALL"):
    """A Material Output of a matte surface, after all that are there."""
    shader, output = tree.nodes.new("ShaderNodeBsdfDiffuse"), tree.nodes.new("ShaderNodeOutputMaterial")
    shader.inputs["Color"].default_value = (*colour, 1.0)
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    output.name, output.target = name, target
    return output


@pytest.fixture
def shown(blender, part):
    """The colours that EEVEE relights and that Cycles shows of a material."""

    def colours(tree):
        blender.context.view_layer.update()
        ours = tree.get_output_node("EEVEE")
        assert "prt_were_active" in ours, "EEVEE shows another than ours"
        mix = ours.inputs["Surface"].links[0].from_node
        source = mix.inputs[1].links[0].from_socket if mix.inputs[1].is_linked else None
        cycles = tree.get_output_node("CYCLES").inputs["Surface"].links[0].from_node
        return source and colour_of(source.node), colour_of(cycles)

    return colours


def colour_of(shader):
    return tuple(shader.inputs["Color"].default_value)[:3]


def active(tree):
    return [node.name for node in tree.nodes if getattr(node, "is_active_output", False)]


def test_each_engine_shows_the_active_one(blender, part, stage, material, shown):
    """It stays active, and nothing of the user's is marked."""
    tree, before = material.node_tree, stage.node_snapshot(material.node_tree)
    part("shading").add_shading(blender.data.objects[:])
    assert shown(tree) == (BLUE, BLUE)
    assert active(tree) == ["Second"] and not list(tree.nodes["Second"].keys())
    part("shading").remove_shading(blender.data.objects[:])
    assert stage.node_snapshot(tree) == before


def test_renamed_while_relit(blender, part, material, shown):
    tree = material.node_tree
    part("shading").add_shading(blender.data.objects[:])
    tree.nodes["First"].name, tree.nodes["Second"].name = "Other", "First"
    assert shown(tree) == (BLUE, BLUE)
    part("shading").remove_shading(blender.data.objects[:])
    assert active(tree) == ["First"]


def test_another_is_made_active_while_relit(blender, part, material, shown):
    """By the user, in either way that Blender has, or as the active one is deleted. Remove leaves it so."""
    tree = material.node_tree
    part("shading").add_shading(blender.data.objects[:])
    tree.nodes["First"].is_active_output = True
    assert shown(tree) == (RED, RED)
    tree.nodes.active = add_output(tree, "Third", GREEN)
    assert shown(tree) == (GREEN, GREEN)
    tree.nodes.remove(tree.nodes["Third"])
    assert shown(tree) == (RED, RED)
    tree.nodes.active = tree.get_output_node("EEVEE")  # a click on ours, which is no wish to see another
    assert shown(tree) == (RED, RED)
    tree.nodes["Second"].is_active_output = True
    part("shading").remove_shading(blender.data.objects[:])
    assert active(tree) == ["Second"]


def test_all_are_deleted_while_relit(blender, part, stage, scene, material, tmp_path):
    """Then there is nothing to see, as Blender shows it, and no grey."""
    tree = material.node_tree
    part("shading").add_shading(blender.data.objects[:])
    for name in ("First", "Second"):
        tree.nodes.remove(tree.nodes[name])
    blender.context.view_layer.update()
    assert not tree.get_output_node("EEVEE").inputs["Surface"].is_linked
    add_output(tree, "New", GREEN)
    blender.context.view_layer.update()
    assert tree.get_output_node("EEVEE").inputs["Surface"].is_linked


def test_beside_one_for_eevee(blender, part, stage, material, shown):
    """EEVEE's own is relit, whichever is active, and that one, renamed or not, is active again after Remove."""
    tree = material.node_tree
    add_output(tree, "Own", GREEN, "EEVEE")
    for name in ("Own", "Second"):
        tree.nodes[name].is_active_output = True
        before = stage.node_snapshot(tree)
        part("shading").add_shading(blender.data.objects[:])
        assert shown(tree)[0] == GREEN
        part("shading").remove_shading(blender.data.objects[:])
        assert stage.node_snapshot(tree) == before and active(tree) == [name]
        assert not any(list(node.keys()) for node in tree.nodes)


def test_one_for_eevee_comes_while_relit(blender, part, material, shown):
    """It is relit once it is there, and once it is active."""
    tree = material.node_tree
    part("shading").add_shading(blender.data.objects[:])
    own = add_output(tree, "Own", GREEN, "EEVEE")
    assert shown(tree)[0] == GREEN
    own.is_active_output = True
    assert shown(tree)[0] == GREEN
    own.name = "Renamed"
    part("shading").remove_shading(blender.data.objects[:])
    assert active(tree) == ["Renamed"]


@pytest.mark.parametrize("edited", [False, True])
def test_files_of_earlier_versions(blender, part, material, shown, edited):
    """They have our output active, and in it the name of the one that was: an edit makes that active again, Remove does, too."""
    tree = material.node_tree
    part("shading").add_shading(blender.data.objects[:])
    ours = tree.get_output_node("EEVEE")
    ours["prt_were_active"] = "Second"
    ours.is_active_output = True
    assert tree.get_output_node("CYCLES").name == "First", "as earlier versions left it"
    assert part("material_reading").user_output(tree, "EEVEE").name == "Second"
    if edited:
        tree.nodes["First"].location.x += 10.0
        tree.update_tag()
        assert shown(tree) == (BLUE, BLUE)
    part("shading").remove_shading(blender.data.objects[:])
    assert active(tree) == ["Second"]
