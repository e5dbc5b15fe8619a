# SPDX-License-Identifier: GPL-3.0-or-later
"""Sheets that pages and the three.js plugin show from behind have the light of their backs, as in EEVEE's frame of the same view."""

import gzip

import numpy as np
import pytest

from tests.core.references import axis_angle
from tests.web.conftest import dent, lay_out, look_from, matte
from tests.web.pages import ReadPage
from tests.web.views import HEIGHT, WIDTH, eevee, relative_rms

pytestmark = pytest.mark.once

FRAME = f"prt.radiance({WIDTH}, {HEIGHT})"
COARSE = FRAME.replace(")", ", true)")


def leaf(stage, name, material, place, turn):
    """A bent sheet of 1,700 vertices, whose transport is on points."""
    sheet = stage.object_of(name, stage.grid(40, 0.9), material, place)
    for vertex in sheet.data.vertices:
        vertex.co.z = 0.5 * vertex.co.x**2
    sheet.data.update()
    sheet.rotation_euler = turn
    return sheet


def furnish(blender, stage, gloss=False, bent=False):
    """Three leaves that are seen from behind, one of them in its own axes, one that is creased, and a ball before them, on a floor."""
    colours = {"Green": (0.3, 0.7, 0.2), "Red": (0.8, 0.3, 0.2), "Blue": (0.3, 0.4, 0.8), "Grey": (0.6, 0.6, 0.6)}
    materials = {name: matte(blender, stage, name, colour) for name, colour in colours.items()}
    if gloss:
        for material in (materials[name] for name in ("Green", "Red", "Blue")):
            inputs = material.node_tree.nodes["Principled BSDF"].inputs
            inputs["Specular IOR Level"].default_value, inputs["Roughness"].default_value = 0.5, 0.4
    first = leaf(stage, "First", materials["Green"], (-2.1, 0.0, 1.4), (1.9, 0.0, 0.5))
    own = leaf(stage, "Second", materials["Red"], (0.0, 0.0, 1.4), (1.5, 0.5, 0.0))
    own.prt.space = "OBJECT"
    third = leaf(stage, "Third", materials["Blue"], (2.1, 0.0, 1.4), (1.7, 0.2, -0.4))
    stage.crease(third.data)
    for ob, name in ((first, "Green"), (own, "Red")) if bent else ():
        dent(blender, materials[name])
        lay_out(ob.data, (0, 1), 0.9)
    stage.object_of("Ball", stage.icosphere(4, 0.3), materials["Grey"], (0.9, -1.5, 0.3))
    stage.object_of("Floor", stage.grid(40, 4.0), materials["Grey"])
    for sheet in (blender.data.objects[name] for name in ("First", "Second", "Third")):
        sheet.rotation_euler.x += np.pi  # backs to the camera
    look_from(blender, blender.context.scene, (0.0, -7.5, 2.4), (1.42, 0.0, 0.0))


@pytest.fixture(params=["matte", "sunny", "glossy", "bent"])
def leaves(request, blender, scene, stage):
    """These under a soft sky, under a sun that is taken out of it, glossy under a photographic one, and with pictures
    that bend their normals; the sun stands behind them."""
    kind = request.param
    if kind == "glossy":
        sky = blender.data.images.load(str(stage.headless.studio_hdri("forest")))
    else:
        sky = stage.picture("Sky", stage.sunny_sky() if kind == "sunny" else stage.six_coloured_sky(64))
    _, mapping = stage.environment(sky, strength=0.5)
    mapping.inputs["Rotation"].default_value = (0.2, -0.1, -2.0)
    furnish(blender, stage, gloss=kind == "glossy", bent=kind in ("bent", "sunny"))
    blender.ops.prt.bake(mode="INTERREFLECTED", samples=64, lamps="ONE" if kind == "sunny" else "NONE")
    return scene


@pytest.fixture
def page(blender, leaves, tmp_path):
    path = tmp_path / "page.html"
    blender.ops.prt.export_web_page(filepath=str(path), still=False)
    return path


def primitives_of(read):
    return [primitive for mesh in read.document["meshes"] for primitive in mesh["primitives"]]


def test_backs_are_eevees(blender, stage, leaves, page, browser, tmp_path):
    """Within 3 %, and nearly so in the movements of slow machines; the light of the fronts is not."""
    shown, moving = (pixels.reshape(HEIGHT, WIDTH, 4) for pixels in browser.open(page, [FRAME, COARSE], WIDTH, HEIGHT))
    wanted = eevee(stage, leaves, tmp_path / "eevee.exr", samples=12)
    for name in ("First", "Second", "Third"):
        blender.data.objects[name].prt.sides = "FRONTS"
    fronts = tmp_path / "fronts.html"
    blender.ops.prt.bake(mode="INTERREFLECTED", samples=64, lamps=leaves.prt.lamps)
    blender.ops.prt.export_web_page(filepath=str(fronts), still=False)
    before = browser.open(fronts, [FRAME], WIDTH, HEIGHT)[0].reshape(HEIGHT, WIDTH, 4)
    seen = (wanted[..., 3] > 0.999) & (shown[..., 3] > 0.999)
    above = seen & (moving[..., 3] > 0.999) & (np.arange(HEIGHT)[:, None] > 0.45 * HEIGHT)  # leaves before nothing
    masks = ((shown, seen), (moving, above), (before, above))
    errors = [relative_rms(each[where], wanted[where]) for each, where in masks]
    print("fine {:.2%}, coarse {:.2%}, with fronts {:.2%}".format(*errors))
    assert above.mean() > 0.2 and errors[0] < 0.03 and errors[1] < 0.03 and errors[2] > 0.1


@pytest.mark.parametrize("leaves", ["matte"], indirect=True)
def test_a_turn_of_the_sky_lights_both_sides(blender, stage, leaves, page, browser, tmp_path):
    """As Blender's own turn does; light without shadows has two sides, too."""
    from mathutils import Matrix

    mapping = next(node for node in leaves.world.node_tree.nodes if node.type == "MAPPING")
    matrix = np.array([list(leaves.world[f"prt_turn_{axis}"])[:3] for axis in "xyz"]).T @ axis_angle((0, 0, 1), 2.0).T
    mapping.inputs["Rotation"].default_value = Matrix(matrix).to_euler("XYZ")
    blender.context.view_layer.update()
    wanted = eevee(stage, leaves, tmp_path / "turned.exr", samples=12)
    first, _, shown = browser.open(page, [FRAME, "prt.turn = 2.0", FRAME], WIDTH, HEIGHT)
    first, shown = (pixels.reshape(HEIGHT, WIDTH, 4) for pixels in (first, shown))
    seen = (wanted[..., 3] > 0.999) & (shown[..., 3] > 0.999)
    assert relative_rms(shown[seen], wanted[seen]) < 0.03 < 0.1 < relative_rms(first[seen], wanted[seen])


@pytest.mark.parametrize("leaves", ["matte", "glossy"], indirect=True)
def test_backs_take_few_bytes(blender, part, page, browser, tmp_path, monkeypatch):
    """Those that may be seen come with five bytes a vertex at most, gzipped, half a percent off; the ball has none."""
    read = ReadPage(page)
    for mesh in read.document["meshes"]:
        [primitive] = mesh["primitives"]
        packed = primitive["extras"]["prt_relight"]
        assert ("backs" in packed) == (mesh["name"] != "Sphere")
        assert not any(name.startswith("_PRT") for name in primitive["attributes"])
    primitives = [mesh["primitives"][0] for mesh in read.document["meshes"] if mesh["name"] != "Sphere"]
    views = [primitive["extras"]["prt_relight"]["backs"]["view"] for primitive in primitives]
    size = sum(len(gzip.compress(read.view(view))) for view in views)
    vertices = sum(len(read.backs(primitive)) for primitive in primitives)
    packing, finer = part("packing"), tmp_path / "finer.html"
    monkeypatch.setattr(packing, "STEPS", 8 * packing.STEPS)
    blender.ops.prt.export_web_page(filepath=str(finer), still=False)
    shown, exact = (browser.open(path, [FRAME], WIDTH, HEIGHT)[0].reshape(-1, 4) for path in (page, finer))
    error = relative_rms(shown, exact)
    print(f"{size / vertices:.1f} bytes a vertex, {error:.2%} off")
    assert size < 5 * vertices and 0.0 < error < 0.005


def test_what_is_culled_has_no_backs(blender, stage, scene, part, tmp_path):
    """A mesh has backs where one of its materials shows them: the page leaves those of the other out, and what remains is as stored."""
    stage.environment(stage.picture("Six", stage.six_coloured_sky(64)))
    seen, culled = (matte(blender, stage, name, (0.8, 0.8, 0.8)) for name in ("Seen", "Culled"))
    culled.use_backface_culling = True
    sheet = stage.object_of("Sheet", stage.grid(4), seen)
    sheet.data.materials.append(culled)
    sheet.data.polygons.foreach_set("material_index", [0] * 8 + [1] * 8)
    blender.ops.prt.bake(mode="INTERREFLECTED", samples=32)
    path = tmp_path / "culled.html"
    blender.ops.prt.export_web_page(filepath=str(path), still=False)
    read = ReadPage(path)
    names = [material["name"] for material in read.document["materials"]]
    found = {names[each["material"]]: read.backs(each) for each in primitives_of(read)}
    stored = part("layers").read_backs(sheet.data)
    assert found["Culled"] is None
    nearest = np.abs(found["Seen"][:, None, :, :3] - stored).max(axis=(2, 3)).min(axis=1)
    assert len(found["Seen"]) == 15 and nearest.max() < 0.01 * np.abs(stored).max()
