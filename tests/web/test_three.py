# SPDX-License-Identifier: GPL-3.0-or-later
"""The three.js plugin: packed, installed and run in a real browser, on what File > Export > glTF writes."""

import base64
import json
import shutil
import subprocess

import numpy as np
import pytest

from prt_addon.core.layout import BACKS
from prt_addon.core.sky.projection import project_equirect
from tests.core.references import axis_angle
from tests.web.node import WEB, npm
from tests.web.test_backs import furnish
from tests.web.views import HEIGHT, WIDTH, eevee, relative_rms

pytestmark = pytest.mark.once

PACKAGE = WEB / "packages" / "three"


@pytest.fixture(scope="module")
def example(browser, tmp_path_factory):
    """The example's code, bundled with the plugin as `npm pack` packs it."""
    folder = tmp_path_factory.mktemp("three")
    done = npm("pack", "--workspace", "@prt-relight/three", "--pack-destination", str(folder))
    assert done.returncode == 0, done.stderr
    [packed] = folder.glob("*.tgz")
    shutil.unpack_archive(packed, folder, filter="data")
    modules = folder / "node_modules"
    (modules / "@prt-relight").mkdir(parents=True)
    (folder / "package").rename(modules / "@prt-relight" / "three")
    (modules / "three").symlink_to(WEB / "node_modules" / "three")
    shutil.copy(PACKAGE / "example" / "main.js", folder / "main.js")
    (folder / "entry.js").write_text('export * from "./main.js"; export * as three from "three";')
    esbuild = WEB / "node_modules" / ".bin" / "esbuild"
    command = [str(esbuild), "entry.js", "--bundle", "--format=iife", "--global-name=example", "--preserve-symlinks"]
    bundled = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    assert bundled.returncode == 0, bundled.stderr
    return bundled.stdout


def page_of(example, glb, path):
    """A page that shows a file by the example's code."""
    data = base64.b64encode(glb.read_bytes()).decode()
    path.write_text(
        f"<!doctype html><meta charset=utf-8><canvas width={WIDTH} height={HEIGHT}></canvas><script>{example}</script>"
        f"<script>const bytes = Uint8Array.from(atob({json.dumps(data)}), (letter) => letter.charCodeAt(0));"
        "window.prt = example.show(document.querySelector('canvas'), bytes.buffer);</script>"
    )
    return path


def test_the_package_is_small_and_whole(example, browser):
    """Its module has no three.js in it, its types know no other package than that."""
    module, types = PACKAGE / "dist" / "index.js", PACKAGE / "dist" / "index.d.ts"
    assert module.stat().st_size < 40_000 and 'from "three"' in module.read_text()
    assert types.is_file() and "@prt-relight/core" not in (PACKAGE / "dist" / "relight.d.ts").read_text()
    assert json.loads((PACKAGE / "package.json").read_text())["sideEffects"] is False


def test_pixels_are_eevees(blender, stage, scene_of_all, example, browser, tmp_path):
    """Textures, axes of an object's own, the sky as it is turned and scaled; then turned further, as Blender turns it."""
    glb = tmp_path / "scene.glb"
    blender.ops.export_scene.gltf(filepath=str(glb), export_cameras=True)
    frame = f"prt.radiance({WIDTH}, {HEIGHT})"
    steps = ["prt.prt.count", frame, "prt.prt.rotation = 1.0", frame]
    steps += ["prt.prt.setSky([[2, 0, 0], ...Array(8).fill([0, 0, 0])])", frame]
    count, first, _, second, _, red = browser.open(page_of(example, glb, tmp_path / "three.html"), steps, WIDTH, HEIGHT)
    first, second, red = (pixels.reshape(HEIGHT, WIDTH, 4) for pixels in (first, second, red))
    assert count == 3
    page = tmp_path / "page.html"
    blender.ops.prt.export_web_page(filepath=str(page), still=False)
    turned = browser.open(page, ["prt.turn = 1.0", frame])[1].reshape(HEIGHT, WIDTH, 4)
    wanted = eevee(stage, scene_of_all, tmp_path / "eevee.exr")
    seen = (wanted[..., 3] > 0.999) & (first[..., 3] > 0.999)
    assert seen.mean() > 0.3
    assert relative_rms(first[seen], wanted[seen]) < 0.03
    assert relative_rms(second[seen], wanted[seen]) > 0.1
    both = seen & (turned[..., 3] > 0.999)
    assert relative_rms(second[both], turned[both]) < 0.03  # tests of the page compare it with Blender's turn
    assert red[seen][:, 0].max() > 0.1 and np.abs(red[seen][:, 1:3]).max() == 0.0


def test_sixteen_bits_and_z_up_show_the_same(blender, scene, scene_of_all, example, browser, tmp_path):
    """A file of half the bytes, and one with Blender's axes, seen from the camera of each."""
    frames = []
    for name, precision, yup in (("float", "FLOAT", True), ("short", "SHORT", True), ("z_up", "FLOAT", False)):
        glb = tmp_path / f"{name}.glb"
        scene.prt.gltf.precision = precision
        blender.ops.export_scene.gltf(filepath=str(glb), export_cameras=True, export_yup=yup)
        page = page_of(example, glb, tmp_path / f"{name}.html")
        count, pixels = browser.open(page, ["prt.prt.count", f"prt.radiance({WIDTH}, {HEIGHT})"], WIDTH, HEIGHT)
        assert count == 3
        frames.append(pixels.reshape(HEIGHT, WIDTH, 4))
    first, short, z_up = frames
    seen = first[..., 3] > 0.999
    assert seen.mean() > 0.3 and 0.0 < relative_rms(short[seen], first[seen]) < 2e-4
    assert relative_rms(z_up[seen], first[seen]) < 0.01  # edges fall on other pixels


@pytest.mark.parametrize("precision", ["FLOAT", "SHORT"])
def test_backs_are_eevees(blender, scene, stage, example, browser, tmp_path, precision):
    """Of leaves that are seen from behind, one of them in its own axes; with the light of their fronts they are not."""
    _, mapping = stage.environment(stage.picture("Six", stage.six_coloured_sky(64)), strength=0.5)
    mapping.inputs["Rotation"].default_value = (0.2, -0.1, -2.0)
    furnish(blender, stage)
    blender.ops.prt.bake(mode="INTERREFLECTED", samples=64, lamps="NONE")
    scene.prt.gltf.precision = precision
    wanted, frames = eevee(stage, scene, tmp_path / "eevee.exr"), []
    for sides in ("both", "fronts"):
        glb = tmp_path / f"{sides}.glb"
        blender.ops.export_scene.gltf(filepath=str(glb), export_cameras=True)
        page = page_of(example, glb, tmp_path / f"{sides}.html")
        frames += browser.open(page, [f"prt.radiance({WIDTH}, {HEIGHT})"], WIDTH, HEIGHT)
        for mesh in (ob.data for ob in scene.objects if ob.type == "MESH"):
            for name in (name for name in BACKS if name in mesh.attributes):
                mesh.attributes.remove(mesh.attributes[name])
    both, fronts = (pixels.reshape(HEIGHT, WIDTH, 4) for pixels in frames)
    seen = (wanted[..., 3] > 0.999) & (both[..., 3] > 0.999)
    errors = [relative_rms(each[seen], wanted[seen]) for each in (both, fronts)]
    print("{:.2%}, with fronts {:.2%}".format(*errors))
    assert seen.mean() > 0.3 and errors[0] < 0.03 and errors[1] > 0.2


SIX_COLOURED = """(() => {
  const { DataTexture, EquirectangularReflectionMapping, FloatType, LinearFilter, RGBAFormat } = example.three;
  const colours = [[0, 1, 3, 0, 0], [0, -1, 0, 2, 0], [1, 1, 0, 0, 4], [1, -1, 2, 2, 0], [2, 1, 0, 3, 3], [2, -1, 1, 0, 2]];
  const data = new Float32Array(4 * 256 * 128);
  for (let row = 0, at = 0; row < 128; row++) for (let column = 0; column < 256; column++, at += 4) {
    const azimuth = 2 * Math.PI * (0.5 - (column + 0.5) / 256), elevation = Math.PI * ((row + 0.5) / 128 - 0.5);
    const w = [Math.cos(elevation) * Math.cos(azimuth), Math.cos(elevation) * Math.sin(azimuth), Math.sin(elevation)];
    for (const [axis, sign, ...rgb] of colours) rgb.forEach((value, c) => (data[at + c] += value * ((1 + sign * w[axis]) / 2) ** 2));
    data[at + 3] = 1;
  }
  const sky = new DataTexture(data, 256, 128, RGBAFormat, FloatType, EquirectangularReflectionMapping);
  sky.minFilter = sky.magFilter = LinearFilter;
  sky.needsUpdate = true;
  window.sky = sky;
})()"""
"""The sky of `stage.six_coloured_sky` as a texture of three.js, whose lowest row is the first."""


def rays(scene):
    """(H, W, 3) unit vectors that the camera's pixels look along."""
    camera = scene.camera
    frame = np.array(camera.data.view_frame(scene=scene))
    across, up = np.abs(frame[:, :2]).max(axis=0)
    x, y = np.meshgrid((np.arange(WIDTH) + 0.5) / WIDTH * 2 - 1, (np.arange(HEIGHT) + 0.5) / HEIGHT * 2 - 1)
    w = np.stack([across * x, up * y, np.full_like(x, frame[0, 2])], axis=-1) @ np.array(camera.matrix_world.to_3x3()).T
    return w / np.linalg.norm(w, axis=-1, keepdims=True)


def test_a_texture_lights_and_turns_with_the_background(blender, stage, scene_of_all, example, browser, tmp_path):
    """Background pixels are the texture's along their rays, turned and scaled; the light is that of the same coefficients."""
    glb = tmp_path / "scene.glb"
    blender.ops.export_scene.gltf(filepath=str(glb), export_cameras=True)
    coefficients = project_equirect(stage.six_coloured_sky(256), interpolated=True)
    frame, angle = f"prt.radiance({WIDTH}, {HEIGHT})", 0.8
    steps = [SIX_COLOURED, "prt.prt.setSky(sky)", f"prt.prt.rotation = {angle}", "prt.prt.strength = 0.5", frame]
    steps += ["prt.scene.background = sky", "(() => prt.prt.showIn(prt.scene))()", frame]
    steps += [f"prt.prt.setSky({json.dumps(coefficients.tolist())})", frame]
    answers = browser.open(page_of(example, glb, tmp_path / "three.html"), steps, WIDTH, HEIGHT)
    alone, behind, by_coefficients = (answers[k].reshape(HEIGHT, WIDTH, 4) for k in (4, 7, 9))
    mesh = alone[..., 3] > 0.999
    assert 0.3 < mesh.mean() < 0.95
    assert relative_rms(by_coefficients[mesh], alone[mesh]) < 1e-3
    np.testing.assert_allclose(behind[mesh], alone[mesh], atol=1e-5)
    w = rays(scene_of_all) @ axis_angle((0, 0, 1), angle)  # Rz(-angle) w
    sky = alone[..., 3] == 0.0
    assert relative_rms(behind[sky], 0.5 * stage.six_colours(w[sky])) < 0.02


def test_a_texture_of_bytes_is_refused(blender, scene_of_all, example, browser, tmp_path):
    """In a sentence: light is brighter than white."""
    glb = tmp_path / "scene.glb"
    blender.ops.export_scene.gltf(filepath=str(glb), export_cameras=True)
    bytes_of = "new example.three.DataTexture(new Uint8Array(8), 2, 1)"
    tried = f"(() => {{ try {{ prt.prt.setSky({bytes_of}); }} catch (error) {{ return error.message; }} }})()"
    [message] = browser.open(page_of(example, glb, tmp_path / "three.html"), [tried], WIDTH, HEIGHT)
    assert message == "A sky is a texture of floats or half floats."


def test_a_file_without_transport_is_drawn_as_ever(blender, stage, scene, example, browser, tmp_path):
    """Nothing is taken over, and nothing breaks when the sky is turned."""
    stage.object_of("Cube", stage.cube(), stage.diffuse())
    camera = blender.data.objects.new("Camera", blender.data.cameras.new("Camera"))
    camera.location = (0.0, 0.0, 8.0)
    scene.collection.objects.link(camera)
    glb = tmp_path / "plain.glb"
    blender.ops.export_scene.gltf(filepath=str(glb), export_cameras=True)
    steps = ["prt.prt.count", "prt.prt.rotation = 1.0", f"prt.radiance({WIDTH}, {HEIGHT})"]
    count, _, frame = browser.open(page_of(example, glb, tmp_path / "three.html"), steps, WIDTH, HEIGHT)
    assert count == 0 and 0.0 < (frame.reshape(-1, 4)[:, 3] > 0.999).mean() < 1.0
