# SPDX-License-Identifier: GPL-3.0-or-later
"""`bpy.ops.prt.report`: what it measures of real scenes, what it leaves behind, and what it refuses."""

import json

import numpy as np
import pytest

from tests.operators.report.conftest import FEW


@pytest.fixture
def sky(stage):
    """A soft sky of order 2, turned, at some strength; the cosine alone finds it, which spares Cycles a map of it."""
    world, mapping = stage.environment(stage.picture("Six", stage.six_coloured_sky()), strength=0.7)
    mapping.inputs["Rotation"].default_value = (0.4, -0.9, 2.3)
    world.cycles.sampling_method = "NONE"
    return mapping


@pytest.fixture
def room(blender, scene, stage, sky):
    """A grey floor of some cells, as large as the camera's picture, and a wall that shades it from outside of it."""

    def build(cells, pixels=32):
        floor = stage.object_of("Floor", stage.grid(cells, 1.0), stage.diffuse("Grey", (0.8, 0.8, 0.8)))
        wall = stage.object_of("Wall", stage.grid(4, 0.8), stage.diffuse("Red", (0.8, 0.1, 0.1)), (-1.1, 0.0, 0.85))
        wall.rotation_euler.y = np.pi / 2
        stage.top_camera(scale=2.0, resolution=pixels)
        scene.cycles.filter_width = 0.01  # a pixel is a point, as EEVEE's are on this stage: noise is not blurred
        floor.select_set(True)
        blender.context.view_layer.objects.active = floor
        return floor

    return build


def value(document, part):
    return document["all"][part]["relative_rms"]["value"]


def half(number):
    return (number["high"] - number["low"]) / 2.0


def sunny(stage):
    """A sky whose sun carries half of its light."""
    pixels = np.full((64, 128, 3), 0.2, dtype=np.float32)
    ring = np.diff(np.sin(np.pi * (np.array([46, 47]) / 64 - 0.5)))[0]
    pixels[46, 64] = 0.2 * 4.0 * np.pi / (2.0 * np.pi / 128 * ring)
    world, _ = stage.environment(stage.picture("Sun", pixels))
    world.cycles.sampling_method, world.cycles.sample_map_resolution = "MANUAL", 256


def test_all_parts_of_a_soft_fine_scene_are_small(blender, report, room):
    """As baked, sky turned and scaled: nothing is wrong with it, and it says so in words."""
    room(32)
    blender.ops.prt.bake(mode="INTERREFLECTED", samples=256)
    document = report()
    assert value(document, "total") < 0.02 and not document["stale"]
    [floor] = document["objects"]
    assert (floor["name"], floor["mode"], floor["samples"], floor["points"]) == ("Floor", "INTERREFLECTED", 256, 64)
    assert floor["area"] == pytest.approx(4.0)
    assert "more samples would not be seen" in document["all"]["advice"]["sampling"]
    assert "order 2 is enough" in document["all"]["advice"]["truncation"]
    assert document["lamps"] == {"count": 0, "share_of_light": 0.0, "shown": False}
    assert document["all"]["truncation"]["without_lamps"] is None and "rest" not in document["all"]["advice"]


def test_error_is_found_where_it_was_put(blender, part, report, room):
    """Transport that was made brighter by a tenth: in the whole, and in no part of it."""
    floor = room(32)
    blender.ops.prt.bake(mode="SHADOWED", samples=256)
    for name in part("layers").LAYERS:
        data = floor.data.attributes[name].data
        rgba = np.empty(4 * len(data), dtype=np.float32)
        data.foreach_get("color", rgba)
        data.foreach_set("color", (rgba.reshape(-1, 4) * (1.1, 1.1, 1.1, 1.0)).astype(np.float32).reshape(-1))
    document = report()
    assert value(document, "total") == pytest.approx(0.1, abs=0.01)
    assert document["all"]["total"]["bias"]["value"] == pytest.approx(0.1, abs=0.01)
    assert max(value(document, part) for part in ("sampling", "truncation", "tessellation")) < 0.02
    assert "in none of these parts" in document["all"]["advice"]["rest"]


def test_covered_corners_are_blamed(blender, stage, report, sky):
    """A road of one quad whose corners lie in its kerbs: the error sits there; cut at the kerbs it does not."""
    road = stage.object_of("Road", stage.grid(1, 1.0), stage.diffuse())
    road.scale = (10, 2, 1)
    for y in (-2.0, 2.0):
        kerb = stage.object_of(f"Kerb {y}", stage.cube(1.0), None, (0, y, 0.05))
        kerb.scale = (20.5, 0.6, 0.5)
    road.select_set(True)
    blender.context.view_layer.update()
    blender.ops.prt.bake(mode="SHADOWED", samples=256)
    document = report()
    assert document["all"]["seams"]["relative_rms"]["value"] == pytest.approx(value(document, "total"), rel=0.1)
    assert "'Road': cut or subdivide these faces where the meshes meet" in document["all"]["advice"]["seams"]
    road.scale.y = 1.6
    blender.context.view_layer.update()
    blender.ops.prt.bake(mode="SHADOWED", samples=256)
    assert "seams" not in report()["all"]["advice"]


@pytest.mark.parametrize("mode", ["UNSHADOWED", "SHADOWED", "INTERREFLECTED"])
def test_flat_turned_and_mirrored_objects_in_their_own_axes(blender, stage, report, sky, mode):
    """Baked for itself, flat faces on corners, then moved: the light is turned into its axes."""
    cube = stage.object_of("Steps", stage.icosphere(2, smooth=False), stage.diffuse())
    cube.scale, cube.prt.space = (1.0, 0.5, -2.0), "OBJECT"
    stage.object_of("Roof", stage.grid(2, 9.0), None, (0, 0, 4))  # shades others, and not what may move
    cube.select_set(True)
    blender.ops.prt.bake(mode=mode, samples=256)
    cube.rotation_euler, cube.location = (0.3, 1.1, -0.7), (3.0, 0.0, -2.0)
    blender.context.view_layer.update()
    assert value(report(), "total") < 0.01


def test_objects_keep_their_own_settings(blender, stage, report, sky):
    """Two bakes of two kinds in one report, each judged by its own light."""
    for name, x in (("A", -2), ("B", 2)):
        stage.object_of(name, stage.icosphere(3), stage.diffuse(), (x, 0, 0))
        stage.object_of("Floor" + name, stage.grid(16, 1.5), None, (x, 0, -1.3))
    for name, mode, samples in (("A", "SHADOWED", 16), ("B", "INTERREFLECTED", 256)):
        for ob in blender.data.objects:
            ob.select_set(ob.name == name)
        blender.ops.prt.bake(mode=mode, samples=samples)
    for ob in blender.data.objects:
        ob.select_set(False)
    a, b = report()["objects"]
    assert (a["name"], a["mode"], b["name"], b["mode"]) == ("A", "SHADOWED", "B", "INTERREFLECTED")
    assert a["sampling"]["relative_rms"]["low"] > b["sampling"]["relative_rms"]["high"]
    assert a["total"]["relative_rms"]["value"] < 0.05 and b["total"]["relative_rms"]["value"] < 0.03


def test_coarse_surroundings_are_blamed(blender, stage, report, sky):
    """A ball that floats over one large, unbaked quad: what bounces off it is wrong, and finer meshes would help."""
    ball = stage.object_of("Ball", stage.icosphere(4), stage.diffuse())
    floor = stage.object_of("Floor", stage.grid(2, 1.5), None, (0, 0, -1.05))
    ball.select_set(True)
    blender.ops.prt.bake(mode="INTERREFLECTED", samples=256)
    document = report()
    assert "subdivide what light bounces off" in document["all"]["advice"]["rest"]
    floor.data = stage.grid(48, 1.5)
    blender.ops.prt.bake(mode="INTERREFLECTED", samples=256)
    finer = report()
    assert "rest" not in finer["all"]["advice"] and value(finer, "total") < 0.5 * value(document, "total")


@pytest.mark.parametrize(
    "build, cells, samples, mode",
    [
        pytest.param(sunny, 24, 64, "SHADOWED", id="truncation", marks=pytest.mark.slow),
        pytest.param(None, 2, 256, "INTERREFLECTED", id="tessellation", marks=pytest.mark.slow),
        pytest.param(None, 27, 4, "SHADOWED", id="sampling"),
    ],
)
def test_parts_add_up_to_the_error_of_the_picture(blender, scene, stage, report, room, build, cells, samples, mode):
    """Three scenes, each ruled by another part: the root of the sum of squares is EEVEE's distance from Cycles."""
    room(cells)
    if build:
        build(stage)
    blender.ops.prt.bake(mode=mode, samples=samples, bounces=2, lamps="NONE")
    document = report(
        parts={"SAMPLING", "TRUNCATION", "TESSELLATION", "END_TO_END"}, points=512, paths=64, picture_samples=64
    )
    found = [document["all"][part]["relative_rms"] for part in ("sampling", "truncation", "tessellation")]
    together = np.sqrt(sum(number["value"] ** 2 for number in found))
    picture = document["end_to_end"]["relative_rms"]
    margin = np.sqrt(half(picture) ** 2 + sum((number["value"] * half(number)) ** 2 for number in found) / together**2)
    print([number["value"] for number in found], together, picture, margin, document["end_to_end"])
    assert abs(together - picture["value"]) < margin + 0.002  # half floats, and pixels at the floor's edge
    assert picture["value"] > 0.02 and margin < 0.25 * picture["value"]
    assert document["end_to_end"]["pixels"] > 900
    assert 0.0 < document["end_to_end"]["flip"] < 1.0


def test_pictures_leave_everything_as_it_was(blender, scene, report, room, tmp_path):
    """Settings, visibility and images; the difference is kept as image and file, of what was baked alone."""
    room(4, pixels=16)
    scene.render.image_settings.file_format, scene.render.filepath = "JPEG", "//somewhere"
    scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.max_bounces = 77, True, 5
    blender.ops.prt.bake(mode="SHADOWED", samples=4)
    owners = [scene.render, scene.render.image_settings, scene.cycles, scene.eevee, *scene.objects]
    before, images = [snapshot(owner) for owner in owners], set(blender.data.images.keys())
    document = report(parts={"END_TO_END"}, picture_samples=4)
    assert [snapshot(owner) for owner in owners] == before
    assert set(blender.data.images.keys()) - images <= {"PRT Difference", "Render Result"}
    difference = blender.data.images["PRT Difference"]
    assert tuple(difference.size) == (16, 16) and (tmp_path / "report_difference.exr").stat().st_size > 0
    assert document["end_to_end"]["difference"] == str(tmp_path / "report_difference.exr")
    assert "all" not in document and document["end_to_end"]["advice"].startswith("EEVEE's picture is")
    report(parts={"END_TO_END"}, picture_samples=4)
    assert len([image for image in blender.data.images if image.name.startswith("PRT")]) == 1


def snapshot(owner):
    """All plain settings of a piece of Blender's data."""
    plain = {"BOOLEAN", "INT", "FLOAT", "STRING", "ENUM"}
    return {p.identifier: repr(getattr(owner, p.identifier)) for p in owner.bl_rna.properties if p.type in plain}


def test_heat_map_comes_and_goes(blender, part, stage, report, room):
    """Dark where the transport was darkened, white elsewhere; gone with the next report, and with Remove."""
    floor = room(8)
    floor.data.color_attributes.new("Paint", "FLOAT_COLOR", "POINT")
    floor.data.color_attributes.active_color_name = "Paint"
    blender.ops.prt.bake(mode="SHADOWED", samples=256)
    for name in part("layers").LAYERS:
        for item in floor.data.attributes[name].data[:9]:
            item.color[:3] = [0.0, 0.0, 0.0]
    layer = part("heat_map").LAYER
    report(parts=set(), heat_map=True)
    colours = np.array([item.color[:] for item in floor.data.attributes[layer].data])
    assert floor.data.color_attributes.active_color_name == layer
    np.testing.assert_allclose(colours[:9], np.tile((0.0, 0.0, 1.0, 1.0), (9, 1)), atol=1e-6)
    assert colours[9:].min() > 0.6
    report(parts=set(), heat_map=True)
    assert [each.name for each in floor.data.attributes].count(layer) == 1
    report(parts={"SAMPLING"})
    assert layer not in floor.data.attributes and floor.data.color_attributes.active_color_name == "Paint"
    report(parts=set(), heat_map=True)
    blender.ops.prt.remove()
    assert layer not in floor.data.attributes and "prt_report" not in blender.context.scene
    assert not [key for key in floor.data.keys() if key.startswith("prt_")]  # noqa: SIM118 - an ID is no dict


def test_file_lies_beside_the_blend(blender, scene, room, tmp_path):
    """Without a path: beside the file, or in the temporary folder."""
    room(2)
    blender.ops.prt.bake(mode="UNSHADOWED")
    blender.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    blender.ops.prt.report(**FEW)
    assert json.loads((tmp_path / "scene.prt_report.json").read_text())["scene"] == blender.context.scene.name


def test_settings_come_from_the_scene_unless_given(blender, scene, room, tmp_path):
    """And the name of the file is kept as it was given, points and all."""
    room(2)
    blender.ops.prt.bake(mode="UNSHADOWED")
    scene.prt.report.points, scene.prt.report.paths = 32, 16
    for given, points in (({}, 32), ({"points": 48}, 48)):
        blender.ops.prt.report(filepath=str(tmp_path / "report_v1.2"), **given)
        [floor] = json.loads((tmp_path / "report_v1.2.json").read_text())["objects"]
        assert floor["points"] == points
    assert scene.prt.report.points == 32


def test_no_path_is_relative_to_a_file_that_was_never_saved(blender, scene, room):
    """Wherever the process happens to run is no place to write to."""
    room(2)
    blender.ops.prt.bake(mode="UNSHADOWED")
    with pytest.raises(RuntimeError, match="never saved"):
        blender.ops.prt.report(filepath="//report.json", **FEW)
    with pytest.raises(RuntimeError, match="no folder"):
        blender.ops.prt.export_games202()


def test_reports_of_all_scenes_go_with_the_last_bake(blender, scene, room):
    """Remove without a selection reaches what renders do not show, too."""
    floor = room(2)
    blender.ops.prt.bake(mode="UNSHADOWED")
    blender.ops.prt.report(**FEW)
    other = blender.data.scenes.new("Other")
    other["prt_report"] = scene["prt_report"]
    floor.hide_render = True
    floor.select_set(False)
    blender.ops.prt.remove()
    assert "prt_report" not in scene and "prt_report" not in other
    assert "_PRT_0" not in floor.data.attributes


def test_stale_bakes_are_told(blender, report, room):
    """What changed since is counted as error, and said to be."""
    floor = room(8)
    blender.ops.prt.bake(mode="SHADOWED", samples=64)
    blender.data.objects["Wall"].location.z -= 0.3
    blender.context.view_layer.update()
    document = report(parts={"SAMPLING"})
    assert len(document["stale"]) == 1 and "other objects changed or moved" in document["stale"][0]
    assert value(document, "total") > 0.015
    assert floor.name in document["stale"][0]


def refusals(blender, scene, part):
    """Ways to break a good scene, each with what is said, and with the parts that are measured."""
    floor = blender.data.objects["Floor"]
    return {
        "nothing baked": (blender.ops.prt.remove, "None of these objects is baked"),
        "edited": (lambda: crumple(floor.data), "does not fit its mesh"),
        "other space": (lambda: setattr(floor.prt, "space", "OBJECT"), "baked for 'Scene' and is now set to 'Object'"),
        "no light": (lambda: part("light").remove_light(scene.world), "press Project World"),
        "no world": (lambda: setattr(scene, "world", None), "has no world"),
        "no camera": (lambda: setattr(scene, "camera", None), "has no camera"),
        "no shading": (blender.ops.prt.remove_shading, "press Add Shading"),
    }


def crumple(mesh):
    """Facets where the bake saw a plane."""
    mesh.vertices[5].co.z += 0.2
    mesh.shade_flat()


@pytest.mark.parametrize(
    "case", ["nothing baked", "edited", "other space", "no light", "no world", "no camera", "no shading"]
)
def test_refusals_are_one_sentence_and_change_nothing(blender, scene, part, room, case, tmp_path):
    """Before any work."""
    room(3, pixels=16)
    blender.ops.prt.bake(mode="SHADOWED", samples=4)
    spoil, said = refusals(blender, scene, part)[case]
    spoil()
    with pytest.raises(RuntimeError, match=said):
        blender.ops.prt.report(filepath=str(tmp_path / "no.json"), parts={"SAMPLING", "END_TO_END"}, **FEW)
    assert "prt_report" not in scene and not (tmp_path / "no.json").exists()


def test_imported_transport_has_nothing_to_be_judged_by(blender, room, tmp_path):
    """Its settings and its sky are not here."""
    room(3)
    blender.ops.prt.bake(mode="SHADOWED", samples=4)
    blender.ops.prt.export_games202(directory=str(tmp_path))
    blender.ops.prt.import_games202(directory=str(tmp_path))
    with pytest.raises(RuntimeError, match=r"prt\.project_light"):
        blender.ops.prt.report(**FEW)
    blender.ops.prt.project_light()
    with pytest.raises(RuntimeError, match="was not baked here"):
        blender.ops.prt.report(**FEW)
