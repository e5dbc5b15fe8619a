# SPDX-License-Identifier: GPL-3.0-or-later
"""The engine's process gives the bits of a bake here, in every mode, on any number of threads, of any size."""

import time
from dataclasses import replace

import numpy as np
import pytest

from prt_addon.core.bake.run import DEFAULT_RUN
from prt_addon.core.errors import PRTError
from prt_addon.core.problem import BakeSettings
from prt_addon.worker import job
from tests.core import baking
from tests.core.bouncing import Scene
from tests.worker.jobs import SETTINGS, bake, begun, done, pid


@pytest.mark.parametrize("threads", [0, 1, 3])
@pytest.mark.parametrize("mode", ["UNSHADOWED", "SHADOWED", "INTERREFLECTED"])
def test_the_bits_are_those_of_a_bake_here(scene: Scene, mode, threads):
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


def test_how_it_is_carried_out_reaches_it(scene: Scene, tmp_path):
    """A bake whose hits have no room in memory or on disk fails there as it would here."""
    one = bake(scene, run=replace(DEFAULT_RUN, memory=0))
    one.start()
    assert all(map(np.array_equal, one.result().transport, baking.bake(*scene, SETTINGS)))
