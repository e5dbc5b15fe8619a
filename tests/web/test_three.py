# SPDX-License-Identifier: GPL-3.0-or-later
"""The three.js plugin: packed, installed and run in a real browser, on what File > Export > glTF writes."""

import base64
import json
import shutil
import subprocess

import numpy as np
import pytest

from tests.web.node import WEB, npm
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
    esbuild = WEB / "node_modules" / ".bin" / "esbuild"
    command = [esbuild, "main.js", "--bundle", "--format=iife", "--global-name=example", "--preserve-symlinks"]
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
