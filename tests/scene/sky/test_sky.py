# SPDX-License-Identifier: GPL-3.0-or-later
"""Worlds: which can be followed, and what is said of those that cannot."""

import numpy as np
import pytest


@pytest.fixture
def errors(part):
    return part("errors")


def test_light_is_the_pictures(blender, part, scene, stage):
    """The operator stores the projection of every texel, whatever the turn and the strength."""
    pixels = stage.six_coloured_sky(64)
    world, mapping = stage.environment(stage.picture("Six", pixels), strength=3.0)
    mapping.inputs["Rotation"].default_value = (1, 2, 3)
    blender.ops.prt.project_light()
    light = part("light")
    wanted = part("equirect_projection").project_equirect(pixels, interpolated=True)
    np.testing.assert_allclose(light.read_light(world), wanted, rtol=1e-5, atol=1e-5)
    blender.context.view_layer.update()
    assert list(world["prt_strength"]) == [3.0, 3.0, 3.0, 1.0]


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
    np.testing.assert_allclose(part("light").read_turn(evaluated), turn, atol=1e-6)


def test_drivers_need_no_python(blender, part, scene, stage):
    """Simple expressions run where scripts are forbidden."""
    world, _ = stage.environment(stage.picture("Six", stage.six_coloured_sky(16)))
    blender.ops.prt.project_light()
    drivers = world.animation_data.drivers
    assert len(drivers) == 12
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
    pixels = part("images").linear_pixels(loaded)
    np.testing.assert_allclose(pixels, 0.2140, atol=3e-3)
    loaded.colorspace_settings.name = "Non-Color"
    np.testing.assert_allclose(part("images").linear_pixels(loaded), 0.5, atol=3e-3)


def test_photographic_hdri_is_read_in_linear_light(blender, part, scene, stage):
    """Suns thousands of times the mean survive."""
    import headless

    pixels = part("images").linear_pixels(blender.data.images.load(str(headless.studio_hdri("sunset"))))
    assert pixels.shape == (512, 1024, 3)
    assert pixels.max() > 100 * pixels.mean() > 0


def refusals(stage):
    """Ways to break a good world, each with what the message must name."""
    return {
        "no image": (lambda w, m, t: setattr(t, "image", None), "open an HDRI"),
        "missing file": (lambda w, m, t: setattr(t, "image", _missing_image()), "nowhere.exr"),
        "tiles": (lambda w, m, t: setattr(t.image, "source", "TILED"), "UDIM"),
        "missing in a graph": (_hide_missing_image, "nowhere.exr"),
    }


def _missing_image():
    import bpy

    image = bpy.data.images.new("Lost", 4, 4)
    image.source, image.filepath = "FILE", "//nowhere.exr"
    return image


def _hide_missing_image(world, _mapping, texture):
    tree = world.node_tree
    other, mix = tree.nodes.new("ShaderNodeTexEnvironment"), tree.nodes.new("ShaderNodeVectorMath")
    other.image = _missing_image()
    for source, entry in zip((texture, other), mix.inputs, strict=False):
        tree.links.new(source.outputs["Color"], entry)
    background = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeBackground")
    tree.links.new(mix.outputs["Vector"], background.inputs["Color"])


@pytest.mark.parametrize("case", ["no image", "missing file", "tiles", "missing in a graph"])
def test_bad_worlds_are_said_and_the_rest_is_baked(blender, part, scene, stage, capfd, case):
    """One sentence; a white sky stands in, so that there is something to see, and goes once the world can be projected."""
    ob = stage.object_of("Cube", stage.cube())
    world, mapping = stage.environment(stage.picture("Six", stage.six_coloured_sky(16)))
    texture = next(node for node in world.node_tree.nodes if node.bl_idname == "ShaderNodeTexEnvironment")
    spoil, named = refusals(stage)[case]
    spoil(world, mapping, texture)
    with pytest.raises(RuntimeError, match=named):
        blender.ops.prt.project_light()
    assert not [key for key in world.keys() if key.startswith("prt_")]  # noqa: SIM118 - an ID is no dict
    for _ in range(2):
        capfd.readouterr()
        assert blender.ops.prt.bake(mode="UNSHADOWED") == {"FINISHED"}
        [warning] = [line for line in capfd.readouterr().out.splitlines() if line.startswith("Warning")]
        assert named in warning and part("layers").is_baked(ob.data)
    light = part("light")
    np.testing.assert_allclose(light.read_light(world)[0] * 0.28209479, 1.0, rtol=1e-6)
    found = part("light_state").light_state(world)
    assert found.stale and named in found.text
    texture.image = stage.picture("Found", stage.six_coloured_sky(16))
    for node in [node for node in world.node_tree.nodes if getattr(node, "image", None) is None]:
        if node.bl_idname == "ShaderNodeTexEnvironment":
            node.image = texture.image
    for node in world.node_tree.nodes:
        if node.bl_idname == "ShaderNodeTexEnvironment" and not all(node.image.size):
            node.image = texture.image
    blender.ops.prt.bake(mode="UNSHADOWED")
    assert part("light_state").light_state(world).text == "Light is fresh"


def test_scene_without_world(blender, part, scene, stage, capfd):
    """Nothing lights it, which is said, with what to do; the transport is there."""
    scene.world = None
    ob = stage.object_of("Cube", stage.cube())
    with pytest.raises(RuntimeError, match="has no world"):
        blender.ops.prt.project_light()
    assert blender.ops.prt.bake(mode="UNSHADOWED") == {"FINISHED"}
    assert "has no world: add one" in capfd.readouterr().out and part("layers").is_baked(ob.data)
    [notice] = part("session").session.notices[scene.session_uid]
    assert notice.kind.fix == "prt.use_sky"


@pytest.mark.usefixtures("coarse")
def test_undecodable_pictures_are_left_to_blender(blender, part, scene, stage):
    """A byte image in a colour space with another curve than sRGB's, a power of 2.4."""
    image = blender.data.images.new("Encoded", 8, 4)
    image.generated_color = (0.5, 0.5, 0.5, 1.0)
    image.colorspace_settings.name = "Rec.1886"
    world, _ = stage.environment(image)
    blender.ops.prt.project_light()
    radiance = part("light").read_light(world)[0] / np.sqrt(4 * np.pi)
    np.testing.assert_allclose(radiance, 0.5**2.4, atol=3e-3)


@pytest.mark.usefixtures("coarse")
def test_world_without_nodes_is_its_colour(blender, part, scene):
    """As there are before 5.0."""
    if blender.app.version >= (5, 0, 0):
        pytest.skip("every world has nodes")
    world = blender.data.worlds.new("Plain")
    world.color, scene.world = (0.1, 0.2, 0.4), world
    blender.ops.prt.project_light()
    radiance = part("light").read_light(world)[0] / np.sqrt(4 * np.pi)
    np.testing.assert_allclose(radiance, (0.1, 0.2, 0.4), rtol=1e-4)
    world.color = (0.3, 0.3, 0.3)
    blender.context.view_layer.update()
    np.testing.assert_allclose(part("light").read_light(world)[0] / np.sqrt(4 * np.pi), 0.3, rtol=1e-4)


@pytest.mark.usefixtures("coarse")
def test_sequences_show_the_frame(blender, part, scene, stage, tmp_path):
    """A numbered picture per frame: each frame has its own light, by Blender's own choice of the file."""
    for number in (1, 2):
        image = stage.picture("Frame", np.full((4, 8, 3), float(number)))
        image.filepath_raw, image.file_format = str(tmp_path / f"sky{number}.exr"), "OPEN_EXR"
        image.save()
    image = blender.data.images.load(str(tmp_path / "sky1.exr"))
    image.source = "SEQUENCE"
    world, _ = stage.environment(image)
    user = next(node for node in world.node_tree.nodes if node.bl_idname == "ShaderNodeTexEnvironment").image_user
    user.frame_duration, user.frame_start, user.use_auto_refresh = 2, 1, True
    blender.ops.prt.project_light()
    for frame in (1, 2):
        scene.frame_set(frame)
        radiance = part("light").read_light(world)[0] / np.sqrt(4 * np.pi)
        np.testing.assert_allclose(radiance, frame, rtol=1e-3)


def test_removal_leaves_nothing_on_the_world(blender, scene, stage):
    """Light, record and drivers go with the last baked object."""
    stage.object_of("Cube", stage.cube())
    world, _ = stage.environment(stage.picture("Six", stage.six_coloured_sky(16)))
    blender.ops.prt.bake(mode="UNSHADOWED")
    blender.ops.prt.remove()
    assert not [key for key in world.keys() if key.startswith("prt_")]  # noqa: SIM118 - an ID is no dict
    assert not (world.animation_data and len(world.animation_data.drivers))
