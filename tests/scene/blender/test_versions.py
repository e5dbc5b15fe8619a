# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes, lights and node groups of older versions are replaced on use, newer ones refused and left alone."""

import pytest


@pytest.fixture
def ball(blender, scene, stage):
    """A ball, baked and relit."""
    stage.environment(stage.picture("Sky", stage.six_coloured_sky(16)))
    ob = stage.object_of("Ball", stage.icosphere(2), stage.diffuse())
    blender.ops.prt.bake(mode="UNSHADOWED")
    return ob


def set_version(record_holder, key, version):
    """What another version of the extension would have written there."""
    record = record_holder[key].to_dict()
    del record["version"]
    record_holder[key] = record if version is None else record | {"version": version}


def everything(blender, stage):
    """All that the extension writes anywhere, and the trees it writes it into."""
    texts = []
    for ids in (blender.data.meshes, blender.data.worlds):
        for data in ids:
            texts += [
                f"{data.name} {key} {getattr(value, 'to_dict', lambda v=value: list(v) if hasattr(v, '__len__') else v)()}"
                for key, value in data.items()
            ]
    for mesh in blender.data.meshes:
        texts += [
            f"{mesh.name} {layer.name} {[tuple(point.color) for point in layer.data]}"
            for layer in mesh.color_attributes
        ]
    trees = {material.name: stage.node_snapshot(material.node_tree) for material in blender.data.materials}
    groups = [(tree.name, tree.get("prt_version"), len(tree.nodes)) for tree in blender.data.node_groups]
    return texts, trees, groups


def relight_groups(blender):
    return [tree for tree in blender.data.node_groups if "prt_version" in tree]


def glance(blender, part, ob):
    return part("freshness").glance(blender.context, ob)


def test_newer_bake_is_refused(blender, part, stage, ball, tmp_path):
    """By every operator that would read, replace or remove it; drawing and checking say what to do."""
    set_version(ball.data, "prt_bake", 99)
    before = everything(blender, stage)
    for call in (
        blender.ops.prt.bake,
        blender.ops.prt.remove,
        lambda: blender.ops.prt.export_games202(directory=str(tmp_path)),
        lambda: blender.ops.prt.import_games202(directory=str(tmp_path)),
    ):
        with pytest.raises(RuntimeError, match=r"'Ball' was baked by a newer version .* use a newer version"):
            call()
    assert blender.ops.prt.check() == {"FINISHED"}
    assert everything(blender, stage) == before
    assert glance(blender, part, ball).text == "baked by a newer version: use a newer version of PRT Relight"


@pytest.mark.parametrize("version", [None, 0, -3, "one"])
def test_bake_of_unknown_origin_is_baked_again(blender, part, ball, version):
    """Nothing can be said of it but that a new bake is due, and that replaces it."""
    set_version(ball.data, "prt_bake", version)
    assert glance(blender, part, ball).text == "of unknown origin: bake again to be able to check"
    assert blender.ops.prt.check() == {"FINISHED"}
    blender.ops.prt.bake(mode="UNSHADOWED")
    assert ball.data["prt_bake"]["version"] == part("record").FORMAT_VERSION
    del ball.data["prt_bake"]
    assert glance(blender, part, ball).state == "UNKNOWN"
    blender.ops.prt.remove()
    assert glance(blender, part, ball).state == "NEVER"


def test_newer_light_is_refused(blender, part, stage, scene, ball, capfd, tmp_path):
    """By the operators that would replace or export it; removing the last bake leaves it alone."""
    blender.ops.prt.export_games202(directory=str(tmp_path))
    set_version(scene.world, "prt_light", 99)
    before = everything(blender, stage)
    for call in (
        blender.ops.prt.project_light,
        lambda: blender.ops.prt.export_games202(directory=str(tmp_path)),
        lambda: blender.ops.prt.import_games202(directory=str(tmp_path)),
    ):
        with pytest.raises(RuntimeError, match=r"World 'Sky' was projected by a newer version .* use a newer version"):
            call()
    assert everything(blender, stage) == before
    light = {key: repr(value) for key, value in scene.world.items()}
    assert blender.ops.prt.bake(mode="UNSHADOWED") == {"FINISHED"}
    assert "World 'Sky' was projected by a newer version" in capfd.readouterr().out
    assert {key: repr(value) for key, value in scene.world.items()} == light
    blender.ops.prt.remove()
    assert scene.world["prt_light"]["version"] == 99 and "prt_light_0" in scene.world


def test_light_of_unknown_origin_is_projected_again(blender, part, scene, ball):
    """Which leaves one set of drivers."""
    drivers = len(scene.world.animation_data.drivers)
    del scene.world["prt_light"]
    blender.ops.prt.project_light()
    assert scene.world["prt_light"]["version"] == part("light").LIGHT_VERSION
    assert len(scene.world.animation_data.drivers) == drivers


def test_newer_group_is_left_alone(blender, part, stage, ball, capfd):
    """Neither shading nor what it is part of is added or removed; other materials get a group of our version."""
    (group,) = relight_groups(blender)
    group["prt_version"] = 99
    nodes = stage.node_snapshot(ball.data.materials[0].node_tree)
    assert blender.ops.prt.bake() == {"FINISHED"}
    assert "Material 'Clay' is relit by a newer version" in capfd.readouterr().out
    assert stage.node_snapshot(ball.data.materials[0].node_tree) == nodes
    before = everything(blender, stage)
    for call in (
        blender.ops.prt.add_shading,
        blender.ops.prt.remove_shading,
        blender.ops.prt.remove,
    ):
        with pytest.raises(RuntimeError, match=r"Material 'Clay' is relit by a newer version .* use a newer version"):
            call()
    assert everything(blender, stage) == before
    other = stage.object_of("Other", stage.cube(), stage.diffuse("Other"), (3, 0, 0))
    part("shading").add_shading([other])
    assert sorted(tree["prt_version"] for tree in relight_groups(blender)) == [part("relight_group").GROUP_VERSION, 99]
    assert group.users == 1


@pytest.mark.parametrize("version", [0, "one"])
def test_older_group_gives_way(blender, part, stage, ball, version):
    """All its users are moved to ours, whichever object is shaded, and it is gone."""
    (group,) = relight_groups(blender)
    group["prt_version"] = version
    other = stage.object_of("Other", stage.cube(), stage.diffuse("Other"), (3, 0, 0))
    part("shading").add_shading([other])
    (group,) = relight_groups(blender)
    assert group["prt_version"] == part("relight_group").GROUP_VERSION
    assert group.users == 2
    nodes = ball.data.materials[0].node_tree.nodes
    (node,) = (node for node in nodes if node.bl_idname == "ShaderNodeGroup" and node.node_tree == group)
    assert node.outputs["Shading"].is_linked and node.outputs["Relit"].is_linked
