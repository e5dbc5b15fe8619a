# SPDX-License-Identifier: GPL-3.0-or-later
"""Suns of the sky in exported pages: lamps with soft shadows, as EEVEE has them, in place of their part of the stored light."""

import gzip

import numpy as np
import pytest

from tests.core.references import axis_angle
from tests.web.conftest import dent, lay_out, look_from, matte
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


def test_pixels_are_eevees(blender, part, stage, sunny, page, browser, tmp_path):
    """With shadows where EEVEE casts them, before a turn of the sky and after; nearly so in the movements of slow machines."""
    coarse = FRAME.replace(")", ", true)")
    steps = [FRAME, coarse, "prt.shading = 'unshadowed'", FRAME, "prt.shading = 'baked'", "prt.turn = 1.0", FRAME]
    answers = browser.open(page, steps, WIDTH, HEIGHT)
    first, moving, plain, turned = (answers[k].reshape(HEIGHT, WIDTH, 4) for k in (0, 1, 3, 6))
    wanted = eevee(stage, sunny, tmp_path / "eevee.exr", samples=12)
    seen = (wanted[..., 3] > 0.999) & (first[..., 3] > 0.999)
    assert seen.mean() > 0.3 and relative_rms(first[seen], wanted[seen]) < 0.03
    assert relative_rms(moving[seen], wanted[seen]) < 0.05 and relative_rms(plain[seen], wanted[seen]) > 0.1
    from mathutils import Matrix

    matrix = part("light").read_turn(sunny.world) @ axis_angle((0, 0, 1), 1.0).T
    sunny.world.node_tree.nodes["Mapping"].inputs["Rotation"].default_value = Matrix(matrix).to_euler("XYZ")
    blender.context.view_layer.update()
    other = eevee(stage, sunny, tmp_path / "turned.exr", samples=12)
    assert relative_rms(turned[seen], other[seen]) < 0.03 and relative_rms(other[seen], wanted[seen]) > 0.1


def test_the_shadows_of_a_window_are_as_soft_as_eevees(blender, stage, sunny, browser, tmp_path):
    """A wide spot of the sky, of fourteen degrees to all sides."""
    sky = np.full((128, 256, 3), 0.2, dtype=np.float32)
    elevation, azimuth = (
        np.pi * ((np.arange(128) + 0.5) / 128 - 0.5)[:, None],
        np.pi * (1.0 - (np.arange(256) + 0.5) / 128),
    )
    flat = np.cos(elevation)
    towards = np.stack(np.broadcast_arrays(flat * np.cos(azimuth), flat * np.sin(azimuth), np.sin(elevation)), axis=-1)
    sky[towards @ stage.SUN > np.cos(np.radians(14.0))] = 6.0
    stage.environment(stage.picture("Window", sky))
    blender.ops.prt.project_light(lamps="AUTO")
    [lamp] = [ob for ob in sunny.objects if ob.type == "LIGHT"]
    assert np.degrees(lamp.data.angle) == pytest.approx(28.0, rel=0.05)
    path = tmp_path / "window.html"
    blender.ops.prt.export_web_page(filepath=str(path), still=False)
    [shown] = browser.open(path, [FRAME], WIDTH, HEIGHT)
    shown, wanted = shown.reshape(HEIGHT, WIDTH, 4), eevee(stage, sunny, tmp_path / "eevee.exr", samples=32)
    seen = (wanted[..., 3] > 0.999) & (shown[..., 3] > 0.999)
    assert seen.mean() > 0.3 and relative_rms(shown[seen], wanted[seen]) < 0.04


def test_the_page_names_suns_and_what_is_theirs(blender, part, stage, sunny, page, tmp_path):
    """Of the scene's own sky and of others, if lamps are wanted; then all that is baked carries its direct part."""
    assert ReadPage(page).description["suns"] == {"most": 4, "enough": 0.03}
    [sky] = ReadPage(page).description["skies"]
    np.testing.assert_allclose(sky["lamps"], part("light").read_lamps(sunny.world), rtol=1e-6)
    [sun] = sky["suns"]
    assert np.dot(sun["direction"], stage.SUN) > 0.9999 and sun["radius"] == pytest.approx(np.radians(3.0), rel=0.1)
    other = tmp_path / "other.html"
    blender.ops.prt.export_web_page(filepath=str(other), still=False, skies={"forest"})
    document, skies = ReadPage(other).document, ReadPage(other).description["skies"]
    assert skies[1]["suns"] and np.any(skies[1]["lamps"])
    assert all(mesh["primitives"][0]["extras"]["prt_relight"]["direct"] for mesh in document["meshes"])
    sunny.prt.lamps = "NONE"
    blender.ops.prt.project_light()
    blender.ops.prt.export_web_page(filepath=str(other), still=False, skies={"forest"})
    document, skies = ReadPage(other).document, ReadPage(other).description["skies"]
    assert not any(sky["suns"] or np.any(sky["lamps"]) for sky in skies)
    assert ReadPage(other).description["suns"] == {"most": 0, "enough": 0.0}
    assert not any(mesh["primitives"][0]["extras"]["prt_relight"]["direct"] for mesh in document["meshes"])


def test_rounding_is_small_and_not_seen(blender, part, sunny, page, browser, tmp_path, monkeypatch):
    """With all that suns need transport takes 16 bytes a vertex, gzipped, and what is shown is half a percent off at most: beside
    numbers of eight times the steps, under the sun as without suns."""
    packing = part("packing")
    read = ReadPage(page)
    primitives = [mesh["primitives"][0] for mesh in read.document["meshes"]]
    size = sum(len(gzip.compress(read.view(each["extras"]["prt_relight"]["view"]))) for each in primitives)
    vertices = sum(read.document["accessors"][each["attributes"]["POSITION"]]["count"] for each in primitives)
    monkeypatch.setattr(packing, "STEPS", 8 * packing.STEPS)
    finer = tmp_path / "finer.html"
    blender.ops.prt.export_web_page(filepath=str(finer), still=False)
    steps = [FRAME, "prt.skies[0].suns.length = 0", FRAME]
    shown, exact = (browser.open(path, steps, WIDTH, HEIGHT) for path in (page, finer))
    errors = [relative_rms(shown[k].reshape(-1, 4), exact[k].reshape(-1, 4)) for k in (0, 2)]
    print(f"{size / vertices:.1f} bytes a vertex; errors of {errors[0]:.2%} with the sun and {errors[1]:.2%} without")
    assert size <= 16 * vertices and 0.0 < max(errors) < 0.005


def test_a_dropped_sky_gets_its_suns(stage, page, browser):
    """As Blender would take them out; it casts another shadow than before, and its light holds them."""
    from prt_addon.core.sky.find_lamps import find_lamps

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


def test_a_dropped_sky_gets_as_few_suns_as_in_blender(stage, page, browser):
    """*Automatic* takes one where all else is dust, two where two shine, and no more."""
    from prt_addon.core.sky.find_lamps import ENOUGH, find_lamps

    sky, steps, wanted = stage.sunny_sky(256), [], []
    dusty, double = sky.copy(), np.maximum(sky, sky[:, ::-1])
    for row, column in ((20, 30), (40, 90), (30, 200)):
        dusty[row, column] = 40.0
    for name, each in (("Dusty", dusty), ("Double", double)):
        wanted.append(len(find_lamps(each, 4, ENOUGH).lamps))
        steps += [{"drop": {"name": f"{name}.hdr", "data": hdr(each)}}, "prt.skies[prt.sky].suns.length"]
    assert len(find_lamps(dusty, 4).lamps) == 4 and wanted == [1, 2]
    assert browser.open(page, steps, WIDTH, HEIGHT)[1::2] == wanted


def cut_out(blender, stage, name, alphas, cut):
    """A material whose alpha is one of two in the squares of a picture; cut where it is less than a half, or a veil."""
    squares = np.indices((4, 4)).sum(axis=0) % 2
    image = blender.data.images.new(name, 4, 4, alpha=True)
    rgba = np.full((4, 4, 4), 0.5, dtype=np.float32)
    rgba[..., 3] = np.where(squares, *alphas)
    image.pixels.foreach_set(rgba.ravel())
    image.pack()
    material = matte(blender, stage, name, (0.5, 0.5, 0.5))
    tree = material.node_tree
    texture, shader = tree.nodes.new("ShaderNodeTexImage"), tree.nodes["Principled BSDF"]
    texture.image, texture.interpolation, alpha = image, "Closest", texture.outputs["Alpha"]
    if cut:
        limit = tree.nodes.new("ShaderNodeMath")
        limit.operation, limit.inputs[1].default_value = "GREATER_THAN", 0.5
        tree.links.new(alpha, limit.inputs[0])
        alpha = limit.outputs["Value"]
    tree.links.new(alpha, shader.inputs["Alpha"])
    return material


def test_what_is_cut_out_shadows_as_in_eevee_and_veils_by_their_alpha(blender, scene, stage, browser, tmp_path):
    """Three cards above the camera, whose shadows it sees: cut-out squares, squares of two opacities, and half a veil. All take as much
    light as their alpha says; EEVEE's own veils take more (three quarters in place of half), as its rays meet them more than once."""
    stage.environment(stage.picture("Sunny", stage.sunny_sky()), strength=0.5)
    stage.object_of("Floor", stage.grid(60, 3.5), matte(blender, stage, "Ground", (0.6, 0.7, 0.6)))
    veil = matte(blender, stage, "Veil", (0.5, 0.5, 0.5))
    veil.node_tree.nodes["Principled BSDF"].inputs["Alpha"].default_value = 0.5
    squares = [
        cut_out(blender, stage, name, *how) for name, *how in (("Cut", (1, 0), True), ("Veils", (0.9, 0.25), False))
    ]
    towards = stage.SUN * 2.6 / stage.SUN[2]
    for x, material in zip((-2.0, 0.0, 2.0), (*squares, veil), strict=True):
        card = stage.object_of(material.name, stage.grid(8, 0.75), material, (x + towards[0], towards[1], towards[2]))
        lay_out(card.data, (0, 1), 0.75)
    look_from(blender, scene, (0.0, 0.0, 2.4), (0.0, 0.0, 0.0))
    scene.camera.data.lens = 15.0
    blender.ops.prt.bake(mode="SHADOWED", samples=64, lamps="ONE")
    path = tmp_path / "page.html"
    blender.ops.prt.export_web_page(filepath=str(path), still=False)
    modes = {material["name"]: material.get("alphaMode", "OPAQUE") for material in ReadPage(path).document["materials"]}
    assert [modes[name] for name in ("Ground", "Cut", "Veils", "Veil")] == ["OPAQUE", "MASK", "BLEND", "BLEND"]
    dimmed = "(() => { prt.skies[0].suns[0].irradiance = [0, 0, 0]; prt.turn = 1e-9; })()"
    answers = browser.open(path, [FRAME, dimmed, FRAME], WIDTH, HEIGHT)
    shown, without = (answers[k].reshape(HEIGHT, WIDTH, 4) for k in (0, 2))
    assert (shown[..., 3] > 0.999).all()
    wanted, cut = eevee(stage, scene, tmp_path / "eevee.exr", samples=32), np.s_[:, : WIDTH // 3]
    assert relative_rms(shown[cut].reshape(-1, 4), wanted[cut].reshape(-1, 4)) < 0.03
    sun = shown[..., 1] - without[..., 1]
    taken = [np.sum(1.0 - third / sun.max()) for third in np.array_split(sun, 3, axis=1)]
    np.testing.assert_allclose(np.array(taken[1:]) / taken[0], [0.575 / 0.5, 0.5 / 0.5], rtol=0.04)


def test_normal_maps_bend_the_light_of_suns(blender, scene, stage, browser, tmp_path):
    """On a matte floor of waves; not that of the sky, which the bake holds for the floor as it is."""
    stage.environment(stage.picture("Sunny", stage.sunny_sky()), strength=0.5)
    material = matte(blender, stage, "Waves", (0.6, 0.7, 0.6))
    dent(blender, material)
    floor = stage.object_of("Floor", stage.grid(60, 3.0), material)
    lay_out(floor.data, (0, 1), 3.0)
    look_from(blender, scene, (4.0, -7.0, 4.2), (1.05, 0.0, 0.52))
    blender.ops.prt.bake(mode="SHADOWED", samples=64, lamps="ONE")
    path = tmp_path / "page.html"
    blender.ops.prt.export_web_page(filepath=str(path), still=False)
    shown = browser.open(path, [FRAME], WIDTH, HEIGHT)[0].reshape(-1, 4)
    wanted = eevee(stage, scene, tmp_path / "eevee.exr", samples=12).reshape(-1, 4)
    seen = (wanted[:, 3] > 0.999) & (shown[:, 3] > 0.999)
    assert seen.mean() > 0.2 and wanted[seen, 0].std() > 0.1 * wanted[seen, 0].mean()
    assert relative_rms(shown[seen], wanted[seen]) < 0.03
