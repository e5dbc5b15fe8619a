# SPDX-License-Identifier: GPL-3.0-or-later
"""The Flamenco job type compiles on a host that is as strict as Flamenco, and its command lines really run.

No Flamenco Manager or Worker takes part: see docs/farm.md.
"""

import json
import shutil
import subprocess
from pathlib import Path

import pytest

from tests.farm.machines import digest_of, killed_at_work, launcher, plain_digest, run

pytestmark = pytest.mark.once

HERE = Path(__file__).resolve().parent
SCRIPT = HERE.parents[1] / "farm" / "flamenco" / "prt_bake.js"
SETTINGS = {
    "shards": 3,
    "mode": "INTERREFLECTED",
    "samples": 48,
    "blendfile": "/storage/my job.blend",
    "shard_root": "/storage/shards",
    "output_blend": "/storage/my job_prt.blend",
}


def compiled(script, settings=None, variables=None):
    """What the host makes of a job type and the settings of a job."""
    node = shutil.which("node")
    assert node, "these tests run the job type in Node: install it (apt-get install nodejs)"
    job = {"script": str(script), "settings": settings, "variables": variables}
    answer = subprocess.run([node, HERE / "host.mjs"], input=json.dumps(job), capture_output=True, text=True)
    if answer.returncode:
        raise ValueError(answer.stderr)
    return json.loads(answer.stdout)


def test_a_job_is_its_shards_and_then_a_merge():
    """The merge waits for all shards, which wait for nothing; each is one Blender with the job's file."""
    *shards, merge = compiled(SCRIPT, SETTINGS)["tasks"]
    assert [task["name"] for task in shards] == ["shard-0-of-3", "shard-1-of-3", "shard-2-of-3"]
    assert all(not task["dependencies"] for task in shards) and merge["dependencies"] == [0, 1, 2]
    for task in (*shards, merge):
        [command] = task["commands"]
        assert (task["type"], command["name"]) == ("blender", "blender-render")
        line = command["line"]
        assert line[:2] == ["{blender}", "{blenderArgs}"] and SETTINGS["blendfile"] in line
        assert line.index("--python-exit-code") < line.index("--python-expr") < line.index("--")
        assert "/storage/shards/my job-2026-01-02_030405" in line[line.index("--") :]


def test_numbers_travel_whole():
    """What Python reads is what the user set."""
    settings = {**SETTINGS, "shards": 1, "bounces": 7, "tolerance": 0.00125, "seed": 2**31 - 1, "samples": 1 << 17}
    for task in compiled(SCRIPT, settings)["tasks"]:
        [code] = [argument for argument in task["commands"][0]["line"] if "bpy.ops.prt" in argument]
        assert "samples=131072, bounces=7, tolerance=0.00125, seed=2147483647" in code


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"shards": 0}, "shards"),
        ({"mode": "UNSHADOWED"}, "mode"),
        ({"samples": 2.5}, "samples"),
        ({"output_blend": SETTINGS["blendfile"]}, "another file"),
        ({"output_blend": ""}, "output_blend"),
        ({"frames": "1-10"}, "no setting 'frames'"),
    ],
)
def test_jobs_that_cannot_be_are_refused(change, said):
    with pytest.raises(ValueError, match=said):
        compiled(SCRIPT, {**SETTINGS, **change})


TASK = 'const task = author.Task("one", "misc");'
ECHO = 'task.addCommand(author.Command("echo", { message: "hello" }));'


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ("", "no tasks"),
        (f"{TASK} job.addTask(task);", "no commands"),
        (f"{TASK} job.addTask(task); {ECHO}", "no commands"),
        (f'{TASK} task.addCommand(author.Command("rename", {{}})); job.addTask(task);', "no command 'rename'"),
        (f'{TASK} task.addCommand(author.Command("echo", {{ text: "" }})); job.addTask(task);', "no parameter 'text'"),
        (f'{TASK} task.addCommand(author.Command("echo", {{}})); job.addTask(task);', "parameter 'message'"),
        (f'{TASK} {ECHO} task.addDependency(author.Task("two", "misc")); job.addTask(task);', "not in the job"),
        (f"{TASK} {ECHO} task.addDependency(task); job.addTask(task);", "waits for itself"),
        (f"{TASK} {ECHO} undeclared = 1; job.addTask(task);", "undeclared"),
        (f'{TASK} {ECHO} require("fs"); job.addTask(task);', "require"),
    ],
)
def test_the_host_refuses_what_flamenco_would(tmp_path, body, said):
    """A host that takes everything would prove nothing."""
    script = tmp_path / "job.js"
    script.write_text(f'const JOB_TYPE = {{ label: "Job", settings: [] }}; function compileJob(job) {{ {body} }}')
    with pytest.raises(ValueError, match=said):
        compiled(script, {})


def evaluated_settings(bpy):
    """The settings of a job as Flamenco's add-on finds them: expressions are evaluated in Blender, with these names."""
    names = {"bpy": bpy, "C": bpy.context, "Path": Path, "jobname": "job"}
    found = {}
    for setting in compiled(SCRIPT)["jobType"]["settings"]:
        if "eval" in setting:
            found[setting["key"]] = eval(setting["eval"], {}, names)
    return found


def test_the_command_lines_of_a_job_merge_to_the_plain_bake(blender, scene, stage, blend, tmp_path):
    """Run as processes: one shard twice, one killed and done again, the merge too early, killed, and then twice."""
    settings = {**evaluated_settings(blender), "shards": 3, "blendfile": str(blend)}
    assert Path(settings["output_blend"]) == blend.with_name("my scene_prt.blend")
    assert (settings["samples"], settings["bounces"], settings["seed"]) == (48, 2, 5)
    untouched = blend.read_bytes()
    tasks = compiled(SCRIPT, settings, {"blender": str(launcher(tmp_path)), "blenderArgs": "-b -y"})["tasks"]
    first, second, third, merge = (task["commands"][0]["line"] for task in tasks)
    output = Path(settings["output_blend"])

    run(first)
    killed_at_work(second)
    answer = subprocess.run(merge, capture_output=True, text=True)
    assert answer.returncode == 1 and "missing or unfinished: 1, 2" in answer.stdout + answer.stderr
    assert not output.exists()
    run(third)
    run(first)
    run(second)
    killed_at_work(merge)
    run(merge)
    run(merge)
    assert blend.read_bytes() == untouched

    merged = digest_of(blender, stage, output)
    assert merged == plain_digest(blender, stage, blend)
