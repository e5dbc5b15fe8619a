# SPDX-License-Identifier: GPL-3.0-or-later
"""The node groups that materials share are built anew where they are of another version, for another Blender, or no longer whole."""

import numpy as np
import pytest

PARTS = ("PRT Principled", "PRT Lamps", "PRT Detail", "PRT Relight: Axes")


@pytest.fixture
def relit(blender, part, scene, stage):
    """Two objects whose materials, each of a Principled BSDF with a Normal Map, under a lamp, are relit with all groups of `PARTS`.

    Groups go with their last user: what one material is relit with anew is there still for the sake of the other.
    """
    from headless import use_nodes

    light = blender.data.objects.new("Lamp", blender.data.lights.new("Lamp", "POINT"))
    scene.collection.objects.link(light)
    material = blender.data.materials.new("Plastic")
    use_nodes(material)
    tree = material.node_tree
    normal = tree.nodes.new("ShaderNodeNormalMap")
    tree.links.new(normal.outputs[0], tree.nodes["Principled BSDF"].inputs["Normal"])
    one = stage.object_of("One", stage.icosphere(2), material)
    other = stage.object_of("Other", stage.cube(), material.copy())
    part("shading").add_shading([one, other])
    return one, other


def tree_of(ob):
    return ob.data.materials[0].node_tree


def groups_in(ob):
    return [node.node_tree for node in tree_of(ob).nodes if node.bl_idname == "ShaderNodeGroup"]


def group_of(blender, name):
    """The group of a name, of which there may be one."""
    [found] = [tree for tree in blender.data.node_groups if tree.get("prt_part") == name]
    return found


def all_groups(blender, stage):
    return {tree.get("prt_part"): stage.node_snapshot(tree) for tree in blender.data.node_groups}


def output_of(tree):
    return next(node for node in tree.nodes if node.bl_idname == "NodeGroupOutput")


DAMAGE = {
    "an output unlinked": lambda tree: tree.links.remove(output_of(tree).inputs[0].links[0]),
    "the output removed": lambda tree: tree.nodes.remove(output_of(tree)),
    "an input removed": lambda tree: tree.interface.remove(
        next(item for item in tree.interface.items_tree if item.in_out == "INPUT")
    ),
    "a node removed": lambda tree: tree.nodes.remove(
        next(node for node in tree.nodes if node.bl_idname in {"ShaderNodeMath", "ShaderNodeMix"})
    ),
}


@pytest.mark.parametrize("damage", DAMAGE)
@pytest.mark.parametrize("name", [PARTS[0], pytest.param(PARTS[3], marks=pytest.mark.slow)])
def test_damaged_groups_are_built_anew(blender, part, stage, relit, name, damage):
    """Wherever they are used: in the material, or inside of "PRT Relight"."""
    groups, nodes = all_groups(blender, stage), [stage.node_snapshot(tree_of(ob)) for ob in relit]
    DAMAGE[damage](group_of(blender, name))
    assert all_groups(blender, stage) != groups
    part("shading").add_shading(relit[:1])
    assert all_groups(blender, stage) == groups
    part("shading").add_shading(relit[1:])
    assert [stage.node_snapshot(tree_of(ob)) for ob in relit] == nodes


def test_what_was_added_stays(blender, part, relit):
    """A node more, between two others: the group still works."""
    tree = group_of(blender, PARTS[0])
    entry = output_of(tree).inputs["Specular IOR Level"]
    source, half = entry.links[0].from_socket, tree.nodes.new("ShaderNodeMath")
    half.operation, half.inputs[1].default_value = "MULTIPLY", 0.5
    tree.links.new(source, half.inputs[0])
    tree.links.new(half.outputs[0], entry)
    part("shading").add_shading(relit[:1])
    assert group_of(blender, PARTS[0]) == tree and half.name in tree.nodes


def marks(tree, version, for_length):
    """Mark a group as another version of the extension did: until version 5 without saying for which Blender."""
    tree["prt_helper_version"] = version
    if for_length is None:
        del tree["prt_limits_length"]
    else:
        tree["prt_limits_length"] = for_length


@pytest.mark.parametrize("name", PARTS[:3])
@pytest.mark.parametrize("version", [3, 4, 5, "one"])
def test_older_groups_give_way(blender, part, stage, relit, name, version):
    """Whatever Blender they were built for; all materials that use them get the new one."""
    groups, tree = all_groups(blender, stage), group_of(blender, name)
    tree.nodes.remove(output_of(tree))
    marks(tree, version, None)
    part("shading").add_shading(relit[:1])
    assert all_groups(blender, stage) == groups
    assert all(group_of(blender, name) in groups_in(ob) for ob in relit)


def test_newer_groups_are_left_alone(blender, part, stage, relit):
    """What they hold cannot be known: what is relit now gets another."""
    newer = group_of(blender, "PRT Lamps")
    marks(newer, 99, True)
    before = stage.node_snapshot(newer)
    part("helper_groups").renew_lamps_group()
    assert group_of(blender, "PRT Lamps") == newer
    part("shading").add_shading(relit[:1])
    assert stage.node_snapshot(newer) == before
    assert [newer in groups_in(ob) for ob in relit] == [False, True]


@pytest.fixture
def file_of_another_blender(blender, part, stage, monkeypatch, tmp_path):
    """A baked ball under a sun in the sky and a lamp, as a Blender saves it whose EEVEE limits something else of the sky's light.

    Returns: its path, and the frame of this Blender.
    """
    helpers = part("helper_groups")
    sky = np.full((64, 128, 3), 0.1)
    sky[-8:] = 20.0
    stage.environment(stage.picture("Bright Zenith", sky))
    ob = stage.object_of("Ball", stage.icosphere(4), stage.diffuse("White", (0.8, 0.8, 0.8)))
    light = blender.data.objects.new("Lamp", blender.data.lights.new("Lamp", "SUN"))
    blender.context.scene.collection.objects.link(light)
    stage.top_camera(resolution=32)
    blender.ops.prt.bake(mode="SHADOWED", samples=64, lamps="NONE")
    right = stage.render(tmp_path / "right.exr")
    with monkeypatch.context() as patch:
        patch.setattr(helpers, "_LIMITS_LENGTH", not helpers._LIMITS_LENGTH)
        part("shading").add_shading([ob])
    wrong = stage.render(tmp_path / "wrong.exr")
    assert np.abs(wrong - right)[..., :3].max() > 0.02, "the two differ"
    path = tmp_path / "other.blend"
    blender.ops.wm.save_as_mainfile(filepath=str(path))
    return path, right


@pytest.mark.parametrize("old_marks", [False, True])
def test_files_of_another_blender_are_right(blender, stage, file_of_another_blender, tmp_path, old_marks):
    """Once they are loaded, without another bake; also where one number says both, as it did."""
    path, right = file_of_another_blender
    if old_marks:
        tree = group_of(blender, "PRT Lamps")
        marks(tree, 5 if tree["prt_limits_length"] else 4, None)
        blender.ops.wm.save_as_mainfile(filepath=str(path))
    blender.ops.wm.open_mainfile(filepath=str(path))
    np.testing.assert_allclose(stage.render(tmp_path / "loaded.exr"), right, atol=2e-3)
    tree = group_of(blender, "PRT Lamps")
    assert tree.users == 1 and tree["prt_helper_version"] == 6
    blender.ops.wm.save_as_mainfile(filepath=str(path))
    blender.ops.wm.open_mainfile(filepath=str(path))
    assert group_of(blender, "PRT Lamps")["prt_links"] == len(group_of(blender, "PRT Lamps").links)


def test_files_without_lamps_get_no_group(blender, part, scene):
    """There is nothing to renew."""
    part("helper_groups").renew_lamps_group()
    assert not blender.data.node_groups
