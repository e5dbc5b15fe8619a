# SPDX-License-Identifier: GPL-3.0-or-later
"""`prt.freeze`: the colour attribute is what EEVEE shows, in every encoding and in either axes."""

import numpy as np
import pytest


@pytest.fixture
def ball(blender, scene, stage):
    """A white ball over a floor, under a sky of six colours that is turned."""
    _, mapping = stage.environment(stage.picture("Six", stage.six_coloured_sky(64)), strength=0.3)
    mapping.inputs["Rotation"].default_value = (0.4, -0.9, 2.3)
    found = stage.object_of("Ball", stage.icosphere(4), stage.diffuse("White", (1.0, 1.0, 1.0)))
    stage.object_of("Floor", stage.grid(8, 3.0), stage.diffuse("Floor"), (0, 0, -1.1))
    return found


def colours(ob):
    data = ob.data.attributes["PRT Light"].data
    found = np.empty((len(data), 4), dtype=np.float32)
    data.foreach_get("color", found.ravel())
    return found[:, :3]


@pytest.mark.parametrize("space", ["SCENE", "OBJECT"])
def test_it_is_what_eevee_shows(blender, scene, stage, ball, tmp_path, space):
    """Looked down upon: pixels in the middle of the ball have the colours of the nearest vertices."""
    ball.prt.space, ball.rotation_euler = space, (0.5, 0.2, 1.0)
    blender.context.view_layer.update()
    blender.ops.prt.bake(mode="SHADOWED", samples=64)
    assert blender.ops.prt.freeze() == {"FINISHED"}
    stage.top_camera(scale=3.0)
    frame = stage.render(tmp_path / "frame.exr")[..., :3]
    places = np.array([ball.matrix_world @ vertex.co for vertex in ball.data.vertices])
    pixels = stage.pixel_points(scale=3.0)
    checked = 0
    for row, column in zip(*np.nonzero(np.linalg.norm(pixels, axis=-1) < 0.6), strict=True):
        distance = np.linalg.norm(places[:, :2] - pixels[row, column], axis=1) + 9.0 * (places[:, 2] < 0.0)
        if distance.min() < 0.01:
            np.testing.assert_allclose(colours(ball)[distance.argmin()], frame[row, column], atol=0.015)
            checked += 1
    assert checked > 5


def test_encodings(blender, part, scene, ball):
    """Floats in linear light, floats as screens show them, and bytes: one light; another freeze takes the place of the first."""
    blender.ops.prt.bake(mode="SHADOWED", samples=32)
    found = {}
    for encoding in ("LINEAR", "SRGB", "BYTE"):
        assert blender.ops.prt.freeze(encoding=encoding) == {"FINISHED"}
        found[encoding] = colours(ball)
        assert ball.data.attributes["PRT Light"].data_type == ("BYTE_COLOR" if encoding == "BYTE" else "FLOAT_COLOR")
    decode = part("equirect_projection").srgb_to_linear
    np.testing.assert_allclose(decode(found["SRGB"]), found["LINEAR"], atol=1e-5)
    np.testing.assert_allclose(found["BYTE"], np.minimum(found["LINEAR"], 1.0), atol=0.01)
    assert [name for name in ball.data.attributes.keys() if name.startswith("PRT")] == ["PRT Light"]  # noqa: SIM118


def test_what_cannot_be_frozen_is_said(blender, scene, stage, ball, capfd):
    """Carried transport, and light that bytes cannot hold; the rest is done."""
    with pytest.raises(RuntimeError, match="None of these objects is baked"):
        blender.ops.prt.freeze()
    blender.data.objects["Floor"].modifiers.new("Finer", "SUBSURF").render_levels = 1
    blender.ops.prt.bake(mode="UNSHADOWED")
    scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 30.0
    blender.context.view_layer.update()
    capfd.readouterr()
    assert blender.ops.prt.freeze(encoding="BYTE") == {"FINISHED"}
    said = capfd.readouterr().out
    assert "The light of 'Floor' is not frozen" in said and "'Ball' is brighter than bytes can hold" in said
    assert "Froze the light of 1 object(s)" in said and "PRT Light" not in blender.data.objects["Floor"].data.attributes
