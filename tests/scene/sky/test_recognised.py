# SPDX-License-Identifier: GPL-3.0-or-later
"""Recognise, or let Blender evaluate: whatever could change a sky is handled, or Cycles evaluates it; and freshness covers it."""

import bpy
import numpy as np
import pytest


@pytest.fixture
def sky(scene, stage):
    return stage.environment(stage.picture("Sky", stage.six_coloured_sky(64)))


@pytest.fixture
def texture(sky):
    world, _ = sky
    return next(node for node in world.node_tree.nodes if node.bl_idname == "ShaderNodeTexEnvironment")


def light_of(part, scene):
    return part("projection").project(part("sky").read_sky(scene), part("projection").LightSettings()).light


def state(part, scene):
    return part("light_state").light_state(scene.world).text


def test_a_muted_link_brings_no_sky(part, scene, sky, texture):
    """A muted HDRI does not light the scene: the Background's own colour does."""
    [link] = texture.outputs["Color"].links
    background = link.to_node
    background.inputs["Color"].default_value = (0.2, 0.4, 0.8, 1.0)
    link.is_muted = True
    light = light_of(part, scene)
    np.testing.assert_allclose(light[0] * 0.282095, (0.2, 0.4, 0.8), rtol=1e-4)
    assert np.abs(light[1:]).max() < 1e-4


def test_coordinates_that_only_scripts_change(blender, part, scene, stage, sky, texture, coarse, tmp_path):
    """Cycles evaluates it, and what it finds is what it renders."""
    plain = light_of(part, scene)
    texture.texture_mapping.scale = (1.0, 1.0, -1.0)
    adjusted = light_of(part, scene)
    assert np.abs(adjusted - plain).max() > 0.1 and part("sky").read_sky(scene).texture is None
    floor = stage.object_of("Floor", stage.grid(1, 2.0), stage.diffuse("White", (1.0, 1.0, 1.0)))
    stage.top_camera(1.0, 16)
    truth = stage.render(tmp_path / "truth.exr", "CYCLES", 512)[..., :3].mean(axis=(0, 1))
    blender.ops.prt.bake(mode="UNSHADOWED")
    np.testing.assert_allclose(stage.render(tmp_path / "here.exr")[..., :3].mean(axis=(0, 1)), truth, rtol=0.03)
    assert floor.data.materials


def test_an_empty_that_turns_the_sky(blender, part, scene, sky, texture, coarse):
    """Its place is part of what the light depends on: moving it makes the light stale, or has it projected again."""
    empty = bpy.data.objects.new("Empty", None)
    scene.collection.objects.link(empty)
    coordinate = next(node for node in texture.id_data.nodes if node.bl_idname == "ShaderNodeTexCoord")
    coordinate.object = empty
    tree = texture.id_data
    tree.links.new(coordinate.outputs["Object"], texture.inputs["Vector"])
    scene.prt.auto_light = False
    blender.ops.prt.project_light()
    assert state(part, scene) == "Light is fresh"
    before = part("light").read_light(scene.world)
    empty.rotation_euler.z = 1.5
    blender.context.view_layer.update()
    assert "the nodes have changed" in state(part, scene)
    scene.prt.auto_light = True
    empty.rotation_euler.z = 1.6
    blender.context.view_layer.update()
    assert state(part, scene) == "Light is fresh"
    assert np.abs(part("light").read_light(scene.world) - before).max() > 0.1


def test_another_world_is_followed(blender, part, scene, stage, sky):
    """Assigned while objects show a bake: it is projected, as an edit of the former one would be."""
    stage.object_of("Ball", stage.icosphere(1), stage.diffuse())
    blender.ops.prt.bake(mode="UNSHADOWED")
    stage.environment(stage.picture("Other", stage.six_coloured_sky(16)[::-1]))
    blender.context.view_layer.update()
    assert part("light").has_light(scene.world) and state(part, scene) == "Light is fresh"


def test_a_world_is_left_alone_where_nothing_is_baked(blender, part, scene, stage, sky):
    """A scene of the file that has nothing to do with it."""
    blender.ops.prt.project_light()
    other = bpy.data.scenes.new("Other")
    other.world = bpy.data.worlds.new("Plain")
    with blender.context.temp_override(scene=other, view_layer=other.view_layers[0]):
        other.view_layers[0].update()
        other.world = bpy.data.worlds.new("Plainer")
        other.view_layers[0].update()
    assert not part("light").has_light(other.world)


@pytest.mark.skipif(bpy.app.version < (5, 2, 0), reason="view layers have no world of their own yet")
def test_the_world_of_a_view_layer(blender, part, scene, stage, sky, tmp_path):
    """It lights: its sky is projected onto the scene's world, where shaders look, and turns the light by drivers."""
    stage.object_of("Floor", stage.grid(1, 2.0), stage.diffuse("White", (1.0, 1.0, 1.0)))
    holder = scene.world
    layers_own, mapping = stage.environment(stage.picture("Layer", stage.six_coloured_sky(32)[..., ::-1] * 0.5))
    scene.world = holder
    blender.context.view_layer.world_override = layers_own
    stage.top_camera(1.0, 16)
    blender.ops.prt.bake(mode="UNSHADOWED")
    assert part("light").has_light(holder) and not part("light").has_light(layers_own)
    assert state(part, scene) == "Light is fresh" and part("light").source_of(holder) == layers_own
    for turn in (0.0, 1.2):
        mapping.inputs["Rotation"].default_value[0] = turn
        truth = stage.render(tmp_path / "truth.exr", "CYCLES", 512)[..., :3].mean(axis=(0, 1))
        here = stage.render(tmp_path / "here.exr")[..., :3].mean(axis=(0, 1))
        np.testing.assert_allclose(here, truth, rtol=0.02)
    layers_own.node_tree.nodes["Background"].inputs["Color"].default_value = (0, 0, 0, 1)
    scene.prt.auto_light = False
    texture = next(node for node in layers_own.node_tree.nodes if node.bl_idname == "ShaderNodeTexEnvironment")
    texture.interpolation = "Closest"
    assert "the nodes have changed" in state(part, scene)


def test_a_keyframed_light_without_its_mapping_is_stale(blender, part, scene, sky, coarse):
    """Drivers of a node that is gone keep their last value, and say nothing; those of a renamed one are mended."""
    _, mapping = sky
    blender.ops.prt.keyframe_light(frame_start=1, frame_end=2)
    assert state(part, scene).startswith("Light is keyframed, frames 1 to 2")
    mapping.name = "Renamed"
    blender.context.view_layer.update()
    assert state(part, scene).startswith("Light is keyframed, frames 1 to 2")
    mapping.inputs["Rotation"].default_value[2] = 0.5
    blender.context.view_layer.update()
    turned = part("light").read_turn(scene.world)
    np.testing.assert_allclose(turned[0, 0], np.cos(0.5), rtol=1e-6)
    mapping.id_data.nodes.remove(mapping)
    assert "keyframe it again" in state(part, scene)


def test_multilayer_pictures_are_evaluated(blender, part, scene, stage, sky, texture, coarse, tmp_path):
    """A render result as a sky: Blender reads its layers, we do not."""
    stage.object_of("Floor", stage.grid(1, 2.0), stage.diffuse())
    stage.top_camera(1.0, 16)
    settings = scene.render.image_settings
    if hasattr(settings, "media_type"):
        settings.media_type = "MULTI_LAYER_IMAGE"
    settings.file_format = "OPEN_EXR_MULTILAYER"
    scene.render.filepath, scene.render.engine, scene.cycles.samples = str(tmp_path / "layers.exr"), "CYCLES", 1
    blender.ops.render.render(write_still=True)
    texture.image = bpy.data.images.load(str(tmp_path / "layers.exr"))
    found = part("sky").read_sky(scene)
    assert found.texture is None and np.isfinite(light_of(part, scene)).all()


def test_texels_that_are_no_numbers_are_left_out_and_counted(blender, part, scene, stage, capfd):
    """One of them used to cancel the whole bake."""
    pixels = stage.six_coloured_sky(64)
    whole = stage.environment(stage.picture("Whole", pixels)) and light_of(part, scene)
    pixels = pixels.copy()
    pixels[3, :4] = np.nan
    pixels[20, 5, 1] = np.inf
    stage.environment(stage.picture("Broken", pixels))
    stage.object_of("Ball", stage.icosphere(1), stage.diffuse())
    assert blender.ops.prt.bake(mode="UNSHADOWED") == {"FINISHED"}
    assert "without 5 of 2,048 texels, which are not finite" in capfd.readouterr().out
    np.testing.assert_allclose(part("light").read_light(scene.world), whole, atol=0.1)


def test_a_picture_that_is_no_panorama_is_said(blender, part, scene, stage, capfd):
    stage.environment(stage.picture("Square", np.ones((16, 16, 3))))
    blender.ops.prt.project_light()
    assert "16 x 16 and no 2:1 panorama" in capfd.readouterr().out


@pytest.mark.skipif(bpy.app.version < (5, 0, 0), reason="files have no working space of their own yet")
@pytest.mark.parametrize("space", ["ACEScg", "Linear Rec.2020"])
def test_skies_in_other_working_spaces(blender, part, scene, stage, tmp_path, space):
    """A PNG and a cube map light as Cycles renders them."""
    rng = np.random.default_rng(0)
    path = tmp_path / "sky.png"
    image = bpy.data.images.new("Sky", 32, 16)
    image.pixels.foreach_set(np.dstack([rng.random((16, 32, 3)), np.ones((16, 32))]).astype(np.float32).ravel())
    image.filepath_raw, image.file_format = str(path), "PNG"
    image.save()
    for face in ("posx", "negx", "posy", "negy", "posz", "negz"):
        side = bpy.data.images.new(face, 8, 8)
        colour = np.r_[rng.random(3), 1.0]
        side.pixels.foreach_set(np.tile(colour, 64).astype(np.float32))
        side.filepath_raw, side.file_format = str(tmp_path / f"{face}.png"), "PNG"
        side.save()
    blender.ops.wm.set_working_color_space(working_space=space, convert_colors=False)
    floor = stage.object_of("Floor", stage.grid(1, 2.0), stage.diffuse("White", (1.0, 1.0, 1.0)))
    stage.top_camera(1.0, 16)
    for kind in ("picture", "cube map"):
        if kind == "picture":
            stage.environment(bpy.data.images.load(str(path)))
        else:
            blender.ops.prt.import_cubemap(directory=str(tmp_path))
        blender.ops.prt.bake(mode="UNSHADOWED")
        truth = stage.render(tmp_path / "truth.exr", "CYCLES", 1024)[..., :3].mean(axis=(0, 1))
        here = stage.render(tmp_path / "here.exr")[..., :3].mean(axis=(0, 1))
        np.testing.assert_allclose(here, truth, rtol=0.02, err_msg=kind)
    assert floor
