# SPDX-License-Identifier: GPL-3.0-or-later
"""Jobs of the engine's process, and what becomes of the process."""

import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from prt_addon.core.problem import BakeProblem
from prt_addon.session import session
from prt_addon.worker import job
from tests.core import baking, bouncing
from tests.core.bouncing import Scene

SETTINGS = bouncing.SETTINGS
NOT_SOON = replace(SETTINGS, samples=1 << 16)


def pid():
    """Of the engine that runs."""
    return session.engine.process


def bake(scene: Scene, settings=SETTINGS, **options):
    return job.bake_job(BakeProblem.of(*scene, settings), **options)


def done(scene, settings=SETTINGS, **options):
    """The transport that the engine bakes."""
    one = bake(scene, settings, **options)
    one.start()
    return one.result().transport


def begun(scene, settings=NOT_SOON):
    """A job whose rays are being cast."""
    one = bake(scene, settings)
    one.start()
    while one.running and not one.done.rays:
        one.wait(0.05)
    assert one.running
    return one


def is_alive(process):
    """Whether a process is there and not dead but for its parent's notice."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] not in "ZX"
    except OSError:
        return False


def until_dead(process, seconds=5.0):
    """How long it lives on."""
    began = time.monotonic()
    while is_alive(process) and time.monotonic() < began + seconds:
        time.sleep(0.005)
    assert not is_alive(process)
    return time.monotonic() - began


def works_again(scene: Scene):
    """The next bake does, in another process."""
    assert all(map(np.array_equal, done(scene), baking.bake(*scene, SETTINGS)))


def program(tmp_path, text):
    """A program to be started in place of the engine."""
    path = tmp_path / "folder with ünicode" / "child.py"
    path.parent.mkdir()
    path.write_text(
        f"import sys\nfrom multiprocessing.connection import Connection\nhandle = Connection(int(sys.argv[1]))\n{text}"
    )
    return path
