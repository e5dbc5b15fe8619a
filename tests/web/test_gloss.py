# SPDX-License-Identifier: GPL-3.0-or-later
"""What the page shows of gloss, beside EEVEE's frame of the same view."""

import gzip

import numpy as np
import pytest

from prt_addon.core.exchange.packing import is_glossy, rounded, tints_of, to_bytes
from tests.web.conftest import matte
from tests.web.pages import ReadPage
from tests.web.views import HEIGHT, WIDTH, eevee, relative_rms

pytestmark = pytest.mark.once


@pytest.fixture
def page(blender, glossy_scene, tmp_path):
    path = tmp_path / "page.html"
    blender.ops.prt.export_web_page(filepath=str(path), still=False)
    return path


def test_gloss_is_nearly_eevees(stage, glossy_scene, page, browser, tmp_path):
    """Metal on the left, polish in the middle, pictures of dents and of roughness on the right; and the floor."""
    shown = browser.open(page, [f"prt.radiance({WIDTH}, {HEIGHT})"])[0].reshape(HEIGHT, WIDTH, 4)
    wanted = eevee(stage, glossy_scene, tmp_path / "eevee.exr")
    seen = (wanted[..., 3] > 0.999) & (shown[..., 3] > 0.999)
    third = np.arange(WIDTH) * 3 // WIDTH
    metal, polished, dented = (
        relative_rms(shown[part], wanted[part]) for part in (seen & (third == k) for k in range(3))
    )
    assert seen.mean() > 0.3
    assert metal < 0.08 and polished < 0.03 and dented < 0.03


def test_coarse_movements_are_nearly_the_same(glossy_scene, page, browser):
    """Of 34,000 vertices as of 6,500, with gloss reckoned at vertices; under another turn of the sky, too."""
    frames = [f"prt.radiance({WIDTH}, {HEIGHT}, {coarse})" for coarse in ("false", "true")]
    fine, coarse, _, turned, coarse_turned = browser.open(page, [*frames, "prt.turn = 1.0", *frames])
    for one, other in ((fine, coarse), (turned, coarse_turned)):
        one, other = (pixels.reshape(HEIGHT, WIDTH, 4) for pixels in (one, other))
        seen = (one[..., 3] > 0.999) & (other[..., 3] > 0.999)
        assert seen.mean() > 0.3 and 0.001 < relative_rms(other[seen], one[seen]) < 0.06
    assert relative_rms(turned.reshape(-1, 4), fine.reshape(-1, 4)) > 0.1


def test_what_the_bake_hides_is_not_mirrored(blender, scene, stage, browser, tmp_path):
    """Under a lid a metal floor shows no sky: without shadows it shows all of it."""
    stage.environment(stage.picture("White", np.ones((16, 32, 3), dtype=np.float32)), mapping=False)
    metal = stage.object_of("Floor", stage.grid(20, 1.0), stage.diffuse())
    metal.data.materials[0] = matte(blender, stage, "Metal", (1.0, 1.0, 1.0))
    metal.data.materials[0].node_tree.nodes["Principled BSDF"].inputs["Metallic"].default_value = 1.0
    stage.object_of("Lid", stage.grid(4, 20.0), stage.diffuse(colour=(0, 0, 0)), (0, 0, 0.5))
    camera = blender.data.objects.new("Camera", blender.data.cameras.new("Camera"))
    camera.location, camera.rotation_euler = (0.0, -1.2, 0.4), (1.25, 0.0, 0.0)
    scene.collection.objects.link(camera)
    scene.camera = camera
    blender.ops.prt.bake(mode="SHADOWED", samples=64)
    path = tmp_path / "lid.html"
    blender.ops.prt.export_web_page(filepath=str(path), still=False)
    frame = f"prt.radiance({WIDTH}, {HEIGHT})"
    baked, _, plain = browser.open(path, [frame, "prt.shading = 'unshadowed'", frame])
    middle = (HEIGHT * 3 // 8 * WIDTH + WIDTH // 2) * 4
    assert baked[middle] < 0.1 and plain[middle] > 0.9


def test_what_is_glossy_alone_carries_its_direct_part(page):
    """In at most four bytes a vertex beyond the sum alone, gzipped, and 16 in all."""
    read = ReadPage(page)
    primitives = [primitive for mesh in read.document["meshes"] for primitive in mesh["primitives"]]
    extras = [primitive["extras"]["prt_relight"] for primitive in primitives]
    assert all(each["direct"] for each in extras)
    sizes = sum(len(gzip.compress(read.view(each["view"]))) for each in extras)
    sums = [rounded(read.transport(primitive))[0] for primitive in primitives]
    alone = sum(len(gzip.compress(to_bytes(numbers, tints_of(numbers)))) for numbers in sums)
    vertices = sum(read.document["accessors"][primitive["attributes"]["POSITION"]]["count"] for primitive in primitives)
    print(f"{sizes / vertices:.1f} bytes a vertex, {(sizes - alone) / vertices:.1f} of them the direct part's")
    assert sizes < alone + 4 * vertices and sizes < 16 * vertices
    for primitive in primitives:
        read.document["materials"][primitive["material"]]["extensions"] = {
            "KHR_materials_specular": {"specularFactor": 0}
        }
        read.document["materials"][primitive["material"]]["pbrMetallicRoughness"]["metallicFactor"] = 0
        assert not is_glossy(read.document["materials"][primitive["material"]])
