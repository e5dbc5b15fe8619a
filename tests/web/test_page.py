# SPDX-License-Identifier: GPL-3.0-or-later
"""The exported page in a real browser: its pixels against NumPy and against EEVEE, hands on it, and what it says."""

import base64

import numpy as np
import pytest

from tests.core.references import axis_angle, order2
from tests.web.conftest import look_from, matte
from tests.web.pages import ReadPage
from tests.web.views import HEIGHT, WIDTH, eevee, relative_rms

pytestmark = pytest.mark.once

RESTED = {
    "await": "canvas.width === canvas.clientWidth && canvas.height === canvas.clientHeight && !document.getAnimations().length"
}


@pytest.fixture
def page(blender, scene_of_all, tmp_path):
    path = tmp_path / "page.html"
    blender.ops.prt.export_web_page(filepath=str(path), still=False, title="A scene")
    return path


def radiance_of(values):
    return values.reshape(HEIGHT, WIDTH, 4)


def test_pixels_are_eevees(stage, scene_of_all, page, browser, tmp_path):
    """As the world stood at the export, and with the sky turned in either: in linear light, within 3 %."""
    shown = browser.open(
        page,
        [
            f"prt.radiance({WIDTH}, {HEIGHT})",
            "prt.shading = 'unshadowed'",
            f"prt.radiance({WIDTH}, {HEIGHT})",
        ],
    )
    ours, plain = radiance_of(shown[0]), radiance_of(shown[2])
    wanted = eevee(stage, scene_of_all, tmp_path / "eevee.exr")
    seen = (wanted[..., 3] > 0.999) & (ours[..., 3] > 0.999)
    assert seen.mean() > 0.3 and ((wanted[..., 3] > 0.5) != (ours[..., 3] > 0.5)).mean() < 0.01
    assert relative_rms(ours[seen], wanted[seen]) < 0.03
    assert relative_rms(plain[seen], wanted[seen]) > 0.15


def test_a_turn_of_the_sky_is_blenders(blender, stage, scene_of_all, page, browser, tmp_path):
    """By 40 degrees in the page, and about the world's Z in Blender: the picture of the sky turns the same way."""
    angle = np.radians(40.0)
    shown = radiance_of(browser.open(page, [f"prt.turn = {angle}", f"prt.radiance({WIDTH}, {HEIGHT})"])[1])
    turn = axis_angle((0, 0, 1), angle)
    world = scene_of_all.world
    mapping = next(node for node in world.node_tree.nodes if node.type == "MAPPING")
    matrix = np.array([list(world[f"prt_turn_{axis}"])[:3] for axis in "xyz"]).T @ turn.T
    from mathutils import Matrix

    mapping.inputs["Rotation"].default_value = Matrix(matrix).to_euler("XYZ")
    blender.context.view_layer.update()
    found = np.array([list(world[f"prt_turn_{axis}"])[:3] for axis in "xyz"]).T
    np.testing.assert_allclose(found, matrix, atol=1e-5)
    wanted = eevee(stage, scene_of_all, tmp_path / "turned.exr")
    seen = (wanted[..., 3] > 0.999) & (shown[..., 3] > 0.999)
    assert relative_rms(shown[seen], wanted[seen]) < 0.03


def test_an_orthographic_cameras_pixels_are_eevees(blender, stage, scene_of_all, browser, tmp_path):
    """What it frames, too: its scale is the longer side of the picture."""
    camera = scene_of_all.camera.data
    camera.type, camera.ortho_scale = "ORTHO", 5.0
    path = tmp_path / "page.html"
    blender.ops.prt.export_web_page(filepath=str(path), still=False)
    ours = radiance_of(browser.open(path, [f"prt.radiance({WIDTH}, {HEIGHT})"])[0])
    wanted = eevee(stage, scene_of_all, tmp_path / "eevee.exr")
    seen = (wanted[..., 3] > 0.999) & (ours[..., 3] > 0.999)
    assert seen.mean() > 0.3 and ((wanted[..., 3] > 0.5) != (ours[..., 3] > 0.5)).mean() < 0.01
    assert relative_rms(ours[seen], wanted[seen]) < 0.03


def test_the_sky_turns_about_any_axis(page, browser):
    """By sliders, by dragging, by a finger and by keys: the light turns with what is seen behind."""
    slid = "(() => { const one = document.getElementById('tilt'); one.value = 30; one.dispatchEvent(new Event('input')); })()"
    angles, light = "[prt.turn, prt.tilt, prt.roll]", f"prt.radiance({WIDTH}, {HEIGHT})"
    dragged = {"drag": {"from": [100, 90], "to": [100, 140], "keys": ["Shift"]}}
    further, where = {"drag": {"from": [100, 90], "to": [150, 90]}}, "prt.orbit.position"
    sky_by_hand = "document.querySelectorAll('#hands input')[1].click()"
    first, _, slid_to, slid_light, _, dragged_to, place, _, _, by_hand, still = browser.open(
        page,
        [light, slid, angles, light, dragged, angles, where, sky_by_hand, further, angles, where],
        1000,
        600,
    )
    np.testing.assert_allclose(slid_to, [0.0, np.radians(30.0), 0.0], atol=1e-9)
    assert relative_rms(radiance_of(slid_light)[..., :3], radiance_of(first)[..., :3]) > 0.05
    assert np.abs(np.subtract(dragged_to, slid_to)).max() > 0.1
    assert by_hand[0] == pytest.approx(dragged_to[0] + 0.3) and by_hand[1:] == pytest.approx(dragged_to[1:])
    np.testing.assert_allclose(still, place)


def test_pixels_are_numpys(blender, scene, stage, browser, tmp_path):
    """A flat box without shadows: each side has one radiance, which its pixels have to 1e-5, the sky turned too."""
    stage.environment(stage.picture("Six", stage.six_coloured_sky(32)), strength=0.4, mapping=False)
    colour = (0.7, 0.3, 0.1)
    stage.object_of("Box", stage.cube(), stage.diffuse(colour=colour))
    blender.ops.prt.bake(mode="UNSHADOWED")
    path = tmp_path / "box.html"
    blender.ops.prt.export_web_page(filepath=str(path), still=False)
    page, angle = ReadPage(path), 0.7
    shown = browser.open(path, [f"prt.turn = {angle}", f"prt.radiance({WIDTH}, {HEIGHT})"])[1].reshape(-1, 4)
    [sky] = page.description["skies"]
    [primitive] = page.document["meshes"][0]["primitives"]
    directions = np.random.default_rng(1).normal(size=(200, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    seen_along = directions @ np.array(sky["turn"]).T @ axis_angle((0, 0, 1), angle)  # R Rz(-angle) w
    light = sky["strength"] * np.linalg.lstsq(order2(directions), order2(seen_along) @ sky["light"], rcond=None)[0]
    wanted = np.array(colour) * np.einsum("nic,ic->nc", page.transport(primitive), light)
    assert wanted.min() > 0.0
    pixels = shown[shown[:, 3] == 1.0][:, :3]
    nearest = np.abs(pixels[:, None] - wanted).max(axis=2)
    assert nearest.min(axis=1).max() < 1e-5
    sides = {tuple(np.round(wanted[index], 4)) for index in nearest.argmin(axis=1)}
    assert len(sides) == 3


def test_a_mesh_without_transport_is_lit_without_shadows(blender, scene, stage, browser, tmp_path):
    """Added after the bake, and below what would shadow it: the same with the bake and without, and as bright as its sides are lit."""
    stage.environment(stage.picture("White", np.ones((16, 32, 3), dtype=np.float32)), mapping=False)
    stage.object_of("Lid", stage.grid(4, 5.0), stage.diffuse(), (0, 0, 4))
    blender.ops.prt.bake(mode="SHADOWED", samples=16)
    stage.object_of("Box", stage.cube(), matte(blender, stage, "Grey", (0.5, 0.5, 0.5)))
    look_from(blender, scene, (0.0, -9.0, 0.5), (np.pi / 2, 0.0, 0.0))
    path = tmp_path / "page.html"
    blender.ops.prt.export_web_page(filepath=str(path), still=False)
    frame = f"prt.radiance({WIDTH}, {HEIGHT})"
    baked, _, plain = browser.open(path, [frame, "prt.shading = 'unshadowed'", frame])
    np.testing.assert_array_equal(baked, plain)
    seen = radiance_of(baked)[HEIGHT // 2, WIDTH // 2]
    np.testing.assert_allclose(seen, (0.5, 0.5, 0.5, 1.0), atol=1e-3)


def test_the_screen_shows_what_blender_shows(blender, stage, scene_of_all, browser, tmp_path):
    """Through the scene's own view transform, its look and exposure."""
    scene = scene_of_all
    scene.view_settings.view_transform, scene.view_settings.look = "AgX", "AgX - Medium High Contrast"
    scene.view_settings.exposure = 0.5
    path, picture = tmp_path / "page.html", tmp_path / "screen.png"
    blender.ops.prt.export_web_page(filepath=str(path), still=False)
    browser.open(
        path,
        ["document.getElementById('panel').style.display = 'none'", RESTED, {"picture": str(picture)}],
        WIDTH,
        HEIGHT,
    )
    scene.render.film_transparent = False
    scene.render.image_settings.file_format = "PNG"
    scene.render.engine = stage.headless.eevee_engine()
    scene.eevee.taa_render_samples = 16
    scene.render.filepath = str(tmp_path / "eevee.png")
    blender.ops.render.render(write_still=True)
    from PIL import Image

    ours, wanted = (
        np.asarray(Image.open(file).convert("RGB"), dtype=float) for file in (picture, tmp_path / "eevee.png")
    )
    assert ours.shape == wanted.shape
    difference = np.abs(ours - wanted)
    assert difference.mean() < 2.5 and np.median(difference) <= 1.0


def test_what_is_clear_is_blended_before_the_view_transform(blender, scene, stage, browser, tmp_path):
    """A black box that is half clear before a grey sky: each side halves the light, and not the number on the screen."""
    stage.environment(stage.picture("Grey", np.full((16, 32, 3), 0.6, dtype=np.float32)), mapping=False)
    pane = matte(blender, stage, "Pane", (0.0, 0.0, 0.0))
    pane.node_tree.nodes["Principled BSDF"].inputs["Alpha"].default_value = 0.5
    stage.object_of("Pane", stage.cube(), pane)
    blender.ops.prt.bake(mode="UNSHADOWED")
    scene.view_settings.view_transform = "Standard"
    path, picture = tmp_path / "page.html", tmp_path / "screen.png"
    blender.ops.prt.export_web_page(filepath=str(path), still=False)
    hide = "document.getElementById('panel').style.display = 'none'"
    browser.open(path, [hide, RESTED, {"picture": str(picture)}], WIDTH, HEIGHT)
    from PIL import Image

    shown = np.asarray(Image.open(picture).convert("RGB")).reshape(-1, 3)
    levels = {round(255 * (1.055 * light ** (1 / 2.4) - 0.055)) for light in (0.6, 0.3, 0.15)}
    found, count = np.unique(shown, axis=0, return_counts=True)
    common = {int(rgb[0]) for rgb in found[count > 0.02 * len(shown)]}
    assert len(common) > 1 and all(min(abs(one - level) for level in levels) <= 1 for one in common)


def test_hands_on_the_scene(page, browser):
    """Dragging looks around, shift and drag turns the sky, keys do both; a double click goes back."""
    place = "prt.orbit.position"
    dragged = {"drag": {"from": [100, 90], "to": [160, 100]}}
    skyward = {"drag": {"from": [100, 90], "to": [160, 90], "keys": ["Shift"]}}
    steps = [
        place,
        dragged,
        place,
        "prt.turn",
        skyward,
        "prt.turn",
        place,
        {"press": "2"},
        "prt.shading",
        {"press": "]"},
        "prt.turn",
        {"press": "Home"},
        place,
    ]
    first, _, moved, before, _, turned, still, _, shading, _, further, _, back = browser.open(page, steps, 1000, 600)
    assert np.linalg.norm(np.subtract(moved, first)) > 0.5
    assert before == 0.0 and turned == pytest.approx(0.36) and further == pytest.approx(0.44)
    np.testing.assert_allclose(still, moved)
    assert shading == "unshadowed"
    np.testing.assert_allclose(back, first, atol=1e-9)


def test_movements_of_the_camera_only_draw(page, browser):
    """The light of vertices is summed and sent to the graphics card when the sky turns or is another, and only then: of each mesh
    once, and once more for its coarse stand-in while it moves.
    """
    counted = "(() => { window.sent = 0; const to = WebGL2RenderingContext.prototype, send = to.bufferData;"
    counted += " to.bufferData = function (...all) { window.sent++; send.apply(this, all); }; })()"
    steps: list[object] = [counted]
    for change in ("prt.orbit.turn(0.1, 0.1)", "prt.exposure = 1", "prt.turn = 0.5", "prt.shading = 'unshadowed'"):
        steps += [f"(() => {{ window.sent = 0; {change}; prt.draw(); return window.sent; }})()", RESTED, "window.sent"]
    _, *found = browser.open(page, steps)
    at_once, at_rest = found[::3], found[2::3]
    assert at_once == [0, 0, 3, 3]
    assert at_rest[:2] == [0, 0] and all(count in {3, 6} for count in at_rest[2:])


def test_what_rests_is_drawn_finely(page, browser):
    """However coarsely it is drawn while it moves, where there is no graphics card."""
    moved = "new Promise((done) => { prt.orbit.turn(0.1, 0); prt.addEventListener('change', () => done(canvas.width), { once: true });"
    moved += " prt.redraw(); })"
    coarse, _, fine = browser.open(page, [moved, RESTED, "canvas.width"])
    assert coarse < WIDTH == fine


def test_the_scene_follows_the_window(page, browser):
    """All of it stays framed, and no picture is stretched."""
    shape = "[canvas.width, canvas.height, canvas.clientWidth, canvas.clientHeight]"
    half = "[...prt.orbit.seen(canvas.width / canvas.height)]"
    steps = [half, {"resize": [500, 700]}, RESTED, shape, half, {"resize": [900, 300]}, RESTED, shape]
    before, _, _, tall, after, _, _, wide = browser.open(page, steps)
    assert tall == [500, 700, 500, 700] and wide == [900, 300, 900, 300]
    assert after[0] == pytest.approx(before[0]) and after[1] == pytest.approx(before[0] * 7 / 5)


def hdr(sky):
    from prt_addon.core.exchange.radiance import radiance_file

    return base64.b64encode(radiance_file(sky.astype(np.float32))).decode()


def test_a_dropped_panorama_lights_the_scene(stage, page, browser):
    """It is projected as Blender would, listed and shown."""
    from prt_addon.core.sky.projection import project_equirect

    sky = stage.six_coloured_sky(64)[:, ::-1]
    steps = [{"drop": {"name": "My sky.hdr", "data": hdr(sky)}}, "[...prt.skies[prt.sky].light]"]
    steps += [
        "[...document.getElementById('sky').options].map((one) => one.text)",
        "document.getElementById('message').hidden",
    ]
    _, light, names, silent = browser.open(page, steps)
    wanted = project_equirect(sky, interpolated=True)
    np.testing.assert_allclose(np.reshape(light, (9, 3)), wanted, atol=0.01 * np.abs(wanted).max())
    assert names == ["Six", "My sky"] and silent


def test_a_dropped_exr_lights_the_scene(blender, stage, page, browser, tmp_path):
    """Of half floats, packed by ZIP or PIZ, as Blender saves it."""
    from prt_addon.core.sky.projection import project_equirect

    sky = stage.six_coloured_sky(32)[:, ::-1]
    settings = blender.context.scene.render.image_settings
    settings.file_format, settings.color_depth = "OPEN_EXR", "16"
    image = stage.picture("Sky", sky)
    steps = []
    for codec in ("ZIP", "PIZ"):
        settings.exr_codec = codec
        path = tmp_path / f"{codec}.exr"
        image.save_render(str(path))
        data = base64.b64encode(path.read_bytes()).decode()
        steps += [{"drop": {"name": path.name, "data": data}}, "[...prt.skies[prt.sky].light]"]
    half = base64.b64encode(path.read_bytes()[: path.stat().st_size // 2]).decode()
    steps += [{"drop": {"name": "half.exr", "data": half}}, "document.getElementById('message').textContent"]
    wanted = project_equirect(sky, interpolated=True)
    *lights, message = browser.open(page, steps)[1::2]
    assert message.startswith('"half.exr" cannot be opened. It is broken')
    for light in lights:
        np.testing.assert_allclose(np.reshape(light, (9, 3)), wanted, atol=0.002 * np.abs(wanted).max())


@pytest.mark.parametrize(
    ("name", "data", "said"),
    [
        ("broken.hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 64 +X 128\n\2\2\0\x80rest", "file is broken"),
        ("other.hdr", b"\x89PNG\r\n\x1a\n", "no Radiance picture"),
        ("photo.jpg", b"\xff\xd8\xff", "no .hdr or .exr file"),
        ("broken.exr", b"\x76\x2f\x31\x01\2\0\0\0channels", "is broken"),
        ("other.exr", b"#?RADIANCE", "no OpenEXR picture"),
        ("square.hdr", base64.b64decode(hdr(np.ones((16, 16, 3)))), "twice as wide as high"),
    ],
)
def test_a_broken_panorama_is_said(page, browser, name, data, said):
    """In a sentence that names it; the sky stays."""
    dropped = {"drop": {"name": name, "data": base64.b64encode(data).decode()}}
    _, message, hidden, sky = browser.open(
        page,
        [
            dropped,
            "document.getElementById('message').textContent",
            "document.getElementById('message').hidden",
            "prt.sky",
        ],
    )
    assert said in message and name in message and message.endswith(".") and not hidden and sky == 0


def test_lost_graphics_come_back(page, browser):
    """The browser may take them away at any time."""
    lose = "new Promise((done) => { const lost = document.getElementById('canvas').getContext('webgl2').getExtension('WEBGL_lose_context');"
    lose += " lost.loseContext(); setTimeout(() => lost.restoreContext(), 100); setTimeout(done, 800); })"
    before, _, after = browser.open(
        page, [f"prt.radiance({WIDTH}, {HEIGHT})", lose, f"prt.radiance({WIDTH}, {HEIGHT})"]
    )
    np.testing.assert_array_equal(before, after)
    assert before.max() > 0.0


def test_without_webgl_a_still_is_shown(blender, scene_of_all, browser, tmp_path):
    path = tmp_path / "page.html"
    blender.ops.prt.export_web_page(filepath=str(path))
    steps = [
        "document.getElementById('message').textContent",
        "document.querySelector('#still img').getBoundingClientRect().width",
    ]
    message, width = browser.open(
        path, steps, flags=["--disable-gpu", "--disable-software-rasterizer", "--disable-3d-apis"]
    )
    assert "no WebGL 2" in message and width == WIDTH


def test_small_screens_get_a_folded_sheet(page, browser, tmp_path):
    """At the bottom, as wide as the screen; nothing sticks out."""
    steps = [
        "document.getElementById('panel').classList.contains('folded')",
        "(({left, right, bottom}) => [left, right, bottom])(document.getElementById('panel').getBoundingClientRect())",
        "document.documentElement.scrollWidth",
        "document.getElementById('fold').click()",
        "document.getElementById('panel').scrollWidth <= document.getElementById('panel').clientWidth",
    ]
    folded, sides, across, _, fits = browser.open(page, steps, 390, 844, touch=True)
    assert folded and sides == [0, 390, 844] and across == 390 and fits
