# SPDX-License-Identifier: GPL-3.0-or-later
"""File > Export > PRT Web Page writes the scene into the page, or says why it cannot."""

import numpy as np
import pytest

from tests.web.pages import ReadPage

COLOUR = (0.7, 0.3, 0.1)


def settings_of(blender, scene):
    """All settings of renders, exports and views, and what there is in the file."""
    render, view = scene.render, scene.view_settings
    return {
        "render": [render.engine, render.filepath, render.resolution_percentage, render.film_transparent],
        "image": [render.image_settings.file_format, render.image_settings.color_mode, render.image_settings.quality],
        "view": [view.view_transform, view.look, view.exposure, view.gamma],
        "gltf": [scene.prt.gltf.transport, scene.prt.gltf.precision, scene.prt.gltf.light],
        "blocks": [
            sorted(block.name for block in getattr(blender.data, kind))
            for kind in ("images", "scenes", "objects", "worlds")
        ],
    }


@pytest.fixture
def ball(blender, scene, stage):
    """A smooth ball over a flat box, baked and relit, under a turned sky, with a camera."""
    _, mapping = stage.environment(stage.picture("six_colours.exr", stage.six_coloured_sky(64)), strength=1.5)
    mapping.inputs["Rotation"].default_value = (0.4, -0.9, 2.3)
    material = stage.diffuse(colour=COLOUR)
    found = stage.object_of("Ball", stage.icosphere(2), material, (0, 0, 1))
    stage.object_of("Box", stage.cube(), material, (0, 0, -1.2))
    camera = blender.data.objects.new("Camera", blender.data.cameras.new("Camera"))
    camera.location, camera.rotation_euler = (0.0, -9.0, 0.5), (np.pi / 2, 0.0, 0.0)
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.render.resolution_x, scene.render.resolution_y = 160, 90
    blender.ops.prt.bake(mode="INTERREFLECTED", samples=32)
    return found


@pytest.fixture
def export(blender, tmp_path):
    """Export without a still, and read the page."""

    def run(**options):
        path = tmp_path / "page.html"
        assert blender.ops.prt.export_web_page(filepath=str(path), **{"still": False, **options}) == {"FINISHED"}
        return ReadPage(path)

    return run


def test_the_page_holds_transport_to_a_thousandth(blender, scene, part, ball, export):
    """Of what surfaces show, in at most 16 bytes a vertex."""
    page = export()
    light = part("light").shown_light(scene.world)
    for mesh in page.document["meshes"]:
        [primitive] = mesh["primitives"]
        assert not any(name.startswith(("_PRT", "COLOR")) for name in primitive["attributes"])
        found = page.transport(primitive)
        kept = part("layers").read(blender.data.meshes[mesh["name"]])
        shown = np.einsum("nic,ic->nc", kept, light)
        nearest = np.abs(np.einsum("nic,ic->nc", found, light)[:, None] - shown).max(axis=2).min(axis=1)
        assert np.sqrt((nearest**2).mean()) < 2e-3 * np.sqrt((shown**2).mean())


def test_the_page_holds_the_light_the_sky_and_the_camera(scene, part, ball, export):
    page = export(title="A & <B>", sky_height="256")
    [sky] = page.description["skies"]
    light = part("light")
    np.testing.assert_allclose(sky["light"], light.read_light(scene.world))
    np.testing.assert_allclose(sky["turn"], light.read_turn(scene.world), atol=1e-6)
    assert sky["strength"] == pytest.approx(1.5) and sky["name"] == "Six Colours"
    assert page.description["title"] == "A & <B>" and "<title>A &amp; &lt;B&gt;</title>" in page.text
    camera = page.description["camera"]
    np.testing.assert_allclose(camera["position"], (0.0, -9.0, 0.5), atol=1e-6)
    np.testing.assert_allclose(camera["target"], (0.0, 0.0, 0.5), atol=1e-6)
    across, up = camera["tangents"]
    assert across == pytest.approx(18.0 / 50.0) and up == pytest.approx(across * 9 / 16)


def test_blender_reads_its_skies(blender, stage, ball, export, tmp_path):
    """Its own, to the rounding of .hdr; and those that Blender ships, if they are chosen."""
    page = export(skies={"night", "city"})
    assert [sky["name"] for sky in page.description["skies"]] == ["Six Colours", "City", "Night"]
    path = tmp_path / "sky.hdr"
    path.write_bytes(page.files["prt-sky-0"])
    found, wanted = stage.read_exr(path)[..., :3], stage.six_coloured_sky(64)
    assert np.abs(found - wanted).max() <= wanted.max() / 256


def test_its_sky_is_no_larger_than_asked_for(scene, stage, ball, export):
    """And its light stays what it is."""
    stage.environment(stage.picture("Large", stage.six_coloured_sky(1200)))
    stage.bpy.ops.prt.project_light()
    small = export(sky_height="256")
    assert b"-Y 256 +X 512\n" in small.files["prt-sky-0"][:100]


@pytest.mark.parametrize("space", ["SCENE", "OBJECT"])
def test_axes_of_transport_are_told(blender, ball, export, space):
    ball.prt.space = space
    blender.ops.prt.bake(mode="UNSHADOWED")
    page = export()
    spaces = {mesh["name"]: mesh["primitives"][0]["extras"]["prt_relight"]["space"] for mesh in page.document["meshes"]}
    assert spaces == {"Sphere": space, "Cube": "SCENE"}


def test_materials_that_the_exporter_cannot_read(blender, stage, ball, export, capfd):
    """A Diffuse BSDF keeps its colour; one with a picture is white, and named."""
    [material] = export().document["materials"]
    assert material["pbrMetallicRoughness"]["baseColorFactor"][:3] == pytest.approx(COLOUR, abs=1e-6)
    tree = blender.data.materials["Clay"].node_tree
    node = tree.nodes.new("ShaderNodeTexChecker")
    tree.links.new(node.outputs["Color"], tree.nodes["Diffuse BSDF"].inputs["Color"])
    capfd.readouterr()
    export()
    assert "Material 'Clay' is white in the page" in "".join(capfd.readouterr())


def test_stale_bakes_are_named(ball, export, capfd):
    """As far as it is seen at once: here, a move."""
    export()
    assert "is stale" not in "".join(capfd.readouterr())
    ball.location.x += 1.0
    export()
    assert "The bake of 'Ball' is stale" in "".join(capfd.readouterr())


def test_what_does_not_render_stays_at_home(blender, ball, export):
    blender.data.objects["Box"].hide_render = True
    assert [mesh["name"] for mesh in export().document["meshes"]] == ["Sphere"]


def test_view_transforms_are_blenders(blender, scene, part, ball, export, tmp_path):
    """Its tables give what Blender makes of colours, to a third of one of 255 steps; the scene's look is among them."""
    scene.view_settings.view_transform, scene.view_settings.look = "AgX", "AgX - Punchy"
    page = export()
    assert [view["name"] for view in page.description["views"]] == ["Standard", "AgX", "Scene"]
    assert page.description["view"] == 2
    rng = np.random.default_rng(4)
    colours = rng.lognormal(-1.5, 2.0, size=(16, 64, 1)) * 3.0 * rng.dirichlet([2.0, 2.0, 2.0], size=(16, 64))
    colours = colours.astype(np.float32)
    image = part("images").float_image("Colours", colours)
    for look, view in (("None", page.description["views"][1]), ("AgX - Punchy", page.description["views"][2])):
        scene.view_settings.look = look
        output = scene.render.image_settings
        output.file_format, output.color_depth = "PNG", "16"
        path = tmp_path / "view.png"
        image.save_render(str(path), scene=scene)
        shown = blender.data.images.load(str(path), check_existing=False)
        shown.colorspace_settings.name = "Non-Color"
        flat = np.empty(16 * 64 * shown.channels, dtype=np.float32)
        shown.pixels.foreach_get(flat)
        wanted = flat.reshape(16, 64, -1)[..., :3]
        error = np.abs(looked_up(page.files[view["table"]], colours) - wanted) * 255.0
        assert error.max() < 8.0 and np.sqrt((error**2).mean()) < 0.5


def looked_up(table, colours):
    """Colours (..., 3) by a page's table, linearly between its entries."""
    toe, top, size = 0.18 / 64, 0.18 * 256, round((len(table) / 3) ** (1 / 3))
    lattice = np.frombuffer(table, dtype=np.uint8).reshape(size, size, size, 3) / 255.0  # blue, green, red
    at = np.log2(np.clip(colours, 0.0, top) / toe + 1.0) / np.log2(top / toe + 1.0) * (size - 1)
    low = np.minimum(at.astype(int), size - 2)
    share = at - low
    total = np.zeros_like(at)
    for corner in np.ndindex(2, 2, 2):
        weight = np.prod(np.where(corner, share, 1.0 - share), axis=-1, keepdims=True)
        r, g, b = np.moveaxis(low + corner, -1, 0)
        total += weight * lattice[b, g, r]
    return total


def test_the_scene_is_as_it_was(blender, scene, ball, tmp_path):
    """Afterwards, with a still in the page; and the user's own choices for glTF do not matter."""
    scene.prt.gltf.transport, scene.prt.gltf.precision, scene.prt.gltf.light = False, "SHORT", True
    before = settings_of(blender, scene)
    path = tmp_path / "page"
    assert blender.ops.prt.export_web_page(filepath=str(path)) == {"FINISHED"}
    assert settings_of(blender, scene) == before
    page = ReadPage(path.with_suffix(".html"))
    assert "data:image/jpeg;base64,/9j/" in page.text
    assert all("extras" in mesh["primitives"][0] for mesh in page.document["meshes"])


def test_twice_the_same_bytes(blender, ball, tmp_path):
    for name in ("one", "two"):
        blender.ops.prt.export_web_page(filepath=str(tmp_path / f"{name}.html"), still=False)
    assert (tmp_path / "one.html").read_bytes() == (tmp_path / "two.html").read_bytes()


def test_what_cannot_be_exported_is_said(blender, scene, stage, ball, tmp_path):
    """Each in a sentence, and nothing is written."""
    path = tmp_path / "page.html"

    def refused(sentence, **options):
        with pytest.raises(RuntimeError, match=sentence):
            blender.ops.prt.export_web_page(**{"filepath": str(path), "still": False, **options})
        assert not path.exists()

    refused("is a folder", filepath=str(tmp_path))
    refused("no file to write to", filepath="")
    (tmp_path / "file").write_text("")
    refused("cannot be used", filepath=str(tmp_path / "file" / "page.html"))
    world, scene.world = scene.world, None
    refused("no SH light")
    scene.world = world
    for ob in (ball, blender.data.objects["Box"]):
        ob.hide_render = True
    refused("Nothing that renders is baked")


def test_without_a_camera_there_is_no_still(scene, ball, blender, tmp_path, capfd):
    """It is said, and the page begins with all in sight."""
    scene.camera = None
    blender.ops.prt.export_web_page(filepath=str(tmp_path / "page.html"))
    assert "needs a camera" in "".join(capfd.readouterr())
    page = ReadPage(tmp_path / "page.html")
    assert page.description["camera"] is None and "<img" not in page.text
