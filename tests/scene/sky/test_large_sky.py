# SPDX-License-Identifier: GPL-3.0-or-later
"""Large pictures take little memory and time, in processes of their own, as a peak is a process's."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

pytestmark = pytest.mark.slow

HEIGHTS = (4096, 2048, 1024)  # the largest first: then the peak is its own

BEGIN = """
import sys, time
sys.path.insert(0, sys.argv[1])
import headless
headless.enable_extension()
import bpy, numpy as np

def peak():
    # KiB, of this program alone: getrusage counts what it was started from, too
    return int(next(line for line in open("/proc/self/status") if line.startswith("VmHWM")).split()[1])
"""

WRITE = (
    BEGIN
    + """
settings = bpy.context.scene.render.image_settings
settings.file_format, settings.color_depth, settings.exr_codec = "OPEN_EXR", "16", "ZIP"
for path in sys.argv[2:]:
    height = int(path.rsplit("-", 1)[1].removesuffix(".exr"))
    image = bpy.data.images.new("Sky", 2 * height, height, float_buffer=True)
    pixels = np.ones((height, 2 * height, 4), dtype=np.float32)
    pixels[..., :3] = np.linspace(0.0, 2.0, height, dtype=np.float32)[:, None, None]
    image.pixels.foreach_set(pixels.reshape(-1))
    image.save_render(path)
    bpy.data.images.remove(image)
headless.disable_extension()
"""
)

MEASURE = (
    BEGIN
    + """
world = bpy.context.scene.world
headless.use_nodes(world)
texture = world.node_tree.nodes.new("ShaderNodeTexEnvironment")
background = next(node for node in world.node_tree.nodes if node.bl_idname == "ShaderNodeBackground")
world.node_tree.links.new(texture.outputs["Color"], background.inputs["Color"])
for path in sys.argv[2:]:
    texture.image = bpy.data.images.load(path)
    texture.image.size[0]  # loads the file
    start = time.process_time()
    bpy.ops.prt.project_light()
    seconds = time.process_time() - start
    print("MEASURED", seconds, peak() / 2**20, world["prt_light_0"][0])
    bpy.data.images.remove(texture.image)
headless.disable_extension()
"""
)


def run(script, *arguments):
    """Its lines of measurements."""
    tools = Path(__file__).resolve().parents[3] / "tools"
    done = subprocess.run(
        [sys.executable, "-c", script, tools, *arguments],
        check=True,
        capture_output=True,
        text=True,
        env={"PATH": "/usr/bin:/bin", "HOME": str(Path.home())},
    )
    return [line.split()[1:] for line in done.stdout.splitlines() if line.startswith("MEASURED")]


def test_8k_fits_and_time_is_linear(tmp_path):
    """8192 x 4096 texels of float: the whole process with Blender stays under 1.6 GiB, and texels cost the same each."""
    paths = [tmp_path / f"sky-{height}.exr" for height in HEIGHTS]
    run(WRITE, *paths)
    (large, peak, mean), (middle, *_), (small, *_) = np.array(run(MEASURE, *paths), dtype=float)
    assert np.isclose(mean, np.sqrt(4 * np.pi), rtol=1e-3)  # it goes from 0 to 2 over the elevation
    if sys.platform.startswith("linux"):  # elsewhere the peak has other units
        assert peak < 1.6
    assert large < 4 * 1.75 * middle and large < 16 * 1.75 * small
    for path in paths:
        path.unlink()
