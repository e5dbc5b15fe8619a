# SPDX-License-Identifier: GPL-3.0-or-later
"""`make course` makes whole files that belong together."""

import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

TOOLS = Path(__file__).resolve().parents[1] / "tools" / "course"
LARGEST_INDEX = 65_535  # of the 16 bits that the course's framework has


@pytest.fixture
def tools(scene, monkeypatch):
    """The modules of the tool, which can be imported once Blender runs."""
    monkeypatch.syspath_prepend(str(TOOLS))
    import boxes
    import cube_map
    import figure

    yield cube_map, figure, boxes
    for name in ("boxes", "cube_map", "figure"):
        sys.modules.pop(name)


def test_faces_are_the_sky_they_were_made_of(blender, part, scene, stage, tools, tmp_path):
    """The light of the faces is that of the panorama: none is swapped, turned or mirrored."""
    cube_map, *_ = tools
    world, _ = stage.environment(stage.picture("Six", stage.six_coloured_sky() / 8.0))
    blender.ops.prt.project_light()
    expected = part("light").read_light(world)
    image = next(node.image for node in world.node_tree.nodes if node.type == "TEX_ENVIRONMENT")
    image.filepath_raw, image.file_format = str(tmp_path / "six.exr"), "OPEN_EXR"
    image.save()
    cube_map.write_faces(tmp_path / "six.exr", tmp_path / "faces")
    blender.ops.prt.import_cubemap(directory=str(tmp_path / "faces"))
    np.testing.assert_allclose(part("light").read_light(scene.world), expected, atol=0.02 * np.abs(expected).max())


def test_files_belong_to_the_figure(blender, stage, tools, tmp_path):
    """One row per corner of the .obj that is written beside them; few enough corners for the course's framework."""
    stage.environment(stage.picture("Six", stage.six_coloured_sky(32)))
    figure = tools[1].build()
    corners = 3 * len(figure.data.polygons)
    assert {len(face.vertices) for face in figure.data.polygons} == {3}
    assert 20_000 < corners < LARGEST_INDEX
    blender.ops.prt.bake(mode="SHADOWED", samples=4)
    blender.ops.prt.export_games202(directory=str(tmp_path))
    transport = np.loadtxt(tmp_path / "transport.txt", skiprows=1)
    assert transport.shape == (corners, 9) and np.loadtxt(tmp_path / "light.txt").shape == (9, 3)
    below = [np.linalg.norm(v.co.xy) < 0.3 and v.co.z < 0.01 for v in figure.data.vertices]
    corner_vertex = np.array([index for face in figure.data.polygons for index in face.vertices])
    on_disc = np.array(below)[corner_vertex]
    assert transport[on_disc, 0].mean() < 0.8 * transport[:, 0].max(), "the skirt shades the disc"


def test_boxes_carry_their_colours(blender, stage, tools, tmp_path):
    """In the .obj, where the page reads them, and in what is baked: the grey floor beside the red box turns red."""
    stage.environment(stage.picture("White", np.ones((16, 32, 3))))
    boxes = tools[2].build()
    mesh = boxes.data
    blender.ops.wm.obj_export(filepath=str(tmp_path / "boxes.obj"), export_materials=False, export_colors=True)
    lines = (tmp_path / "boxes.obj").read_text().splitlines()
    assert len({tuple(line.split()[4:]) for line in lines if line.startswith("v ")}) == 5
    assert {len(face.vertices) for face in mesh.polygons} == {3}
    blender.ops.prt.bake(mode="INTERREFLECTED", samples=16)
    layer = mesh.attributes["_PRT_0"]
    rgba = np.empty(4 * len(layer.data), dtype=np.float32)
    layer.data.foreach_get("color", rgba)
    vertices = [loop.vertex_index for loop in mesh.loops] if layer.domain == "CORNER" else range(len(mesh.vertices))
    places = np.array([mesh.vertices[index].co for index in vertices])
    beside = (places[:, 2] == 0.0) & (np.linalg.norm(places[:, :2] - (0.8, -0.4), axis=1) < 0.15)
    red, green, _, _ = rgba.reshape(-1, 4)[beside].mean(axis=0)
    assert red > 1.03 * green


def test_pictures_of_the_page_are_small():
    pictures = list((TOOLS.parents[1] / "docs" / "pictures" / "course").iterdir())
    assert len(pictures) > 6
    for path in pictures:
        assert path.stat().st_size < 150_000, path.name
        Image.open(path).verify()
