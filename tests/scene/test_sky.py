# SPDX-License-Identifier: GPL-3.0-or-later
"""Worlds: which can be followed, and what the person is told of those that cannot."""

import numpy as np
import pytest


@pytest.fixture
def errors(part):
    return part("core.errors")


def test_light_is_the_pictures(blender, part, scene, stage):
    """The operator stores the projection of every texel, whatever the turn and the strength."""
    pixels = stage.six_coloured_sky(64)
    world, mapping = stage.environment(stage.picture("Six", pixels), strength=3.0)
    mapping.inputs["Rotation"].default_value = (1, 2, 3)
    blender.ops.prt.project_light()
    light = part("scene.light")
    wanted = part("core.envmap").project_equirect(pixels, interpolated=True)
    np.testing.assert_allclose(light.read_light(world), wanted, rtol=1e-5, atol=1e-5)
    blender.context.view_layer.update()
    assert world["prt_strength"] == 3.0


@pytest.mark.parametrize("vector_type", ["POINT", "VECTOR", "NORMAL", "TEXTURE"])
def test_turn_follows_the_mapping_node(blender, part, scene, stage, vector_type):
    """Drivers hold R of the lookup; the Texture type undoes its rotation."""
    from mathutils import Euler

    world, mapping = stage.environment(stage.picture("Six", stage.six_coloured_sky(16)))
    mapping.vector_type = vector_type
    blender.ops.prt.project_light()
    mapping.inputs["Rotation"].default_value = (0.3, -0.8, 1.9)
    blender.context.view_layer.update()
    turn = np.array(Euler((0.3, -0.8, 1.9)).to_matrix())
    if vector_type == "TEXTURE":
        turn = turn.T
    evaluated = world.evaluated_get(blender.context.evaluated_depsgraph_get())
    np.testing.assert_allclose(part("scene.light").read_turn(evaluated), turn, atol=1e-6)


def test_drivers_need_no_python(blender, part, scene, stage):
    """Simple expressions run where scripts are forbidden."""
    world, _ = stage.environment(stage.picture("Six", stage.six_coloured_sky(16)))
    blender.ops.prt.project_light()
    drivers = world.animation_data.drivers
    assert len(drivers) == 10
    assert all(curve.driver.is_simple_expression and curve.driver.is_valid for curve in drivers)


def test_mapping_is_inserted_where_there_is_none(blender, part, scene, stage):
    """A world that cannot be turned gets the node to turn it by, once."""
    world, _ = stage.environment(stage.picture("Six", stage.six_coloured_sky(16)), mapping=False)
    for _ in range(2):
        blender.ops.prt.project_light()
    assert sum(node.bl_idname == "ShaderNodeMapping" for node in world.node_tree.nodes) == 1


def test_byte_images_are_decoded(blender, part, scene, stage, tmp_path):
    """A PNG in sRGB: mid grey 0.5 is 0.214 of linear light."""
    image = blender.data.images.new("Grey", 8, 4)
    image.generated_color = (0.5, 0.5, 0.5, 1.0)
    image.filepath_raw, image.file_format = str(tmp_path / "grey.png"), "PNG"
    image.save()
    loaded = blender.data.images.load(str(tmp_path / "grey.png"))
    pixels = part("scene.images").linear_pixels(loaded)
    np.testing.assert_allclose(pixels, 0.2140, atol=3e-3)
    loaded.colorspace_settings.name = "Non-Color"
    np.testing.assert_allclose(part("scene.images").linear_pixels(loaded), 0.5, atol=3e-3)


def test_photographic_hdri_is_read_in_linear_light(blender, part, scene, stage):
    """Suns thousands of times the mean survive."""
    import headless

    pixels = part("scene.images").linear_pixels(blender.data.images.load(str(headless.studio_hdri("sunset"))))
    assert pixels.shape == (512, 1024, 3)
    assert pixels.max() > 100 * pixels.mean() > 0


def refusals(stage):
    """Ways to break a good world, each with what the message must name."""
    return {
        "no image": (lambda w, m, t: setattr(t, "image", None), "open an HDRI"),
        "missing file": (lambda w, m, t: setattr(t, "image", _missing_image()), "nowhere.exr"),
        "scaled": (lambda w, m, t: setattr(m.inputs["Scale"], "default_value", (2, 1, 1)), "Scale"),
        "moved": (lambda w, m, t: setattr(m.inputs["Location"], "default_value", (1, 0, 0)), "Location"),
        "flat": (lambda w, m, t: w.node_tree.nodes.remove(t), "Environment Texture"),
        "mirror ball": (lambda w, m, t: setattr(t, "projection", "MIRROR_BALL"), "mirror ball"),
        "rotation fed": (_feed_rotation, "Mapping"),
    }


def _missing_image():
    import bpy

    image = bpy.data.images.new("Lost", 4, 4)
    image.source, image.filepath = "FILE", "//nowhere.exr"
    return image


def _feed_rotation(world, mapping, _texture):
    node = world.node_tree.nodes.new("ShaderNodeCombineXYZ")
    world.node_tree.links.new(node.outputs[0], mapping.inputs["Rotation"])


@pytest.mark.parametrize("case", ["no image", "missing file", "scaled", "moved", "flat", "mirror ball", "rotation fed"])
def test_bad_worlds_are_refused_in_one_sentence(blender, scene, stage, case):
    """Before any work, with nothing written to world or mesh."""
    ob = stage.object_of("Cube", stage.cube())
    world, mapping = stage.environment(stage.picture("Six", stage.six_coloured_sky(16)))
    texture = next(node for node in world.node_tree.nodes if node.bl_idname == "ShaderNodeTexEnvironment")
    spoil, named = refusals(stage)[case]
    spoil(world, mapping, texture)
    with pytest.raises(RuntimeError, match=named):
        blender.ops.prt.bake(mode="UNSHADOWED")
    assert not [key for key in world.keys() if key.startswith("prt_")]  # noqa: SIM118 - an ID is no dict
    assert not [layer for layer in ob.data.attributes if layer.name.startswith("_PRT")]


def test_scene_without_world_is_refused(blender, scene, stage):
    """Named, with what to do."""
    stage.object_of("Cube", stage.cube())
    scene.world = None
    with pytest.raises(RuntimeError, match="has no world"):
        blender.ops.prt.bake(mode="UNSHADOWED")


def test_removal_leaves_nothing_on_the_world(blender, scene, stage):
    """Light, record and drivers go with the last baked object."""
    stage.object_of("Cube", stage.cube())
    world, _ = stage.environment(stage.picture("Six", stage.six_coloured_sky(16)))
    blender.ops.prt.bake(mode="UNSHADOWED")
    blender.ops.prt.remove()
    assert not [key for key in world.keys() if key.startswith("prt_")]  # noqa: SIM118 - an ID is no dict
    assert not (world.animation_data and len(world.animation_data.drivers))
