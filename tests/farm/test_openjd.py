# SPDX-License-Identifier: GPL-3.0-or-later
"""The Open Job Description template is valid, and the reference runner runs it whole, with a shard that is killed."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.farm.machines import digest_of, launcher, plain_digest

pytestmark = pytest.mark.once

TEMPLATE = Path(__file__).resolve().parents[2] / "farm" / "openjd" / "prt_bake.yaml"
OPENJD = Path(sys.executable).with_name("openjd")


def job(tmp_path, blend, **parameters):
    """The command that runs all of a job on this machine."""
    executable = launcher(tmp_path)
    given = {"BlendFile": blend, "ShardFolder": tmp_path / "shards", "OutputBlend": tmp_path / "result.blend"}
    given |= {"Shards": 3, "Blender": executable, **parameters}
    named = [part for name, value in given.items() for part in ("-p", f"{name}={value}")]
    return [str(OPENJD), "run", str(TEMPLATE), "--step", "Merge", "--run-dependencies", *named]


def test_the_template_is_valid():
    answer = subprocess.run([OPENJD, "check", TEMPLATE], capture_output=True, text=True)
    assert answer.returncode == 0 and "passes validation" in answer.stdout, answer.stdout


@pytest.mark.parametrize(
    ("name", "value"), [("Shards", 0), ("Transport", "UNSHADOWED"), ("Bounces", 101), ("Samples", 131073)]
)
def test_jobs_that_cannot_be_are_refused(tmp_path, blend, name, value):
    """Before anything runs."""
    answer = subprocess.run(job(tmp_path, blend, **{name: value}), capture_output=True, text=True)
    assert answer.returncode and name in answer.stdout and not (tmp_path / "shards").exists()


def test_a_job_with_a_killed_shard_is_run_anew_to_the_plain_bake(blender, scene, stage, blend, tmp_path):
    """The second shard dies half way, and its job with it; once more over the same folder, the bits are those of a bake.

    Samples are the job's, everything else is the file's.
    """
    untouched, log = blend.read_bytes(), tmp_path / "log.txt"
    line = job(tmp_path, blend, Samples=64)
    with log.open("w") as output:
        running = subprocess.Popen(line, stdout=output, stderr=subprocess.STDOUT)
    until = time.monotonic() + 120.0
    while log.read_text().count("Read blend") < 2:
        assert running.poll() is None and time.monotonic() < until, log.read_text()
        time.sleep(0.02)
    os.kill(int((tmp_path / "blenders.txt").read_text().split()[-1]), signal.SIGKILL)
    assert running.wait(120.0) != 0 and not (tmp_path / "result.blend").exists()
    answer = subprocess.run(line, capture_output=True, text=True)
    assert answer.returncode == 0, answer.stdout
    assert blend.read_bytes() == untouched
    assert digest_of(blender, stage, tmp_path / "result.blend") == plain_digest(blender, stage, blend, samples=64)
