# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs a Blender that lacks the extension, in a process and a profile of its own."""

import subprocess
import sys
from pathlib import Path

BEGINNING = """
import bpy, sys
assert not any(name.endswith("prt_relight") for name in bpy.context.preferences.addons.keys())
"""

RENDER = """
blend, *frames = sys.argv[1:]
bpy.ops.wm.open_mainfile(filepath=blend)
for number, path in enumerate(frames, start=1):
    bpy.context.scene.frame_set(number)
    bpy.context.scene.render.filepath = path
    bpy.ops.render.render(write_still=True)
"""


def run(folder, script, *words):
    """Run a script with its words; files of it and of the profile lie in a folder."""
    path = folder / "bare.py"
    path.write_text(BEGINNING + script)
    subprocess.run(
        [sys.executable, path, *words],
        check=True,
        capture_output=True,
        env={"PATH": "/usr/bin:/bin", "HOME": str(Path.home()), "BLENDER_USER_RESOURCES": str(folder / "profile")},
    )


def rendered(bpy, stage, folder, count):
    """Save the open file and render its first frames there: pixels of each."""
    blend = folder / "saved.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    frames = [folder / f"bare_{number}.exr" for number in range(1, count + 1)]
    run(folder, RENDER, blend, *frames)
    return [stage.read_exr(frame) for frame in frames]
