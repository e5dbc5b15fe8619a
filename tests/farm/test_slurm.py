# SPDX-License-Identifier: GPL-3.0-or-later
"""The scripts for Slurm run on a real one, of this machine alone: `make farm` starts it, and stops it afterwards."""

import os
import shutil
import signal
import subprocess
import time
from pathlib import Path

import pytest

from tests.farm.machines import digest_of, launcher, plain_digest

SUBMIT = Path(__file__).resolve().parents[2] / "farm" / "slurm" / "submit.sh"

pytestmark = pytest.mark.once


def submitted(*arguments, **environment):
    return subprocess.run([SUBMIT, *map(str, arguments)], env=os.environ | environment, capture_output=True, text=True)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["scene.blend"], "FILE.blend OUTPUT.blend SHARDS"),
        (["none.blend", "out.blend", "4"], "no file"),
        (["scene.blend", "scene.blend", "4"], "another file"),
        (["scene.blend", "out.blend", "0"], "1 or more"),
        (["scene.blend", "out.blend", "many"], "1 or more"),
    ],
)
def test_what_cannot_be_submitted_is_a_sentence(tmp_path, monkeypatch, arguments, said):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scene.blend").touch()
    answer = submitted(*arguments)
    assert answer.returncode == 2 and said in answer.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["scene.blend"]


def queued(job):
    """How a job's tasks are doing."""
    answer = subprocess.run(["squeue", "-h", "-r", "-j", job, "-o", "%T %r"], capture_output=True, text=True)
    return answer.stdout.split("\n")[:-1]


def wait_for(condition, what):
    until = time.monotonic() + 240.0
    while not condition():
        assert time.monotonic() < until, f"waited in vain for {what}"
        time.sleep(0.05)


@pytest.mark.skipif(not shutil.which("sbatch") or not os.environ.get("SLURM_CONF"), reason="make farm starts a Slurm")
def test_a_killed_task_is_done_again_and_merges_to_the_plain_bake(blender, scene, stage, blend, tmp_path):
    """Blender dies in one shard; Slurm requeues it; the merge waits; the bits are those of a bake."""
    output, shards = tmp_path / "result.blend", tmp_path / "result.blend.shards"
    answer = submitted(blend, output, 4, PRT_BLENDER=str(launcher(tmp_path)), PRT_SETTINGS="samples=64")
    assert answer.returncode == 0, answer.stderr
    array, merge = answer.stdout.split()
    log = shards / "shard-1.log"
    wait_for(lambda: log.exists() and "Read blend" in log.read_text(), "the second shard to begin")
    [process] = [
        int(path.name)
        for path in Path("/proc").iterdir()
        if path.name.isdigit()
        and b"index=1" in path.joinpath("cmdline").read_bytes()
        and path.joinpath("cmdline").read_bytes().split(b"\0")[1].endswith(b"background_blender.py")
    ]
    os.kill(process, signal.SIGKILL)
    wait_for(lambda: not queued(array) and not queued(merge), "the jobs to end")
    assert "Blender ended with 137" in log.read_text() and log.read_text().count('Read blend: "') == 2
    assert output.exists(), (shards / "merge.log").read_text()
    assert digest_of(blender, stage, output) == plain_digest(blender, stage, blend, samples=64)
