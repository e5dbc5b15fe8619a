# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes on the command line show progress, end at Ctrl-C, and resume after a kill."""

import fcntl
import os
import pty
import signal
import struct
import subprocess
import sys
import termios
import time
from pathlib import Path

import pytest

BLENDER = [sys.executable, str(Path(__file__).resolve().parents[1] / "background_blender.py"), "-b"]
NOT_SOON = 1 << 16  # samples


@pytest.fixture
def blend(blender, scene, stage, tmp_path):
    """A ball of 162 receivers under a sky, in a file."""
    stage.environment(stage.picture("Sky", stage.six_coloured_sky(16)))
    stage.object_of("Ball", stage.icosphere(3), stage.diffuse())
    path = tmp_path / "scene.blend"
    blender.ops.wm.save_as_mainfile(filepath=str(path))
    return path


def baking(blend, options):
    """A command line that bakes a file and saves it."""
    code = f"import bpy; bpy.ops.prt.bake({options}); bpy.ops.wm.save_mainfile()"
    return [*BLENDER, str(blend), "--python-exit-code", "1", "--python-expr", code]


def on_a_terminal(line, act):
    """Run a command line with a terminal as its stderr; `act` is called with the process once the bar has moved."""
    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 100, 0, 0))
    with subprocess.Popen(line, stderr=theirs, stdout=subprocess.PIPE, text=True) as process:
        os.close(theirs)
        shown, acted = b"", False
        while True:
            try:
                shown += os.read(ours, 4096)
            except OSError:  # the other side is closed
                break
            if not acted and b"ray/s" in shown:
                acted = True
                act(process)
        said = process.stdout.read()
    os.close(ours)
    return process.returncode, shown.decode(), said


def test_progress_is_for_terminals(blend):
    """A bar that ends whole on a terminal, nothing anywhere else; the result is saved."""
    line = baking(blend, "mode='INTERREFLECTED', samples=512")
    before = blend.read_bytes()
    quiet = subprocess.run(line, capture_output=True, text=True)
    assert quiet.returncode == 0 and "ray" not in quiet.stderr and "%" not in quiet.stderr + quiet.stdout
    assert blend.read_bytes() != before
    code, shown, _ = on_a_terminal(line, lambda process: None)
    assert code == 0 and "PRT: 100%" in shown and "ray/s" in shown


def test_ctrl_c_on_the_command_line(blend):
    """The process fails with a sentence, soon, and the file is what it was."""
    before, stopped = blend.read_bytes(), []

    def interrupt(process):
        stopped.append(time.perf_counter())
        process.send_signal(signal.SIGINT)

    code, shown, said = on_a_terminal(baking(blend, f"mode='SHADOWED', samples={NOT_SOON}"), interrupt)
    assert stopped and time.perf_counter() - stopped[0] < 5.0
    assert code == 1 and "Interrupted; nothing was changed" in shown + said
    assert blend.read_bytes() == before


@pytest.mark.slow
def test_a_killed_bake_resumes_from_its_checkpoints(blender, part, stage, blend, tmp_path):
    """The file is what it was, and the second try has the bits of one that was not stopped."""
    folder = tmp_path / "checkpoints"
    samples = part("trace").RAYS_IN_A_PIECE // 155  # two pieces: there are 162 receivers
    options = f"mode='SHADOWED', samples={samples}, checkpoint_dir='{folder}'"
    before = blend.read_bytes()
    with subprocess.Popen(baking(blend, options), stdout=subprocess.DEVNULL) as process:
        while process.poll() is None and not list(folder.glob("*.npz")):
            time.sleep(0.01)
        process.kill()
    assert process.returncode == -signal.SIGKILL
    assert blend.read_bytes() == before
    first = {path: path.stat().st_mtime_ns for path in folder.glob("*.npz")}
    assert len(first) == 1
    blender.ops.wm.open_mainfile(filepath=str(blend))
    scene = blender.context.scene
    blender.ops.prt.bake(mode="SHADOWED", samples=samples, checkpoint_dir=str(folder))
    resumed = stage.baked_bytes(scene)
    assert len(list(folder.glob("*.npz"))) == 2
    assert {path: path.stat().st_mtime_ns for path in first} == first
    blender.ops.prt.remove()
    blender.ops.prt.bake(mode="SHADOWED", samples=samples)
    assert stage.baked_bytes(scene) == resumed
