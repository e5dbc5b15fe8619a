# SPDX-License-Identifier: GPL-3.0-or-later
"""`prt.bake_shard(estimate=True)`: nothing is written, and what it says comes true."""

import re
from pathlib import Path

import pytest

OPTIONS = {"mode": "INTERREFLECTED", "samples": 64, "bounces": 2, "count": 3}


@pytest.fixture
def room(blender, scene, stage):
    """A floor with a ball over it, and a box that is baked for itself."""
    stage.environment(stage.picture("Sky", stage.six_coloured_sky(16)))
    stage.object_of("Floor", stage.grid(60, 2.0), stage.diffuse("Grey", (0.7, 0.7, 0.7)))
    stage.object_of("Ball", stage.icosphere(5, 0.8), stage.diffuse("Red", (0.9, 0.1, 0.1)), (0, 0, 0.9))
    stage.object_of("Moving", stage.cube(), stage.diffuse("Blue"), (2, 0, 2)).prt.space = "OBJECT"


def said(capfd):
    return capfd.readouterr().out


def test_it_writes_nothing(blender, scene, stage, room, tmp_path, capfd):
    before = stage.baked_bytes(scene)
    assert blender.ops.prt.bake_shard(estimate=True, directory=str(tmp_path), **OPTIONS) == {"FINISHED"}
    assert blender.ops.prt.bake_shard(estimate=True, **OPTIONS) == {"FINISHED"}, "no folder is needed"
    assert not list(tmp_path.iterdir()) and stage.baked_bytes(scene) == before
    assert "The folder will hold" in said(capfd)


def test_its_counts_are_those_of_the_shards(blender, part, scene, room, tmp_path, capfd):
    """Receivers and rays exactly, the disk within a fifth."""
    blender.ops.prt.bake_shard(estimate=True, **OPTIONS)
    lines = said(capfd)
    receivers, rays = (
        int(number.replace(",", "")) for number in re.search(r"of ([\d,]+) rec.*?, ([\d,]+) rays", lines).groups()
    )
    disk = int(re.search(r"will hold (\d+) MiB", lines)[1])
    for index in range(3):
        blender.ops.prt.bake_shard(index=index, directory=str(tmp_path), **OPTIONS)
    done = [int(number.replace(",", "")) for number in re.findall(r"of 3, ([\d,]+) rays", said(capfd))]
    assert max(done) == rays == 64 * receivers
    real = sum(path.stat().st_size for path in tmp_path.iterdir()) / 2**20
    assert disk == pytest.approx(real, rel=0.2, abs=1.0)


def test_memory_is_right_within_a_third(part, blender, scene, stage, room):
    """Of the engine, in which a larger scene was read and probed."""
    stage.object_of("Large", stage.icosphere(8, 3.0), stage.diffuse("Large"), (9, 0, 0))
    settings = part("problem").BakeSettings("INTERREFLECTED", 16)
    plan = part("read").read_bake(blender.context, list(scene.objects), settings)
    job = part("job").Job(part("tasks").estimate, plan.problem, 1, work=part("monitor").Work(1 << 20))
    job.start()
    found = job.result()
    engine = part("session").session.engine.process
    status = Path(f"/proc/{engine}/status").read_text()
    peak = int(re.search(r"VmHWM:\s+(\d+)", status)[1]) << 10
    assert found.memory == pytest.approx(peak, rel=0.33)
    assert found.casting > 0 and found.preparing > 0 and found.merging > 0


def test_what_cannot_be_estimated_is_a_sentence(blender, room):
    with pytest.raises(RuntimeError, match="needs no rays"):
        blender.ops.prt.bake_shard(estimate=True, mode="UNSHADOWED")
    with pytest.raises(RuntimeError, match="no shard 3 of 3"):
        blender.ops.prt.bake_shard(estimate=True, **{**OPTIONS, "index": 3})
