# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs probes of docs/examples/games202: pages that draw in floats with its scripts and post the pixels."""

import json
import subprocess
import tempfile
from pathlib import Path

PAGE = Path(__file__).resolve().parents[2] / "docs" / "examples" / "games202"
SIZE, STEP = 256, 4
"""Pixels of the picture's side, of which every fourth is compared."""
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
function post(promise) {
  promise.then(JSON.stringify, (error) => error.message).then((body) => fetch("/found", { method: "POST", body }));
}
</script>"""
"""What the probes share: they draw in floats, as bytes are too coarse, and send what they find to the server."""


SCRIPTS = "".join(
    f'<script src="{name}.js"></script>'
    for name in ("files", "harmonics", "program", "camera", "sky", "view", "viewer")
)


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
