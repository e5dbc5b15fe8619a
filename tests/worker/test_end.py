# SPDX-License-Identifier: GPL-3.0-or-later
"""The engine's process ends when it is cancelled, idle or orphaned, and runs nothing but the engine until then."""

import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from prt_addon.core.errors import Cancelled
from prt_addon.session import session
from prt_addon.worker import engine
from tests.core import baking
from tests.core.bouncing import Scene
from tests.worker.jobs import (
    NOT_SOON,
    SETTINGS,
    bake,
    begun,
    done,
    is_alive,
    pid,
    program,
    until_dead,
    works_again,
)


def test_an_engine_that_is_stuck_is_killed_when_cancelled(scene):
    """Stopped by a debugger, or within one call for minutes: cancel takes effect within 0.2 s all the same."""
    times: list[float] = []
    while len(times) < 5 and min(times, default=1.0) > 0.2:  # a busy machine makes single ones long
        one = begun(scene)
        process = pid()
        os.kill(process, signal.SIGSTOP)
        began = time.perf_counter()
        one.cancel()
        one.wait()
        times.append(time.perf_counter() - began)
        assert not is_alive(process)
        with pytest.raises(Cancelled):
            one.result()
    assert min(times) < 0.2
    works_again(scene)


def test_a_cancel_leaves_what_is_kept(scene: Scene):
    """An engine that answers goes on, and so does what earlier bakes found."""
    done(scene)
    process = pid()
    one = begun(scene, replace(NOT_SOON, seed=1))
    one.cancel()
    with pytest.raises(Cancelled, match="Cancelled; nothing was changed"):
        one.result()
    assert pid() == process
    assert all(map(np.array_equal, done(scene), baking.bake(*scene, SETTINGS)))


def test_it_ends_when_nobody_asks(scene):
    """After the time that the last job gave it; a bake that comes then gets another one."""
    done(scene, patience=1.5)
    process = pid()
    assert is_alive(process)
    time.sleep(0.7)  # too close to its end to be given work
    works_again(scene)
    assert pid() != process
    until_dead(process)
    done(scene, patience=0.0)
    assert session.engine is None


PARENT = """
import os, sys, time
sys.path.insert(0, {root!r})
from dataclasses import replace
from tests.core import bouncing
from prt_addon.core.problem import BakeProblem
from prt_addon.session import session
from prt_addon.worker import job
settings = replace(bouncing.SETTINGS, samples={samples})
one = job.bake_job(BakeProblem.of(*bouncing.corner(8), settings))
one.start()
one.wait({seconds})
print(session.engine.process, flush=True)
time.sleep(60)
"""


@pytest.mark.parametrize("samples", [16, 1 << 16], ids=["idle", "busy"])
def test_it_ends_with_blender(samples):
    """Also when that is killed, whether it has work or not."""
    root = str(Path(__file__).parents[2])
    code = PARENT.format(root=root, samples=samples, seconds=1.0)
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as parent:
        process = int(parent.stdout.readline())
        assert is_alive(process)
        parent.kill()
    assert until_dead(process) < 1.0


def test_it_runs_the_engine_alone(scene, tmp_path):
    """Nothing of the user's own Python comes in, and no module of Blender's; BLAS has no threads of its own."""
    one = bake(scene)
    one.start()
    one.result()
    maps = Path(f"/proc/{pid()}/maps").read_text()
    assert "embreex" in maps and "/bpy/" not in maps
    environment = Path(f"/proc/{pid()}/environ").read_bytes()
    assert b"OPENBLAS_NUM_THREADS=1" in environment


def test_an_answer_counts_though_the_engine_hangs_up_right_after_it(scene, tmp_path, monkeypatch):
    """Both may be there at the same look."""
    text = (
        "import time\nsys.path[:0] = sys.argv[3:]\n"
        "from prt_addon.core.monitor import Work\nfrom prt_addon.worker import channel, serve\n"
        "line = channel.Channel(handle)\nline.post(serve.READY)\nline.flush()\n"
        "line.post(serve.Success('whole', Work()))\nline.flush()"
    )
    root = str(Path(__file__).parents[2])
    with monkeypatch.context() as patch:
        patch.setattr(engine, "_CHILD", program(tmp_path, text.replace("sys.argv[3:]", f"[{root!r}, *sys.argv[3:]]")))
        one = bake(scene)
        one.start()
        until_dead(pid())
        assert one.result() == "whole"
    works_again(scene)
