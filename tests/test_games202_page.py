# SPDX-License-Identifier: GPL-3.0-or-later
"""The page docs/examples/games202 in a real browser: its pixels are NumPy's, whichever way the sky is turned."""

import functools
import http.server
import json
import queue
import re
import shutil
import subprocess
import tempfile
import threading
from pathlib import Path

import numpy as np
import pytest

from prt_addon.core.microfacet import compensation, ggx, table
from prt_addon.core.microfacet.albedo import by_quadrature
from tests.core.references import axis_angle, order2, sphere_quadrature

PAGE = Path(__file__).resolve().parents[1] / "docs" / "examples" / "games202"
BROWSERS = ("chromium", "chromium-browser", "google-chrome")
SIZE, STEP = 256, 4
"""Pixels of the picture's side, of which every fourth is compared."""
FIELD_OF_VIEW = np.radians(40.0)
UP = np.array([0.0, 0.0, 1.0])
COLOUR = np.array([0.8, 0.7, 0.6])
"""Of the box and its floor."""
GRID = np.linspace(0.02, 1.0, 200)
SIGNS = np.array([1, -1, 1, -1, 1, -1, 1, -1, 1])  # Condon-Shortley
TURNS = [np.eye(3), axis_angle((0, 1, 0), 1.0), axis_angle((1, 0, 0), 2.0), axis_angle((1, 2, -3), 2.5)]

FLOATS = """<!doctype html>
<script>
function floatTarget(width, height, version = "webgl") {
  const gl = document.createElement("canvas").getContext(version), needed = {
    webgl: ["OES_texture_float", "WEBGL_color_buffer_float"], webgl2: ["EXT_color_buffer_float"] }[version];
  if (!gl || !needed.every((name) => gl.getExtension(name))) throw new Error("no floats");
  const target = gl.createTexture(), depth = gl.createRenderbuffer();
  gl.bindTexture(gl.TEXTURE_2D, target);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F ?? gl.RGBA, width, height, 0, gl.RGBA, gl.FLOAT, null);
  gl.bindRenderbuffer(gl.RENDERBUFFER, depth);
  gl.renderbufferStorage(gl.RENDERBUFFER, gl.DEPTH_COMPONENT16, width, height);
  gl.bindFramebuffer(gl.FRAMEBUFFER, gl.createFramebuffer());
  gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, target, 0);
  gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, depth);
  return gl;
}
function pixelsOf(gl, width, height, step) {
  const pixels = new Float32Array(4 * width * height), found = [];
  gl.readPixels(0, 0, width, height, gl.RGBA, gl.FLOAT, pixels);
  for (let row = 0; row < height; row += step)
    for (let column = 0; column < width; column += step) found.push(...pixels.slice(4 * (row * width + column), 4 * (row * width + column) + 4));
  return found;
}
async function text(name) { return (await fetch(name)).text(); }
async function read(shown, folder = ".") {
  const mesh = Files.mesh(await text("figure.obj"));
  shown.setScene(mesh, Files.transport(await text(`${folder}/transport.txt`), mesh.places.length / 3), Files.light(await text("light.txt")));
}
function tell(promise) {
  promise.then(JSON.stringify, (error) => error.message).then((body) => fetch("/found", { method: "POST", body }));
}
</script>"""
"""What the probes share: they draw in floats, as bytes are too coarse, and send what they find to the server."""

SCRIPTS = "".join(
    f'<script src="{name}.js"></script>'
    for name in ("files", "harmonics", "program", "camera", "sky", "view", "viewer")
)

MESH_PROBE = f"""{SCRIPTS}<script>
async function run() {{
  const gl = floatTarget(SIZE, SIZE), viewer = new Viewer(gl);
  await read(viewer);
  const pictures = TURNS.map((turn) => {{
    viewer.turn = turn;
    viewer.draw(SIZE, SIZE, false);
    return pixelsOf(gl, SIZE, SIZE, STEP);
  }});
  return {{ ...viewer.camera.place(), pictures }};
}}
tell(run());
</script>"""

REFLECTION_PROBE = f"""{SCRIPTS}<script src="gbuffer.js"></script><script src="reflection.js"></script><script>
async function run() {{
  const gl = floatTarget(SIZE, SIZE, "webgl2"), reflection = new Reflection(gl), pictures = {{}};
  reflection.floorOnly = true;
  reflection.samples = RAYS;
  reflection.camera.elevation = 0.4;
  for (const [name, mode, folder] of [["direct", "direct", "."], ["mirror", "mirror", "."], ["indirect", "indirect", "."], ["bounced", "direct", "bounced"]]) {{
    await read(reflection, folder);
    reflection.mode = mode;
    reflection.draw(SIZE, SIZE, false);
    pictures[name] = pixelsOf(gl, SIZE, SIZE, STEP);
  }}
  return {{ ...reflection.camera.place(), pictures }};
}}
tell(run());
</script>"""

METAL_PROBE = """<script src="program.js"></script><script src="metal.js"></script>
<script>
async function run() {
  const tables = [await Metal.table("GGX_E_LUT.png"), await Metal.table("GGX_Eavg_LUT.png")];
  const gl = floatTarget(10 * SIZE, 2 * SIZE), metal = new Metal(gl, ...tables);
  metal.lamp = LAMP;
  return [false, true].map((course) => {
    metal.course = course;
    metal.draw(10 * SIZE, 2 * SIZE, false);
    return pixelsOf(gl, 10 * SIZE, 2 * SIZE, 1);
  });
}
tell(run());
</script>"""


MESSAGE_PROBE = """<!doctype html><iframe id="page"></iframe>
<script>
const page = document.getElementById("page");
page.src = ADDRESS;
const timer = setInterval(() => {
  const said = page.contentDocument?.getElementById("message")?.textContent;
  if (!said || said === "Loading ...") return;
  clearInterval(timer);
  fetch("/found", { method: "POST", body: JSON.stringify(said) });
}, 100);
</script>"""


@pytest.fixture(scope="module")
def browser():
    """The command that opens an address without a window."""
    found = next(filter(None, map(shutil.which, BROWSERS)), None)
    if not found:
        pytest.skip("No Chromium is installed (apt-get install chromium)")
    return [found, "--headless", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]


@pytest.fixture
def served(tmp_path):
    """A folder with the page in it, its address on this machine, and a queue of what is posted there."""
    for path in PAGE.iterdir():
        shutil.copy(path, tmp_path)
    posted = queue.Queue()

    class Server(http.server.SimpleHTTPRequestHandler):
        """Serves files, keeps what is posted, and writes no log."""

        def do_POST(self):
            """Keep the body."""
            posted.put(self.rfile.read(int(self.headers["Content-Length"])).decode())
            self.send_response(204)
            self.end_headers()

        def log_message(self, *_arguments):
            """Nothing."""

    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Server, directory=tmp_path))
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    yield tmp_path, f"http://127.0.0.1:{server.server_port}", posted
    server.shutdown()
    thread.join()
    server.server_close()


def probed(browser, served, probe, **constants):
    """What a probe finds, given constants by their names."""
    folder, address, posted = served
    given = "".join(f"const {name} = {json.dumps(value)};" for name, value in constants.items())
    (folder / "probe.html").write_text(f"<script>{given}</script>{probe}")
    profile = tempfile.mkdtemp(dir=folder)
    line = [*browser, "--remote-debugging-port=0", f"--user-data-dir={profile}", f"{address}/probe.html"]
    with subprocess.Popen(line, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as running:
        try:
            text = posted.get(timeout=300)
        finally:
            running.terminate()
    assert text[0] in '{["', text
    return json.loads(text)


@pytest.fixture
def exported(blender, scene, stage, served):
    """Bakes and exports a mesh of one colour that a function of bmesh makes, beside the page, once per mode: its folder."""

    def export(build, colour=(1.0, 1.0, 1.0), **folders):
        stage.environment(stage.picture("Six", stage.six_coloured_sky(32)), strength=0.25)
        mesh = stage.from_bmesh("Figure", build, smooth=False)
        paint = mesh.color_attributes.new("Color", "FLOAT_COLOR", "POINT")
        paint.data.foreach_set("color", (*colour, 1.0) * len(mesh.vertices))
        mesh.color_attributes.active_color = paint
        ob = stage.object_of("Figure", mesh, stage.diffuse(colour=colour))
        ob.select_set(True)
        blender.context.view_layer.objects.active = ob
        blender.ops.wm.obj_export(
            filepath=str(served[0] / "figure.obj"), export_materials=False, export_uv=False, export_colors=True
        )
        for mode, folder in folders.items():
            (served[0] / folder).mkdir(exist_ok=True)
            blender.ops.prt.bake(mode=mode, samples=256, bounces=1)
            blender.ops.prt.export_games202(directory=str(served[0] / folder))
        return served[0]

    return export


def ball_over_a_floor(bm):
    """One mesh, so that the floor has a shadow."""
    import bmesh

    bmesh.ops.create_icosphere(bm, subdivisions=3, radius=0.7)
    bmesh.ops.translate(bm, verts=bm.verts, vec=(0.0, 0.0, 0.4))
    floor = bmesh.ops.create_grid(bm, x_segments=6, y_segments=6, size=1.2)["verts"]
    bmesh.ops.translate(bm, verts=floor, vec=(0.0, 0.0, -0.5))
    bmesh.ops.triangulate(bm, faces=bm.faces)


def box_on_a_floor(bm):
    """Turned, so that two of its sides are seen, and mirrored."""
    import bmesh
    from mathutils import Matrix

    bmesh.ops.create_grid(bm, x_segments=8, y_segments=8, size=1.0)
    placed = Matrix.Translation((0.1, 0.2, 0.4)) @ Matrix.Rotation(0.6, 4, "Z") @ Matrix.Scale(0.8, 4)
    bmesh.ops.create_cube(bm, size=1.0, matrix=placed)
    bmesh.ops.triangulate(bm, faces=bm.faces)


def triangles_of(path):
    """(T, 3, 3) places of an .obj's corners."""
    lines = [line.split() for line in path.read_text().splitlines()]
    vertices = np.array([words[1:4] for words in lines if words[:1] == ["v"]], dtype=float)
    faces = [[int(word.split("/")[0]) - 1 for word in words[1:]] for words in lines if words[:1] == ["f"]]
    return vertices[np.array(faces)]


def turned_light(light, turn):
    """The light of the turned sky, by projecting what is seen along every direction before it was turned."""
    directions, weights = sphere_quadrature(6)
    seen = (order2(directions @ turn) * SIGNS) @ light  # rows times R: R^T of each
    return (order2(directions) * SIGNS * weights[:, None]).T @ seen


def rays_of_pixels(axes):
    """(rows, columns, 3) unit directions of the compared pixels, row 0 at the bottom."""
    line = ((2.0 * np.arange(0, SIZE, STEP) + 1.0) / SIZE - 1.0) * np.tan(FIELD_OF_VIEW / 2.0)
    x, y = np.meshgrid(line, line)
    rays = x[..., None] * axes[0] + y[..., None] * axes[1] - axes[2]
    return rays / np.linalg.norm(rays, axis=-1, keepdims=True)


def first_hits(triangles, origins, rays):
    """(N,) distances, inf where nothing is met, triangles, and (N, 3) barycentrics (Moeller & Trumbore 1997)."""
    corner, first, second = triangles[:, 0], triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    across = np.cross(rays[:, None], second)
    volume = (across * first).sum(axis=-1)
    volume = np.where(np.abs(volume) > 1e-12, volume, 1e-12)
    offset = origins[:, None] - corner
    u = (across * offset).sum(axis=-1) / volume
    along = np.cross(offset, first)
    v = (rays[:, None] * along).sum(axis=-1) / volume
    distance = (second * along).sum(axis=-1) / volume
    distance = np.where((u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) & (distance > 1e-4), distance, np.inf)
    ray, hit = np.arange(len(rays)), distance.argmin(axis=1)
    u, v = u[ray, hit], v[ray, hit]
    return distance[ray, hit], hit, np.stack([1.0 - u - v, u, v], axis=-1)


def shown(colours, hit, weights):
    """(N, 3) between the corners' colours, and nothing below 0."""
    return np.maximum((colours[hit] * weights[..., None]).sum(axis=1), 0.0)


def ray_traced(triangles, colours, eye, axes):
    """(rows, columns, 4) what the compared pixels' rays meet first, transparent where that is nothing."""
    rays = rays_of_pixels(axes)
    distance, *met = first_hits(triangles, np.broadcast_to(eye, (rays.size // 3, 3)), rays.reshape(-1, 3))
    covered = np.isfinite(distance)[:, None]
    found = np.concatenate([shown(colours, *met), np.ones_like(covered)], axis=1)
    return np.where(covered, found, 0.0).reshape(*rays.shape[:2], 4)


@pytest.mark.once
def test_pixels_are_numpys(browser, served, exported):
    """At four turns, about other axes than the slider's, too; but for pixels on an edge, which two rasterisers may give away."""
    folder = exported(ball_over_a_floor, SHADOWED=".")
    turns = [turn.tolist() for turn in TURNS]
    found = probed(browser, served, FLOATS + MESH_PROBE, SIZE=SIZE, STEP=STEP, TURNS=turns)
    triangles, light = triangles_of(folder / "figure.obj"), np.loadtxt(folder / "light.txt")
    transport = np.loadtxt(folder / "transport.txt", skiprows=1)
    pictures = []
    for turn, pixels in zip(TURNS, found["pictures"], strict=True):
        colours = (transport @ turned_light(light, turn)).reshape(-1, 3, 3)
        expected = ray_traced(triangles, colours, np.array(found["eye"]), np.array(found["axes"]))
        ours = np.array(pixels).reshape(expected.shape)
        off = np.abs(ours - expected).max(axis=-1) > 1e-3
        assert expected[..., 3].mean() > 0.15 and 0.8 < expected[..., :3].max() < 1.5
        assert off.mean() < 0.005, f"{off.sum()} pixels, by {np.abs(ours - expected).max()}"
        pictures.append(ours)
    assert all(np.abs(other - pictures[0]).max() > 0.1 for other in pictures[1:]), "the turns would be noticed"


class Seen:
    """The box on its floor as NumPy traces it, and what of its light the browser's camera sees."""

    def __init__(self, folder, eye, axes):
        self.triangles, self.light = triangles_of(folder / "figure.obj"), np.loadtxt(folder / "light.txt")
        transport = np.loadtxt(folder / "transport.txt", skiprows=1)
        self.colours = COLOUR * (transport @ self.light).reshape(-1, 3, 3)
        self.eye, self.axes = np.array(eye), np.array(axes)
        rays = rays_of_pixels(self.axes).reshape(-1, 3)
        distance, self.hit, self.weights = first_hits(self.triangles, np.broadcast_to(self.eye, rays.shape), rays)
        self.covered, self.rays = np.isfinite(distance), rays
        self.places = self.eye + np.where(self.covered, distance, 0.0)[:, None] * rays
        corners = self.triangles[self.hit]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        self.normals = normals / np.linalg.norm(normals, axis=-1, keepdims=True)

    def along(self, places, directions):
        """(N, 3) light from there, and whether the camera sees what sends it; (N,) whether nothing is there."""
        distance, hit, weights = first_hits(self.triangles, places, directions)
        leaves = ~np.isfinite(distance)
        back = places + np.where(leaves, 0.0, distance)[:, None] * directions - self.eye
        far = np.maximum(np.linalg.norm(back, axis=-1), 1e-9)
        nearest, *_ = first_hits(self.triangles, np.broadcast_to(self.eye, back.shape), back / far[:, None])
        in_view = back @ self.axes.T
        limit = -in_view[:, 2] * np.tan(FIELD_OF_VIEW / 2.0)
        on_screen = ~leaves & (np.abs(in_view[:, :2]) < limit[:, None]).all(axis=1) & (np.abs(nearest - far) < 1e-3)
        return shown(self.colours, hit, weights), on_screen, leaves

    def sky(self, directions):
        """(N, 3) the SH light."""
        return np.maximum((order2(directions) * SIGNS) @ self.light, 0.0)


@pytest.mark.once
def test_light_of_the_screen_is_numpys(browser, served, exported):
    """A box on its floor: what a mirror shows, and the light that bounces."""
    folder = exported(box_on_a_floor, COLOUR, INTERREFLECTED="bounced", SHADOWED=".")
    found = probed(browser, served, FLOATS + REFLECTION_PROBE, SIZE=SIZE, STEP=STEP, RAYS=32)
    pictures = {name: np.array(pixels).reshape(-1, 4)[:, :3] for name, pixels in found["pictures"].items()}
    seen = Seen(folder, found["eye"], found["axes"])
    check_direct_light(pictures, seen)
    check_reflections(pictures, seen)
    check_indirect_light(pictures, seen)


def check_direct_light(pictures, seen):
    """Of the G-buffer; but for pixels on an edge."""
    expected = np.where(seen.covered[:, None], shown(seen.colours, seen.hit, seen.weights), 0.0)
    assert (np.abs(pictures["direct"] - expected).max(axis=1) > 1e-3).mean() < 0.005


def check_reflections(pictures, seen):
    """In a mirror floor: the box where the screen shows it, and the SH light where there is only sky."""
    floor = seen.covered & (seen.normals[:, 1] > 0.99) & (seen.places[:, 1] < 0.01)
    directions = seen.rays * (1.0, -1.0, 1.0)
    light, on_screen, leaves = seen.along(seen.places, directions)
    for which, expected in ((floor & on_screen, light), (floor & leaves, seen.sky(directions))):
        off = np.abs(pictures["mirror"] - expected)[which].max(axis=1) > 0.05
        print(f"{which.sum()} pixels, {off.mean():.1%} off")  # pytest shows it on failure, or with -s
        assert which.mean() > 0.04
        assert off.mean() <= 0.03, f"{off.sum()} of {which.sum()} pixels"
    box = floor & on_screen
    for other in (pictures["direct"], seen.sky(directions)):
        assert (np.abs(other - light)[box].max(axis=1) > 0.05).mean() > 0.5, "another picture would be noticed"


def check_indirect_light(pictures, seen):
    """Over all surfaces within 8 % of NumPy's, and so the picture comes closer to what is baked with a bounce."""
    chosen = np.flatnonzero(seen.covered)[::3]
    rng = np.random.default_rng(5)
    total = np.zeros(3)
    for _ in range(16):
        around = rng.normal(size=(len(chosen), 3))
        directions = seen.normals[chosen] + around / np.linalg.norm(around, axis=-1, keepdims=True)  # by the cosine
        light, on_screen, _ = seen.along(
            seen.places[chosen], directions / np.linalg.norm(directions, axis=-1, keepdims=True)
        )
        total += (light * on_screen[:, None]).mean(axis=0) / 16.0
    added = (pictures["indirect"] - pictures["direct"])[chosen]
    print(added.mean(axis=0), COLOUR * total)
    np.testing.assert_allclose(added.mean(axis=0), COLOUR * total, rtol=0.08)
    before, after = (np.linalg.norm(pictures[name] - pictures["bounced"]) for name in ("direct", "indirect"))
    print(f"from the bounce: {before:.3f} without, {after:.3f} with")
    assert after < 0.75 * before


def metal(size, lamp, colour, bounce_colour):
    """(2 size, 10 size, 3) the same spheres by the engine; below, with the light of all bounces."""
    line = 2.0 * (np.arange(size) + 0.5) / size - 1.0
    x, y = np.meshgrid(line, line)
    away = x * x + y * y
    normals = np.stack([x, y, np.sqrt(np.maximum(1.0 - away, 0.01))], axis=-1)
    mu_out, mu_in = normals[..., 2], normals @ lamp
    half = normals @ (lamp + UP) / np.linalg.norm(lamp + UP)
    lit = (away <= 0.99) & (mu_in > 0.0)
    columns = []
    for roughness in np.arange(1, 11) / 10.0:
        alpha, inward = roughness**2, np.where(lit, mu_in, 1.0)
        seen = ggx.masking_shadowing(mu_out, inward, alpha)
        first = colour * (ggx.distribution(half, alpha) * seen / (4.0 * mu_out * inward))[..., None]
        average = table.average_albedo(roughness)
        albedos = (np.interp(mu, GRID, by_quadrature(GRID, roughness).white) for mu in (mu_out, inward))
        further = compensation.lost_lobe(*albedos, average)[..., None] * bounce_colour(colour, average)
        columns.append(np.concatenate([first + further, first]) * np.tile((np.pi * lit * inward)[..., None], (2, 1, 1)))
    return np.concatenate(columns, axis=1)


@pytest.mark.once
def test_metal_is_the_engines(browser, served):
    """Rows of spheres with and without the second lobe, in both colours of it; the tables are of eight bits."""
    for name in ("GGX_E_LUT.png", "GGX_Eavg_LUT.png"):
        shutil.copy(PAGE.parents[1] / "pictures" / "course" / name, served[0])
    lamp, size = np.array([0.5, 0.0, np.sqrt(0.75)]), 24
    pictures = probed(browser, served, FLOATS + METAL_PROBE, SIZE=size, LAMP=lamp.tolist())
    colours = (compensation.bounce_colour, compensation.course_bounce_colour)
    for pixels, bounce_colour in zip(pictures, colours, strict=True):
        ours = np.array(pixels).reshape(2 * size, 10 * size, 4)[..., :3]
        expected = metal(size, lamp, np.array([0.95, 0.64, 0.54]), bounce_colour)
        np.testing.assert_allclose(ours[size:], expected[size:], atol=1e-3, rtol=1e-3)
        np.testing.assert_allclose(ours[:size], expected[:size], atol=0.02, rtol=1e-3)
    assert np.abs(np.subtract(*pictures)).max() > 0.05, "the course's colour would be noticed"


@pytest.mark.once
def test_page_says_what_is_missing(browser, served):
    """As a sentence, and not on the console."""
    folder, *_ = served

    def said(address):
        return probed(browser, served, MESSAGE_PROBE, ADDRESS=address)

    assert "figure.obj is not there: 404" in said("index.html")
    assert re.search(r"GGX_E(avg)?_LUT.png is not there: 404", said("metal.html"))  # the first that fails
    (folder / "figure.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    (folder / "transport.txt").write_text("3\n" + "0.28 0 0 0 0 0 0 0 0\n" * 2)
    assert "transport.txt has 2 rows, but the mesh has 3 face corners" in said("index.html?files=.")


@pytest.mark.once
@pytest.mark.parametrize(
    ("page", "sentence"), [("index", "Choose an .obj"), ("reflection", "Choose an .obj"), ("metal", "serve the folder")]
)
def test_page_from_disk_says_what_to_do(browser, page, sentence):
    line = [*browser, "--dump-dom", (PAGE / f"{page}.html").as_uri()]
    done = subprocess.run(line, capture_output=True, text=True, timeout=120, check=True)
    assert sentence in re.search(r'<p id="message">(.*?)</p>', done.stdout, re.DOTALL).group(1)
