# SPDX-License-Identifier: GPL-3.0-or-later
"""The picture, the probe in EEVEE's pixels, and the small picture of the panel show the SH light."""

import numpy as np
import pytest


@pytest.fixture
def sky(blender, scene, stage):
    """A turned sky of strength 1.5, projected: (world, Mapping node)."""
    world, mapping = stage.environment(stage.picture("Six", stage.six_coloured_sky(256)), strength=1.5)
    mapping.inputs["Rotation"].default_value = (0.4, -0.9, 2.3)
    blender.ops.prt.project_light()
    return world, mapping


def pixels_of(image):
    flat = np.empty(image.size[0] * image.size[1] * 4, dtype=np.float32)
    image.pixels.foreach_get(flat)
    return flat.reshape(image.size[1], image.size[0], 4)


def test_picture_beside_the_sky(blender, part, scene, stage, sky, tmp_path):
    """Left what Cycles shows of the world, right what is stored; the sky is of order 2, so that both are the same."""
    from tests import panorama

    blender.ops.prt.show_light(kind="PICTURE")
    image = blender.data.images["PRT Light of Sky"]
    assert tuple(image.size) == (1024, 256) and image.is_float and image.packed_file
    left, right = np.split(pixels_of(image)[..., :3], 2, axis=1)
    seen = panorama.render_world(tmp_path / "world.exr", 256)
    for shown in (left, right):  # at the two poles of its picture Cycles blends the top row with the bottom one
        error = np.abs(shown - seen).max(axis=-1)
        assert np.median(error) < 0.003 * seen.max() and (error > 0.02 * seen.max()).sum() <= 8


def test_picture_is_put_where_it_can_be_seen(blender, sky, capfd):
    """In an Image Editor; without one it is said where to look."""
    blender.ops.prt.show_light()
    assert "Open it in an Image Editor." in capfd.readouterr().out
    area = blender.context.screen.areas[0]
    area.type = "IMAGE_EDITOR"
    blender.ops.prt.show_light()
    assert "Image Editor" not in capfd.readouterr().out
    assert area.spaces.active.image == blender.data.images["PRT Light of Sky"]


@pytest.mark.slow
def test_picture_of_any_nodes(blender, part, scene, stage, tmp_path):
    """A gradient, which only Blender can evaluate, is on the left as Cycles shows it."""
    from tests import panorama

    world, _ = stage.environment(None, strength=1.5)
    tree = world.node_tree
    gradient, coordinate = tree.nodes.new("ShaderNodeTexGradient"), tree.nodes.new("ShaderNodeTexCoord")
    tree.links.new(coordinate.outputs["Generated"], gradient.inputs["Vector"])
    tree.links.new(gradient.outputs["Color"], tree.nodes["Background"].inputs["Color"])
    blender.ops.prt.project_light()
    blender.ops.prt.show_light()
    left = pixels_of(blender.data.images["PRT Light of Sky"])[:, :512, :3]
    seen = panorama.render_world(tmp_path / "world.exr", 256)
    assert seen.max() > 1.4 and np.quantile(np.abs(left - seen), 0.999) < 0.02


def test_picture_is_drawn_again(blender, scene, stage, sky):
    """Into the same image, as the world is turned by then."""
    _, mapping = sky
    blender.ops.prt.show_light()
    before, count = pixels_of(blender.data.images["PRT Light of Sky"]), len(blender.data.images)
    mapping.inputs["Rotation"].default_value = (0.0, 0.0, 0.0)
    blender.ops.prt.show_light()
    after = pixels_of(blender.data.images["PRT Light of Sky"])
    assert len(blender.data.images) == count
    for half in (slice(0, 512), slice(512, 1024)):
        assert np.abs(after[:, half] - before[:, half]).max() > 1


def test_picture_of_a_light_without_its_sky(blender, part, scene, sky):
    """An imported light follows no nodes: it is shown alone."""
    part("light").write_still_light(scene.world, np.eye(9)[:, :3])
    blender.ops.prt.show_light()
    assert tuple(blender.data.images["PRT Light of Sky"].size) == (512, 256)


def test_energy_kept(blender, part, scene, stage, sky):
    """All of a sky of order 2; of a sky with a sun next to nothing, band by band as NumPy has it."""
    picture, read_light = part("light_picture"), part("light").read_light
    stage.environment(stage.picture("Small", stage.six_coloured_sky(100)))  # which no other test looks at
    blender.ops.prt.project_light()
    assert not picture.band_energy(scene.world).of_sky and np.isclose(picture.band_energy(scene.world).bands.sum(), 1)
    blender.ops.prt.show_light()
    assert picture.band_energy(scene.world).of_sky
    np.testing.assert_allclose(picture.band_energy(scene.world).bands.sum(), 1, rtol=1e-3)
    pixels = np.full((64, 128, 3), 0.1, dtype=np.float32)
    pixels[40, 20] = 1000
    stage.environment(stage.picture("Sun", pixels))
    blender.ops.prt.project_light()
    assert not picture.band_energy(scene.world).of_sky
    blender.ops.prt.show_light()
    solid_angles = np.diff(np.sin(np.pi * (np.arange(65) / 64 - 0.5))) * 2 * np.pi / 128
    total = solid_angles @ (pixels.astype(float) ** 2).sum(axis=(1, 2))
    bands = [(read_light(scene.world)[here] ** 2).sum() for here in (slice(1), slice(1, 4), slice(4, 9))]
    np.testing.assert_allclose(picture.band_energy(scene.world).bands, np.array(bands) / total, rtol=1e-5)
    assert picture.band_energy(scene.world).bands.sum() < 0.01


def test_probe_in_eevee(blender, part, scene, stage, sky, tmp_path):
    """Each pixel of the sphere is the light along its normal; it follows the world, but neither its own turn nor bakes."""
    _, mapping = sky
    blender.ops.prt.show_light(kind="PROBE")
    probe = blender.data.objects["PRT Light Probe"]
    assert probe.hide_render and not probe.select_get()
    probe.hide_render = False
    probe.rotation_euler = (1.0, 2.0, 3.0)
    stage.top_camera(2.0)
    points = stage.pixel_points(2.0)
    height = 1 - (points**2).sum(axis=-1)
    inside = height > 0.1
    normals = np.concatenate([points, np.sqrt(np.maximum(height, 0))[..., None]], axis=-1)
    for rotation in ((0.4, -0.9, 2.3), (0.0, 0.0, 1.1)):
        mapping.inputs["Rotation"].default_value = rotation
        seen = stage.render(tmp_path / "probe.exr")[..., :3]
        wanted = np.maximum(part("sh").basis(normals) @ part("light").shown_light(scene.world), 0)
        assert np.abs(seen - wanted)[inside].max() < 0.01 * wanted.max()


def test_one_probe_at_the_cursor(blender, part, scene, stage, sky, tmp_path):
    """Shown again, it comes to the 3D cursor; a bake of everything leaves it alone, and Remove takes it away."""
    for place in ((0, 0, 0), (1, 2, 3)):
        scene.cursor.location = place
        blender.ops.prt.show_light(kind="PROBE")
    assert [tuple(ob.location) for ob in scene.objects] == [(1, 2, 3)]
    cube = stage.object_of("Cube", stage.cube())
    layers, probe = part("layers"), scene.objects["PRT Light Probe"].data
    before = layers.read(probe)
    blender.ops.prt.bake(mode="SHADOWED", samples=16)
    assert np.array_equal(layers.read(probe), before) and layers.is_baked(cube.data)
    scene.objects["PRT Light Probe"].select_set(True)
    for chosen in ([], [cube]):  # beside the probe, as after Select All
        for ob in chosen:
            ob.select_set(True)
        blender.ops.prt.bake(mode="UNSHADOWED")
        assert np.array_equal(layers.read(probe), before)
        assert cube.data["prt_bake"]["mode"] == "UNSHADOWED"
        blender.ops.prt.report(points=16, paths=16, filepath=str(tmp_path / "report.json"))
    cube.select_set(False)
    scene.objects["PRT Light Probe"].select_set(False)
    blender.ops.prt.remove()
    assert scene.objects[:] == [cube] and "PRT Light Probe" not in blender.data.materials
    assert not part("light").has_light(scene.world)


def test_small_picture_follows_the_light(blender, part, scene, sky):
    """In memory alone: brightest at one, drawn anew when the world turns, and no image in the file."""
    _, mapping = sky
    picture, count = part("light_picture"), len(blender.data.images)

    def drawn():
        blender.context.view_layer.update()
        picture.icon(scene.world)
        flat = np.empty(64 * 128 * 4, dtype=np.float32)
        part("session").session.icons["light"].image_pixels_float.foreach_get(flat)
        return flat.reshape(64, 128, 4)

    for rotation in ((0.4, -0.9, 2.3), (0.0, 0.0, 1.1)):
        mapping.inputs["Rotation"].default_value = rotation
        shown = drawn()
        light = part("light").shown_light(scene.world)
        wanted = part("preview").display(part("preview").light_picture(light, 64))
        assert shown[..., :3].max() == 1 and np.abs(shown - wanted).max() < 0.005
    assert len(blender.data.images) == count


@pytest.mark.parametrize("kind", ["PICTURE", "PROBE"])
def test_nothing_to_show(blender, scene, kind):
    """Refused with what to do."""
    with pytest.raises(RuntimeError, match="press Project World"):
        blender.ops.prt.show_light(kind=kind)
    assert not scene.objects[:] and not len(blender.data.images)
