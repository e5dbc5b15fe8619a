# SPDX-License-Identifier: GPL-3.0-or-later
"""`prt.show_transport`: the colours are the coefficients, come and go, and are what a view shows."""

import numpy as np
import pytest

LAYER = "PRT Transport"


@pytest.fixture
def ball(blender, scene, stage):
    """A white ball over a red floor."""
    stage.environment(stage.picture("Six", stage.six_coloured_sky(16)))
    found = stage.object_of("Ball", stage.icosphere(4), stage.diffuse("White", (1.0, 1.0, 1.0)))
    stage.object_of("Floor", stage.grid(8, 3.0), stage.diffuse("Floor", (0.9, 0.1, 0.1)), (0, 0, -1.1))
    return found


def colours(ob):
    data = ob.data.attributes[LAYER].data
    found = np.empty((len(data), 4), dtype=np.float32)
    data.foreach_get("color", found.ravel())
    return found[:, :3]


def test_an_open_surface_is_white_in_every_band(blender, ball):
    """By the addition theorem; and its coefficients of band 1 are its normal, about grey."""
    blender.ops.prt.bake(mode="UNSHADOWED")
    for part in ("T0", "BAND1", "BAND2"):
        assert blender.ops.prt.show_transport(part=part) == {"FINISHED"}
        np.testing.assert_allclose(colours(ball), 1.0, atol=2e-3)
    normals = np.array([vertex.normal for vertex in ball.data.vertices])
    for part, axis in (("T1", 1), ("T2", 2), ("T3", 0)):
        blender.ops.prt.show_transport(part=part)
        np.testing.assert_allclose(colours(ball)[:, 0], 0.5 + 0.5 * normals[:, axis], atol=2e-3)


def test_colours_are_what_was_baked(blender, part, ball):
    """Coefficient by coefficient; the floor's red reaches the ball from below."""
    blender.ops.prt.bake(mode="INTERREFLECTED", samples=64, bounces=1)
    baked = part("layers").read(ball.data)
    blender.ops.prt.show_transport(part="T0")
    np.testing.assert_allclose(colours(ball), baked[:, 0] / 0.2820948, rtol=1e-4)
    below = np.array([vertex.co.z < -0.9 for vertex in ball.data.vertices])
    red, green, _ = colours(ball)[below].mean(axis=0)
    assert red > green + 0.05
    for index in range(4, 9):
        blender.ops.prt.show_transport(part=f"T{index}")
        np.testing.assert_allclose((2.0 * colours(ball) - 1.0) * 0.157696, baked[:, index], atol=1e-6)


def test_they_come_and_go(blender, ball):
    """The user's own colours are active again: after hiding, after another bake, and after removing."""
    ball.data.color_attributes.new("Paint", "BYTE_COLOR", "CORNER")
    ball.data.color_attributes.active_color_name = "Paint"

    def shown(of_ball):
        return LAYER in ball.data.attributes, ball.data.color_attributes.active_color_name == of_ball

    for take_away in (blender.ops.prt.hide_transport, blender.ops.prt.bake, blender.ops.prt.remove):
        blender.ops.prt.bake(mode="UNSHADOWED")
        blender.ops.prt.show_transport(part="T0")
        blender.ops.prt.show_transport(part="BAND1")
        assert shown(LAYER) == (True, True)
        take_away()
        assert shown("Paint") == (False, True)
        assert not [key for key in ball.data.keys() if "active" in key]  # noqa: SIM118


def test_a_view_shows_them(blender, scene, stage, ball, tmp_path):
    """Workbench, which draws views in Solid shading, shows T_0 of the open top."""
    blender.ops.prt.bake(mode="SHADOWED", samples=64)
    blender.ops.prt.show_transport(part="T0")
    stage.top_camera(scale=3.0)
    shading = scene.display.shading
    shading.light, shading.color_type = "FLAT", "VERTEX"
    frame = stage.render(tmp_path / "frame.exr", "BLENDER_WORKBENCH")
    middle = frame[28:36, 28:36, :3].mean()
    scene.display.shading.color_type = "SINGLE"
    assert middle == pytest.approx(1.0, abs=0.02)
    assert stage.render(tmp_path / "frame.exr", "BLENDER_WORKBENCH")[28:36, 28:36, :3].mean() < 0.9


def test_what_cannot_be_shown_is_said(blender, stage, ball, capfd):
    with pytest.raises(RuntimeError, match="None of these objects is baked"):
        blender.ops.prt.show_transport()
    blender.data.objects["Floor"].modifiers.new("Finer", "SUBSURF").render_levels = 1
    blender.ops.prt.bake(mode="UNSHADOWED")
    capfd.readouterr()
    assert blender.ops.prt.show_transport() == {"FINISHED"}
    said = capfd.readouterr().out
    assert "'Floor' cannot show its transport" in said and "1 object(s) show their transport" in said
    assert LAYER not in blender.data.objects["Floor"].data.attributes
