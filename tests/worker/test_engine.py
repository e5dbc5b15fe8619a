# SPDX-License-Identifier: GPL-3.0-or-later
"""The engine's process: the same bits as here, and whatever becomes of it is a sentence, after which the next bake works."""

import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from prt_addon.core.bake.run import DEFAULT_RUN
from prt_addon.core.errors import Cancelled, EngineError, MeshError, NoRoom, PRTError
from prt_addon.core.monitor import Work
from prt_addon.core.problem import BakeProblem, BakeSettings
from prt_addon.session import session
from prt_addon.worker import engine, job, tasks
from tests.core import baking, bouncing

SETTINGS = bouncing.SETTINGS
NOT_SOON = replace(SETTINGS, samples=1 << 16)


@pytest.fixture(autouse=True)
def no_engine_is_left():
    """Neither before a test nor after it."""
    job.end_engine()
    yield
    job.end_engine()


@pytest.fixture
def scene():
    return bouncing.corner(8)


def pid():
    """Of the engine that runs."""
    return session.engine.process


def bake(scene, settings=SETTINGS, **options):
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


def tiled(group, times):
    """The same receivers, many times."""
    return replace(group, points=np.tile(group.points, (times, 1)), normals=np.tile(group.normals, (times, 1)))


def unheard(scene, settings):
    """A job with previews that the engine has and Blender has heard nothing of."""
    one = bake(scene, settings, previews=True)
    one.start()
    while not (session.engine._ready and session.engine._sent):
        one.wait(0.001)
    assert one.take_shown() is None
    return one


def spent(process):
    """Processor seconds that it has used so far."""
    ticks = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[11:13]
    return sum(map(int, ticks)) / os.sysconf("SC_CLK_TCK")


def until_dead(process, seconds=5.0):
    """How long it lives on."""
    began = time.monotonic()
    while is_alive(process) and time.monotonic() < began + seconds:
        time.sleep(0.005)
    assert not is_alive(process)
    return time.monotonic() - began


def works_again(scene):
    """The next bake does, in another process."""
    assert all(map(np.array_equal, done(scene), baking.bake(*scene, SETTINGS)))


# --- the same bits ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("threads", [0, 1, 3])
@pytest.mark.parametrize("mode", ["UNSHADOWED", "SHADOWED", "INTERREFLECTED"])
def test_the_bits_are_those_of_a_bake_here(scene, mode, threads):
    """In each mode, on any number of threads."""
    settings = replace(SETTINGS, mode=mode)
    here, there = baking.bake(*scene, settings), done(scene, settings, threads=threads)
    assert len(here) == len(there)
    assert all(one.dtype == other.dtype and np.array_equal(one, other) for one, other in zip(here, there, strict=True))


def test_one_process_serves_many_jobs(scene):
    """One at a time; the second does not wait for Python to start."""
    done(scene)
    first = pid()
    began = time.perf_counter()
    done(scene, replace(SETTINGS, mode="UNSHADOWED"))
    assert pid() == first and time.perf_counter() - began < 0.5
    one = begun(scene)
    with pytest.raises(PRTError, match="A bake is running"):
        bake(scene).start()
    assert job.running_job() is one and pid() == first


def test_findings_come_with_the_number_of_their_group(scene):
    """What is said of a group reaches the one who has the object, though another process said it."""
    groups, occluders = scene
    inside_out = replace(occluders, triangles=occluders.triangles[:, ::-1].copy())
    buried = replace(groups[0], name="Lost", points=groups[0].points * 1e-7, radius=1e-7)
    one = bake(([buried, *groups[1:]], inside_out), replace(SETTINGS, mode="SHADOWED"))
    one.start()
    findings = one.result().findings
    assert {number for number, notice in findings if notice.name == "Lost"} == {0}
    assert all(notice.name.startswith("panel ") == (number > 0) for number, notice in findings)


def test_previews_arrive_before_the_result(scene):
    """In their order, and the result has the bits of one without them."""
    settings, seen = replace(SETTINGS, samples=4096), []
    one = bake(scene, settings, previews=True)
    one.start()
    while one.running:
        one.wait(0.01)
        if shown := one.take_shown():
            assert one.done.rays < one.work.rays and one.take_shown() is None
            seen.append(shown.settings.samples)
    assert seen and seen == sorted(seen) and seen[-1] == 256
    assert all(map(np.array_equal, one.result().transport, baking.bake(*scene, settings)))


def test_a_preview_that_nobody_takes_holds_up_nothing(scene):
    """Blender may be away: the engine works on beside a preview larger than what a pipe holds, and its end arrives whole."""
    groups, occluders = scene
    many = [tiled(groups[0], 400)]
    settings = BakeSettings("SHADOWED", 160)
    one = unheard((many, occluders), settings)
    seconds = [spent(pid())]
    while (
        len(seconds) < 6 or seconds[-1] > seconds[-6]
    ):  # until half a second goes by without work: all is done but its answer
        time.sleep(0.1)
        seconds.append(spent(pid()))
    assert one.running and not one.done.rays
    one.wait()
    assert one.take_shown().samples == 160
    assert all(map(np.array_equal, one.result().transport, baking.bake(many, occluders, settings)))
    assert spent(pid()) - seconds[-1] < 0.2 * (seconds[-1] - seconds[0])


def test_of_previews_that_wait_the_latest_comes(scene):
    """Blender has been away for three of them: it gets the first, which was on its way, and then the third."""
    groups, occluders = scene
    one = unheard(([tiled(groups[0], 200)], occluders), BakeSettings("SHADOWED", 1 << 13))
    begun = spent(pid())
    while spent(pid()) < begun + 4.0:  # the three take one
        time.sleep(0.1)
    seen = []
    while len(seen) < 2:
        one.wait(0.001)
        if shown := one.take_shown():
            seen.append(shown.settings.samples)
    assert one.running and seen == [16, 256]


def test_large_arrays_arrive_whole(scene):
    """Messages of many blocks, there and back."""
    rng = np.random.default_rng(0)
    normals = rng.normal(size=(200_000, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    groups, occluders = scene
    many = [replace(groups[0], points=rng.random((200_000, 3)), normals=normals)]
    settings = BakeSettings("UNSHADOWED")
    [here], [there] = baking.bake(many, occluders, settings), done((many, occluders), settings)
    assert np.array_equal(here, there)


# --- whatever becomes of it -------------------------------------------------------------------------------------------


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
    """Nobody hears of it."""
    done(scene)
    os.kill(pid(), signal.SIGKILL)
    time.sleep(0.1)
    works_again(scene)


def test_errors_of_the_engine_are_its_own_sentences(scene):
    """As they would be raised here, with their class."""
    groups, occluders = scene
    broken = replace(groups[1], points=np.full_like(groups[1].points, np.nan))
    with pytest.raises(MeshError, match="Mesh of 'panel 1' holds NaN"):
        done(([groups[0], broken, *groups[2:]], occluders))
    here = pid()
    assert all(map(np.array_equal, done(scene), baking.bake(*scene, SETTINGS))) and pid() == here


def test_memory_that_runs_out_is_a_sentence(scene):
    """Asked for more than any machine has: the engine says so, and lives."""
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


def program(tmp_path, text):
    """A program to be started in place of the engine."""
    path = tmp_path / "folder with ünicode" / "child.py"
    path.parent.mkdir()
    path.write_text(
        f"import sys\nfrom multiprocessing.connection import Connection\nhandle = Connection(int(sys.argv[1]))\n{text}"
    )
    return path


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
    """It answers nothing, or what nobody understands, or what would be dangerous to understand."""
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


def test_an_engine_that_is_stuck_is_killed_when_cancelled(scene):
    """Stopped by a debugger, or within one call for minutes: cancel takes effect within 0.2 s all the same."""
    times = []
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


def test_a_cancel_leaves_what_is_kept(scene):
    """An engine that answers goes on, and so does what earlier bakes found."""
    done(scene)
    process = pid()
    one = begun(scene, replace(NOT_SOON, seed=1))
    one.cancel()
    with pytest.raises(Cancelled, match="Cancelled; nothing was changed"):
        one.result()
    assert pid() == process
    assert all(map(np.array_equal, done(scene), baking.bake(*scene, SETTINGS)))


def test_killed_at_random_moments(scene):
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


# --- its end ----------------------------------------------------------------------------------------------------------


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
    """Nothing of the person's own Python comes in, and no module of Blender's; BLAS has no threads of its own."""
    one = bake(scene)
    one.start()
    one.result()
    maps = Path(f"/proc/{pid()}/maps").read_text()
    assert "embreex" in maps and "/bpy/" not in maps
    environment = Path(f"/proc/{pid()}/environ").read_bytes()
    assert b"OPENBLAS_NUM_THREADS=1" in environment


def test_how_it_is_carried_out_reaches_it(scene, tmp_path):
    """A bake whose hits have no room in memory or on disk fails there as it would here."""
    one = bake(scene, run=replace(DEFAULT_RUN, memory=0))
    one.start()
    assert all(map(np.array_equal, one.result().transport, baking.bake(*scene, SETTINGS)))


def test_an_answer_counts_though_the_engine_hangs_up_right_after_it(scene, tmp_path, monkeypatch):
    """Both may be there at the same look."""
    text = (
        "import time\nsys.path[:0] = sys.argv[3:]\n"
        "from prt_addon.core.monitor import Work\nfrom prt_addon.worker import channel, serve\n"
        "line = channel.Channel(handle)\nline.post(serve.READY)\nline.flush()\n"
        "line.post(serve.Result('whole', Work()))\nline.flush()"
    )
    root = str(Path(__file__).parents[2])
    with monkeypatch.context() as patch:
        patch.setattr(engine, "_CHILD", program(tmp_path, text.replace("sys.argv[3:]", f"[{root!r}, *sys.argv[3:]]")))
        one = bake(scene)
        one.start()
        until_dead(pid())
        assert one.result() == "whole"
    works_again(scene)
