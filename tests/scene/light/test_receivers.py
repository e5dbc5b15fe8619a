# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps of the sky light all that is relit, once, wherever it comes from and whatever is done with it afterwards."""

import importlib

import numpy as np
import pytest

SCALE, RESOLUTION = 5.0, 80
WHITE = (0.8, 0.8, 0.8)


@pytest.fixture
def sunny(scene, stage):
    """A white patch at the middle, under a sky with a sun, from above."""
    stage.environment(stage.picture("Sunny", stage.sunny_sky(256)), 0.5)
    stage.top_camera(SCALE, RESOLUTION)
    return stage.object_of("Patch", stage.grid(4, 0.4), stage.diffuse("White", WHITE))


def suns(blender):
    return [ob for ob in blender.data.objects if ob.type == "LIGHT"]


def bake(blender, **settings):
    assert blender.ops.prt.bake(mode="SHADOWED", samples=64, **settings) == {"FINISHED"}


def receivers(blender):
    return set(suns(blender)[0].light_linking.receiver_collection.objects)


def at(pixels, stage, x, y, reach=0.3):
    """Mean of what is seen there."""
    near = (np.abs(stage.pixel_points(SCALE, RESOLUTION) - (x, y)) < reach).all(axis=-1)
    return pixels[near][:, :3].mean(axis=0)


def select(blender, ob):
    blender.ops.object.select_all(action="DESELECT")
    ob.select_set(True)
    blender.context.view_layer.objects.active = ob


def duplicated(blender, stage, patch):
    select(blender, patch)
    blender.ops.object.duplicate()
    return blender.context.object


def copied(blender, stage, patch):
    copy = patch.copy()
    blender.context.scene.collection.objects.link(copy)
    return copy


def appended(blender, stage, patch):
    path = blender.app.tempdir + "patch.blend"
    blender.data.libraries.write(path, {patch})
    before = set(blender.data.objects)
    blender.ops.wm.append(directory=f"{path}/Object/", filename=patch.name)
    return next(ob for ob in set(blender.data.objects) - before if ob.type == "MESH")


def joined(blender, stage, patch):
    """Geometry without a bake, as part of a baked mesh: its own half lies at the given place, the other at the far left."""
    fresh, old = stage.object_of("Fresh", stage.grid(4, 0.4), patch.active_material), patch.copy()
    old.data = patch.data.copy()
    blender.context.scene.collection.objects.link(old)
    old.location.x = -50.0
    blender.context.view_layer.update()
    with blender.context.temp_override(active_object=fresh, object=fresh, selected_editable_objects=[fresh, old]):
        blender.ops.object.join()
    return fresh


def instanced(blender, stage, patch):
    """An instance of a collection that no scene holds."""
    asset, held = blender.data.collections.new("Asset"), patch.copy()
    asset.objects.link(held)
    empty = blender.data.objects.new("Instance", None)
    empty.instance_type, empty.instance_collection = "COLLECTION", asset
    blender.context.scene.collection.objects.link(empty)
    return empty


@pytest.mark.parametrize(
    "made",
    [duplicated, appended, instanced, *(pytest.param(each, marks=pytest.mark.slow) for each in (copied, joined))],
)
def test_what_comes_later_gets_the_sun_once(blender, stage, sunny, tmp_path, made):
    sunny.prt.space = "OBJECT"
    bake(blender)
    made(blender, stage, sunny).location = (1.2, 1.2, 0.0)
    shown = stage.render(tmp_path / "shown.exr")
    np.testing.assert_allclose(at(shown, stage, 1.2, 1.2), at(shown, stage, 0.0, 0.0), rtol=0.01)
    assert at(shown, stage, 0.0, 0.0).min() > 0.38


def scatter(blender, ob, source, location):
    """Have an object's geometry nodes add an instance of another at a place."""
    tree = blender.data.node_groups.new("Scatter", "GeometryNodeTree")
    for side in ("INPUT", "OUTPUT"):
        tree.interface.new_socket("Geometry", in_out=side, socket_type="NodeSocketGeometry")
    names = ("NodeGroupInput", "NodeGroupOutput", "GeometryNodeJoinGeometry", "GeometryNodeMeshLine")
    given, result, both, points = (tree.nodes.new(name) for name in names)
    points.inputs["Count"].default_value, points.inputs["Start Location"].default_value = 1, location
    place, info = (tree.nodes.new(name) for name in ("GeometryNodeInstanceOnPoints", "GeometryNodeObjectInfo"))
    info.inputs["Object"].default_value, info.inputs["As Instance"].default_value = source, True
    tree.links.new(points.outputs[0], place.inputs["Points"])
    tree.links.new(info.outputs["Geometry"], place.inputs["Instance"])
    for source_socket in (place.outputs[0], given.outputs[0]):
        tree.links.new(source_socket, both.inputs[0])
    tree.links.new(both.outputs[0], result.inputs[0])
    ob.modifiers.new("Scatter", "NODES").node_group = tree


def test_instances_of_what_is_not_baked(blender, stage, sunny, tmp_path):
    """EEVEE lights them as what they grow on: as grass on a terrain. Their source is lit as Cycles lights it, too."""
    blade = stage.object_of("Blade", stage.grid(2, 0.4), stage.diffuse("Grass", WHITE), (1.2, -1.2, 0.0))
    scatter(blender, sunny, blade, (-1.2, 1.2, 0.0))
    select(blender, sunny)
    bake(blender)
    truth = stage.render(tmp_path / "truth.exr", "CYCLES", 128)
    shown = stage.render(tmp_path / "shown.exr")
    for place in ((0.0, 0.0), (-1.2, 1.2), (1.2, -1.2)):
        np.testing.assert_allclose(at(shown, stage, *place), at(truth, stage, *place), rtol=0.04)
    select(blender, sunny)
    blender.ops.prt.remove()
    assert not any(node.name.startswith("PRT") for one in blender.data.materials for node in one.node_tree.nodes)


def test_shading_without_a_bake(blender, stage, sunny, tmp_path):
    """*Add Shading* has the lamps light what is not baked, with shadows, as Cycles' sky does: under a roof and beside it."""
    roof = stage.object_of("Roof", stage.grid(4, 0.4), stage.diffuse("Roof", WHITE), (-1.2, 1.2, 1.0))
    floor = stage.object_of("Floor", stage.grid(20, 1.2), stage.diffuse("Floor", WHITE), (-1.2, 1.2, 0.0))
    select(blender, sunny)
    bake(blender)
    for ob in (roof, floor):
        select(blender, ob)
        assert blender.ops.prt.add_shading() == {"FINISHED"}
    assert {roof, floor, sunny} <= receivers(blender)
    truth, shown = (stage.render(tmp_path / f"{engine}.exr", engine, 128) for engine in ("CYCLES", "EEVEE"))
    shadow = np.array((-1.2, 1.2)) - 1.0 * stage.SUN[:2] / stage.SUN[2]
    for x, y in ((-1.2, 1.2), shadow, (-0.4, 2.0)):
        wanted = at(truth, stage, x, y, 0.1)
        np.testing.assert_allclose(at(shown, stage, x, y, 0.1), wanted, atol=0.12 * wanted.max())
    assert at(shown, stage, shadow[0], shadow[1], 0.1)[0] < 0.6 * at(shown, stage, -1.2, 1.2, 0.1)[0]


def test_a_material_without_room_for_transport(blender, stage, sunny, tmp_path):
    """It does not show the bake, but the sun once: with its shadows."""
    crowded = stage.diffuse("Crowded", WHITE)
    nodes, links = crowded.node_tree.nodes, crowded.node_tree.links
    total = None
    for number in range(6):
        uv = nodes.new("ShaderNodeUVMap")
        uv.uv_map = sunny.data.uv_layers.new(name=f"UV {number}").name
        add = nodes.new("ShaderNodeVectorMath")
        links.new(uv.outputs[0], add.inputs[0])
        if total:
            links.new(total, add.inputs[1])
        total = add.outputs[0]
    none = nodes.new("ShaderNodeVectorMath")
    none.operation, none.inputs[1].default_value = "MULTIPLY_ADD", (0.0, 0.0, 0.0)
    links.new(total, none.inputs[0])
    none.inputs[2].default_value = WHITE
    shader = next(node for node in nodes if "Bsdf" in node.bl_idname)
    links.new(none.outputs[0], shader.inputs[0])
    sunny.data.materials.append(crowded)
    for polygon in sunny.data.polygons[: len(sunny.data.polygons) // 2]:
        polygon.material_index = 1
    bake(blender)
    shown = stage.render(tmp_path / "shown.exr")
    relit, bare = (at(shown, stage, 0.0, y, 0.1) for y in (0.2, -0.2))
    np.testing.assert_allclose(bare, relit, rtol=0.01)
    assert relit.min() > 0.38


def test_deleted_objects_are_let_go(blender, part, stage, sunny, tmp_path):
    """They do not come back with the file, and *Remove PRT* takes the rest away: materials that nothing shows, too."""
    bake(blender)
    select(blender, sunny)
    blender.ops.object.delete()
    blender.ops.wm.save_as_mainfile(filepath=str(tmp_path / "deleted.blend"))
    blender.ops.wm.open_mainfile(filepath=str(tmp_path / "deleted.blend"))
    assert "Patch" not in blender.data.objects
    other = stage.object_of("Other", stage.grid(4, 0.4), stage.diffuse("Other", WHITE))
    bake(blender)
    other.material_slots[0].material = None
    blender.ops.prt.remove()
    assert not suns(blender) and not part("light").has_light(blender.context.scene.world)
    assert not any(node.name.startswith("PRT") for one in blender.data.materials for node in one.node_tree.nodes)
    assert not blender.data.node_groups


def lamps_of_each_scene(blender):
    return [[child["prt_lamps_of"] for child in held(scene)] for scene in blender.data.scenes]


def held(scene):
    return [one for one in scene.collection.children_recursive if "prt_lamps_of" in one]


def test_lamps_go_with_copies_of_scenes_and_worlds(blender, part, sunny):
    """Each scene has those of its own world, which turn with it."""
    bake(blender)
    scene = blender.context.scene
    scene.world = scene.world.copy()
    blender.context.view_layer.update()
    assert lamps_of_each_scene(blender) == [[scene.world]]
    blender.ops.scene.new(type="FULL_COPY")
    copy = blender.context.scene
    blender.context.view_layer.update()
    assert copy.world != scene.world and lamps_of_each_scene(blender) == [[scene.world], [copy.world]]
    [sun] = [ob for ob in copy.objects if ob.type == "LIGHT"]
    before = sun.matrix_world.copy()
    part("light").followed(copy.world).rotation.node.inputs["Rotation"].default_value[2] = 1.5
    blender.context.view_layer.update()
    assert (sun.matrix_world.to_3x3().col[2] - before.to_3x3().col[2]).length > 0.5
    assert sum(ob.type == "MESH" for ob in receivers(blender)) == 2


def test_lamps_that_were_moved_or_deleted(blender, part, stage, sunny):
    """Wherever people put them, they go out with their world; and what is deleted of them comes back, or is said to be gone."""
    bake(blender)
    scene = blender.context.scene
    lights = blender.data.collections.new("Lights")
    scene.collection.children.link(lights)
    [lamps] = held(scene)
    scene.collection.children.unlink(lamps)
    lights.children.link(lamps)
    blender.context.view_layer.update()
    assert list(lights.children) == [lamps] and lamps.name not in scene.collection.children
    scene.prt.auto_light = False
    blender.data.batch_remove(suns(blender))
    blender.context.view_layer.update()
    assert "lamps of it are gone" in part("light_state").light_state(scene.world).text
    scene.prt.auto_light = True
    blender.context.view_layer.update()
    stage.object_of("Any", stage.grid(1, 0.1))
    blender.context.view_layer.update()
    assert len(suns(blender)) == 1 and part("light_state").light_state(scene.world).text == "Light is fresh"
    stage.environment(stage.picture("Soft", stage.six_coloured_sky(16)))
    blender.context.view_layer.update()
    assert not held(scene)


def test_lamps_of_a_deleted_world(blender, sunny):
    bake(blender)
    blender.data.worlds.remove(blender.context.scene.world)
    blender.context.view_layer.update()
    assert not suns(blender) and not [one for one in blender.data.collections if "PRT" in one.name]


def test_a_material_that_was_baked_where_no_lamp_shone(blender, part, stage, sunny, tmp_path):
    """It may be linked, and cannot be given the light of lamps: the sun stays in its soft light."""
    bake(blender, lamps="NONE")
    soft = at(stage.render(tmp_path / "soft.exr"), stage, 0.0, 0.0)
    path = blender.app.tempdir + "library.blend"
    blender.data.libraries.write(path, {sunny})
    blender.data.objects.remove(sunny)
    stage.object_of("Other", stage.grid(4, 0.4), stage.diffuse("Other", WHITE), (1.2, 1.2, 0.0))
    with blender.data.libraries.load(path, link=True) as (_, wanted):
        wanted.objects = ["Patch"]
    blender.context.scene.collection.objects.link(wanted.objects[0])
    blender.ops.object.select_all(action="DESELECT")
    select(blender, blender.data.objects["Other"])
    bake(blender)
    assert suns(blender)
    shown = stage.render(tmp_path / "shown.exr")
    np.testing.assert_allclose(at(shown, stage, 0.0, 0.0), soft, rtol=0.01)


def test_hidden_lamps_are_named_in_the_panel(blender, sunny):
    import headless

    hidden_lamps = importlib.import_module(f"{headless.PACKAGE}.ui.light").hidden_lamps
    bake(blender)
    assert hidden_lamps(blender.context) == ""
    blender.context.view_layer.layer_collection.children["PRT Lamps"].exclude = True
    assert "PRT Lamps" in hidden_lamps(blender.context)
