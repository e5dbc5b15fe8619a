# SPDX-License-Identifier: GPL-3.0-or-later
"""A new user meets the default scene, a floor of four vertices, sentences with buttons, and the way back."""

import numpy as np
import pytest


@pytest.fixture
def default(blender):
    """Blender's own startup file."""
    blender.ops.wm.read_homefile(use_factory_startup=True)
    return blender.context.scene


def sentences(part, scene):
    return [one.sentence for one in part("session").session.notices[scene.session_uid]]


def test_the_default_scene(blender, part, default):
    """It bakes, says that its sky is the same everywhere, and one click gives it one that turns."""
    cube = blender.data.objects["Cube"]
    nodes = len(cube.data.materials[0].node_tree.nodes)
    assert blender.ops.prt.bake(samples=16) == {"FINISHED"}
    [notice] = part("session").session.notices[default.session_uid]
    assert "looks the same in all directions" in notice.sentence and notice.kind.fix == "prt.use_sky"
    assert blender.ops.prt.use_sky(sky="forest") == {"FINISHED"}
    light = part("light")
    assert light.followed(default.world).rotation
    before = light.shown_light(default.world)
    light.followed(default.world).rotation.default_value[2] = 1.0
    assert np.abs(light.shown_light(default.world) - before).max() > 0.05
    [image] = [image for image in blender.data.images if image.name.startswith("forest")]
    assert image.packed_file
    assert blender.ops.prt.bake(samples=16) == {"FINISHED"} and not sentences(part, default)
    assert blender.ops.prt.remove() == {"FINISHED"}
    assert len(cube.data.materials[0].node_tree.nodes) == nodes
    assert not blender.data.node_groups and not light.has_light(default.world)


@pytest.mark.parametrize("prepare", ["no world", "no nodes", "a picture already"])
def test_a_sky_for_any_world(blender, part, scene, stage, prepare):
    """With or without a world, nodes or a picture; given another name, it names those that there are."""
    if prepare == "no nodes":
        scene.world = blender.data.worlds.new("Bare")
        part("nodes").turn_nodes(scene.world, False)
    elif prepare == "a picture already":
        stage.environment(stage.picture("Sky", stage.six_coloured_sky(16)), strength=2.5)
    else:
        scene.world = None
    assert blender.ops.prt.use_sky(sky="studio") == {"FINISHED"}
    sky = part("sky").read_sky(scene)
    assert sky.texture.image.name.startswith("studio") and sky.mapping
    assert part("light_state").light_state(scene.world).text == "Light is fresh"
    if prepare == "a picture already":
        assert sky.strength.default_value == 2.5
    with pytest.raises(TypeError, match="nowhere"):
        blender.ops.prt.use_sky(sky="nowhere")


def test_a_coarse_floor_is_subdivided(blender, part, scene, stage):
    """Four vertices under a ball show no shadow: it is said, and the button makes room for one."""
    stage.environment(stage.picture("Sky", stage.six_coloured_sky(16)))
    floor = stage.object_of("Floor", stage.grid(1, 10.0), stage.diffuse("Floor"))
    stage.object_of("Ball", stage.icosphere(3), stage.diffuse("Ball"), (0, 0, 1.0))
    blender.ops.prt.bake(mode="SHADOWED", samples=64)
    [notice] = [one for one in part("session").session.notices[scene.session_uid] if one.kind.fix == "prt.refine"]
    assert notice.names == ("Floor",)
    carrier = part("carrier")

    def darkest():
        transport = part("layers").read(carrier.transport_mesh(floor))[:, 0, 0]
        return transport.min() / transport.max()

    assert darkest() > 0.9
    assert blender.ops.prt.refine() == {"FINISHED"}
    assert blender.ops.prt.bake(mode="SHADOWED", samples=64) == {"FINISHED"}
    assert darkest() < 0.6 and len(floor.data.vertices) == 4
    assert not any("larger than what shades" in said for said in sentences(part, scene))
    modifiers = [modifier.type for modifier in floor.modifiers]
    blender.ops.prt.refine()
    assert [modifier.type for modifier in floor.modifiers] == modifiers, "there is nothing more to do"


def test_sentences_find_their_objects(blender, part, scene, stage):
    """Select takes what a sentence is about, objects or those that have the material."""
    stage.environment(stage.picture("Sky", stage.six_coloured_sky(16)))
    good, bad = (stage.object_of(name, stage.cube(), location=(x, 0, 0)) for name, x in (("Good", 0), ("Bad", 9)))
    bad.data.clear_geometry()
    for ob in (good, bad):
        ob.select_set(True)
    blender.ops.prt.bake(mode="SHADOWED", samples=16)
    assert blender.ops.prt.select_noticed(index=0) == {"FINISHED"}
    assert blender.context.selected_objects == [bad] and blender.context.view_layer.objects.active == bad
    assert blender.ops.prt.select_noticed(index=7) == {"CANCELLED"}


def test_remove_says_what_it_removed(blender, scene, stage, capfd):
    """Nothing where nothing was; slots and materials that were made for it are gone."""
    stage.environment(stage.picture("Sky", stage.six_coloured_sky(16)))
    ob = stage.object_of("Cube", stage.cube())
    blender.ops.prt.remove()
    assert "There was nothing to remove." in capfd.readouterr().out
    blender.ops.prt.bake(mode="SHADOWED", samples=16)
    blender.ops.prt.remove()
    assert "Removed the transport of 1 object and the shading of 1 material." in capfd.readouterr().out
    assert not ob.material_slots and not blender.data.materials and not blender.data.node_groups
