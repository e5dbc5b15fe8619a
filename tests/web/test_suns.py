# SPDX-License-Identifier: GPL-3.0-or-later
"""Suns of the sky in exported pages: lamps with soft shadows, as EEVEE has them, in place of their part of the stored light."""

import numpy as np
import pytest

from tests.core.references import axis_angle
from tests.web.conftest import look_from, matte
from tests.web.pages import ReadPage
from tests.web.test_page import hdr
from tests.web.views import HEIGHT, WIDTH, eevee, relative_rms

pytestmark = pytest.mark.once

FRAME = f"prt.radiance({WIDTH}, {HEIGHT})"


@pytest.fixture
def sunny(blender, scene, stage):
    """A ball, and a turned box in its own axes, above a floor under a sky with a sun of three degrees, which is turned."""
    _, mapping = stage.environment(stage.picture("Sunny", stage.sunny_sky()), strength=0.5)
    mapping.inputs["Rotation"].default_value = (0.1, -0.2, 1.3)
    stage.object_of("Ball", stage.icosphere(5, 0.8), matte(blender, stage, "Clay", (0.8, 0.5, 0.2)), (-0.5, 0, 1.2))
    stage.object_of("Floor", stage.grid(60, 3.0), matte(blender, stage, "Ground", (0.6, 0.7, 0.6)))
    box = stage.object_of("Box", stage.cube(0.8), matte(blender, stage, "Other", (0.3, 0.6, 0.5)), (1.2, -0.6, 0.8))
    box.rotation_euler, box.scale, box.prt.space = (0.4, 0.3, 0.8), (1.0, 0.7, 1.4), "OBJECT"
    look_from(blender, scene, (4.0, -7.0, 4.2), (1.05, 0.0, 0.52))
    blender.ops.prt.bake(mode="INTERREFLECTED", samples=64, lamps="ONE")
    return scene


@pytest.fixture
def page(blender, sunny, tmp_path):
    path = tmp_path / "page.html"
    blender.ops.prt.export_web_page(filepath=str(path), still=False)
    return path


def rendered(stage, scene, path):
    """EEVEE's frame, of as many samples as soft shadows take."""
    eevee(stage, scene, path)
    scene.eevee.taa_render_samples = 32
    return stage.render(path)


def test_pixels_are_eevees(blender, part, stage, sunny, page, browser, tmp_path):
    """With shadows where EEVEE casts them, before a turn of the sky and after; nearly so in the movements of slow machines."""
    coarse = FRAME.replace(")", ", true)")
    steps = [FRAME, coarse, "prt.shading = 'unshadowed'", FRAME, "prt.shading = 'baked'", "prt.turn = 1.0", FRAME]
    answers = browser.open(page, steps, WIDTH, HEIGHT)
    first, moving, plain, turned = (answers[k].reshape(HEIGHT, WIDTH, 4) for k in (0, 1, 3, 6))
    wanted = rendered(stage, sunny, tmp_path / "eevee.exr")
    seen = (wanted[..., 3] > 0.999) & (first[..., 3] > 0.999)
    assert seen.mean() > 0.3 and relative_rms(first[seen], wanted[seen]) < 0.03
    assert relative_rms(moving[seen], wanted[seen]) < 0.05 and relative_rms(plain[seen], wanted[seen]) > 0.1
    from mathutils import Matrix

    matrix = part("light").read_turn(sunny.world) @ axis_angle((0, 0, 1), 1.0).T
    sunny.world.node_tree.nodes["Mapping"].inputs["Rotation"].default_value = Matrix(matrix).to_euler("XYZ")
    blender.context.view_layer.update()
    other = rendered(stage, sunny, tmp_path / "turned.exr")
    assert relative_rms(turned[seen], other[seen]) < 0.03 and relative_rms(other[seen], wanted[seen]) > 0.1


def test_the_page_names_suns_and_what_is_theirs(blender, part, stage, sunny, page, tmp_path):
    """Of the scene's own sky and of others, if lamps are wanted; then all that is baked carries its direct part."""
    assert ReadPage(page).description["mostSuns"] == 4
    [sky] = ReadPage(page).description["skies"]
    np.testing.assert_allclose(sky["lamps"], part("light").read_lamps(sunny.world), rtol=1e-6)
    [sun] = sky["suns"]
    assert np.dot(sun["direction"], stage.SUN) > 0.9999 and sun["radius"] == pytest.approx(np.radians(3.0), rel=0.1)
    other = tmp_path / "other.html"
    blender.ops.prt.export_web_page(filepath=str(other), still=False, skies={"forest"})
    document, skies = ReadPage(other).document, ReadPage(other).description["skies"]
    assert skies[1]["suns"] and np.any(skies[1]["lamps"])
    assert all("direct" in mesh["primitives"][0]["extras"]["prt_relight"] for mesh in document["meshes"])
    sunny.prt.lamps = "NONE"
    blender.ops.prt.project_light()
    blender.ops.prt.export_web_page(filepath=str(other), still=False, skies={"forest"})
    document, skies = ReadPage(other).document, ReadPage(other).description["skies"]
    assert not any(sky["suns"] or np.any(sky["lamps"]) for sky in skies)
    assert ReadPage(other).description["mostSuns"] == 0
    assert not any("direct" in mesh["primitives"][0]["extras"]["prt_relight"] for mesh in document["meshes"])


def test_a_dropped_sky_gets_its_suns(stage, page, browser):
    """As Blender would take them out; it casts another shadow than before, and its light holds them."""
    from prt_addon.core.sky.lamps import find_lamps

    sky = stage.sunny_sky(256)[:, ::-1]
    [wanted] = find_lamps(sky, 4).lamps
    steps = [
        FRAME,
        {"drop": {"name": "Mirrored.hdr", "data": hdr(sky)}},
        "prt.skies[prt.sky].suns",
        "[...prt.skies[prt.sky].lamps]",
        FRAME,
    ]
    before, _, [sun], lamps, after = browser.open(page, steps, WIDTH, HEIGHT)
    assert np.dot(sun["direction"], wanted.direction) > 0.99999
    assert np.mean(sun["irradiance"]) == pytest.approx(wanted.irradiance, rel=0.02)
    assert sun["radius"] == pytest.approx(wanted.radius, rel=0.02) and max(lamps) > 0.1
    assert relative_rms(after.reshape(-1, 4), before.reshape(-1, 4)) > 0.1
