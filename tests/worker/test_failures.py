# SPDX-License-Identifier: GPL-3.0-or-later
"""Whatever becomes of the engine's process is a sentence, and the next bake works."""

import os
import signal
import sys
import time
from dataclasses import replace

import numpy as np
import pytest

from prt_addon.core.errors import EngineError, MeshError, NoRoom
from prt_addon.core.monitor import Work
from prt_addon.session import session
from prt_addon.worker import engine, job, tasks
from tests.core import baking
from tests.core.bouncing import Scene
from tests.worker.jobs import (
    SETTINGS,
    bake,
    begun,
    done,
    is_alive,
    pid,
    program,
    works_again,
)

ENDS = {
    signal.SIGKILL: "killed by the system, as happens when memory runs out",
    signal.SIGSEGV: r"unexpected end \(exit code -11\)",
    signal.SIGABRT: "unexpected end",
    signal.SIGTERM: "unexpected end",
}


@pytest.mark.parametrize("end", ENDS)
def test_an_engine_that_dies_is_a_sentence(scene, end):
    """A crash of the ray caster ends the bake and nothing else."""
    one = begun(scene)
    os.kill(pid(), end)
    with pytest.raises(EngineError, match=ENDS[end]):
        one.result()
    works_again(scene)


def test_an_engine_that_dies_while_it_waits_is_replaced(scene):
    """The next bake shows nothing of it."""
    done(scene)
    os.kill(pid(), signal.SIGKILL)
    time.sleep(0.1)
    works_again(scene)


def test_errors_of_the_engine_are_its_own_sentences(scene: Scene):
    """As they would be raised here, with their class."""
    groups, occluders = scene
    broken = replace(groups[1], points=np.full_like(groups[1].points, np.nan))
    with pytest.raises(MeshError, match="Mesh of 'panel 1' holds NaN"):
        done(([groups[0], broken, *groups[2:]], occluders))
    here = pid()
    assert all(map(np.array_equal, done(scene), baking.bake(*scene, SETTINGS))) and pid() == here


def test_memory_that_runs_out_is_a_sentence(scene):
    """Given more work than any machine holds: the engine says so, and lives."""
    one = bake(scene, replace(SETTINGS, samples=1 << 45))
    one.start()
    with pytest.raises(NoRoom, match="Memory ran out; nothing was changed"):
        one.result()
    works_again(scene)


def test_a_mistake_of_ours_is_a_sentence(scene):
    """Arguments that no code of ours would send."""
    one = job.Job(tasks.bake, None, work=Work(rays=1))
    one.start()
    with pytest.raises(EngineError, match=r"The engine failed: \w+Error"):
        one.result()
    works_again(scene)


STRANGE = {
    "nothing": ("", "could not be started with Blender's own Python"),
    "a missing module": ("import no_such_module", "could not be started .* No module named 'no_such_module'"),
    "bytes": ("handle.send_bytes(b'hello world')", "could not be read"),
    "no bytes": ("handle.send_bytes(b'')", "could not be read"),
    "a size beyond memory": ("handle.send_bytes(b'\\xff' * 8)", "could not be read"),
    "half a message": ("handle.send_bytes(b'\\x08' + bytes(7)); handle.send_bytes(b'123')", "could not be started"),
    "too long a block": ("handle.send_bytes(b'\\x08' + bytes(7)); handle.send_bytes(bytes(9))", "could not be read"),
    "another first word": (
        "import pickle, struct; p = pickle.dumps('hello'); handle.send_bytes(struct.pack('<Q', len(p))); "
        "handle.send_bytes(p); handle.poll(None)",
        "does not begin as the engine does",
    ),
    "a call": (
        "import os, pickle, struct\nclass Call:\n    def __reduce__(self): return os.system, ('touch called',)\n"
        "p = pickle.dumps(Call()); handle.send_bytes(struct.pack('<Q', len(p))); handle.send_bytes(p); handle.poll(None)",
        "has no place in a message",
    ),
}


@pytest.mark.parametrize("strange", STRANGE)
def test_whatever_is_no_engine_is_a_sentence(scene, tmp_path, monkeypatch, strange):
    """It answers nothing, or what is no message, or what would be dangerous to load."""
    monkeypatch.chdir(tmp_path)
    text, sentence = STRANGE[strange]
    with monkeypatch.context() as patch:
        patch.setattr(engine, "_CHILD", program(tmp_path, text))
        one = bake(scene)
        one.start()
        with pytest.raises(EngineError, match=sentence):
            one.result()
    assert not (tmp_path / "called").exists() and job.running_job() is None
    works_again(scene)


def test_a_python_that_is_not_there_is_a_sentence(scene, monkeypatch):
    """And leaves nothing behind that would refuse the next bake."""
    with monkeypatch.context() as patch:
        patch.setattr(sys, "executable", "/no/such/python")
        with pytest.raises(EngineError, match=r"could not be started .*'/no/such/python': No such file"):
            bake(scene).start()
    assert job.running_job() is None
    works_again(scene)


def test_killed_at_random_moments(scene: Scene):
    """While it starts, reads, casts, bounces, answers: each is a sentence or a whole result, and never harms the next."""
    expected = baking.bake(*scene, SETTINGS)
    rng = np.random.default_rng(int(os.environ.get("PRT_KILLS_SEED", 0)))
    kills = int(os.environ.get("PRT_KILLS", 20))
    ended = 0
    for _ in range(kills):
        one = bake(scene)
        one.start()
        one.wait(rng.uniform(0.0, 0.3))
        killed = pid() if session.engine else 0
        if killed:
            os.kill(killed, signal.SIGKILL)
        try:
            assert all(map(np.array_equal, one.result().transport, expected))
        except EngineError as error:
            ended += 1
            assert "Nothing was changed" in str(error) or "could not be started" in str(error)
        assert job.running_job() is None
        while killed and is_alive(killed):  # a result may be there before the signal is
            time.sleep(0.001)
    assert ended > kills // 4
    works_again(scene)
