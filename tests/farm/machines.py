# SPDX-License-Identifier: GPL-3.0-or-later
"""Gives tests of farms an executable in place of Blender's, processes that are killed, and the result."""

import os
import signal
import subprocess
import sys
from pathlib import Path

BACKGROUND_BLENDER = Path(__file__).resolve().parents[1] / "background_blender.py"


def launcher(tmp_path):
    """An executable in place of Blender's, which notes its processes in `blenders.txt`."""
    path = tmp_path / "blender"
    path.write_text(
        f'#!/bin/sh\necho $$ >> "{tmp_path / "blenders.txt"}"\nexec "{sys.executable}" "{BACKGROUND_BLENDER}" "$@"\n'
    )
    path.chmod(0o755)
    return path


def killed_at_work(line):
    """Run a command line and kill it, and all it started, once it has read its file."""
    with subprocess.Popen(line, stdout=subprocess.PIPE, text=True, start_new_session=True) as process:
        for output in process.stdout:
            if output.startswith("Read blend"):
                break
        os.killpg(process.pid, signal.SIGKILL)
        assert process.wait() == -signal.SIGKILL


def run(line):
    answer = subprocess.run(line, capture_output=True, text=True)
    assert answer.returncode == 0, answer.stdout + answer.stderr


def digest_of(bpy, stage, path):
    """All that a bake wrote into a file, byte by byte."""
    bpy.ops.wm.open_mainfile(filepath=str(path))
    found = stage.baked_bytes(bpy.context.scene)
    layers = {name: len(layers) for name, (layers, _) in found[0].items()}
    assert layers == {"Floor": 12, "Ball": 9, "Moving": 9} and len(found[1]) == 9  # a sheet has three for its back
    return found


def plain_digest(bpy, stage, path, **settings):
    """The same of a bake in one go."""
    bpy.ops.wm.open_mainfile(filepath=str(path))
    assert bpy.ops.prt.bake(**settings) == {"FINISHED"}
    return stage.baked_bytes(bpy.context.scene)
