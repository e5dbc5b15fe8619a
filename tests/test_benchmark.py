# SPDX-License-Identifier: GPL-3.0-or-later
"""The quick benchmark shows that nothing became twice as slow or large. Bounds are generous: other work may run."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.once

TOOL = Path(__file__).parent.parent / "tools" / "bench"


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """All results, and the table under `table`. In a process of its own: it enables the extension itself."""
    folder = tmp_path_factory.mktemp("bench")
    line = [sys.executable, TOOL, "--quick", "--output", folder]
    done = subprocess.run(line, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    assert done.returncode == 0, done.stdout
    return {**json.loads((folder / "results.json").read_text()), "table": (folder / "benchmark.md").read_text()}


@pytest.mark.parametrize(("mode", "limit"), [("SHADOWED", 2.0), ("INTERREFLECTED", 2.4)])
def test_bake_is_mostly_its_rays(results, mode, limit):
    """In processor seconds, over the same rays handed to the ray caster alone; and with the start of the engine's process,
    which is half as long as these few rays."""
    result = results[f"over_its_rays {mode}"]
    assert 0.95 < result["ratio_here"]["cpu"] < limit
    assert result["ratio_here"]["cpu"] - 0.3 < result["ratio"]["cpu"] < limit + 1.0
    assert result["ratio_here"]["cpu"] < result["ratio_mended"]["cpu"] < limit + 1.5


def test_engine_starts_quickly(results):
    """Measured: 0.2 s on an idle machine; and an engine that runs answers at once."""
    assert results["engine_start"]["first"] < 2.0
    assert results["engine_start"]["again"] < 0.1


def test_bounces_are_cheap(results):
    """Three of them, beside the rays; those after the first read a quarter of the hits."""
    none, one, *_, three = (share["cpu"] for share in results["each_bounce"]["shares"])
    assert none < one
    assert three - none < min(0.5, 2.5 * (one - none))


def test_plain_estimator_needs_many_more_rays(results):
    """At the same error, which it must really have reached."""
    result = results["against_uniform"]
    assert result["uniform_error"] == pytest.approx(result["error"], rel=0.25)
    assert result["uniform_samples"] > 10 * result["samples"]
    assert result["ratio"]["cpu"] > 10


def test_time_grows_with_the_rays_alone(results):
    """Beside what the ray caster itself does on larger scenes."""
    for by in ("receivers", "samples"):
        result = results[f"growth {by}"]
        assert result["exponent"] < result["rays_exponent"] + 0.3


def test_memory(results):
    """Beyond the mesh and its result, which at this size are 12 MiB."""
    shadowed, bounced = (results[f"memory core {mode}"] for mode in ("SHADOWED", "INTERREFLECTED"))
    assert shadowed["beyond"] < 150 << 20
    assert bounced["beyond"] < 300 << 20
    assert bounced["hits_per_receiver"] <= 8 * 16 + 9


def test_open_receivers(results):
    """Millions per core and second."""
    assert results["open_receivers"]["per_core_second"] > 2e6


def test_blender_is_read_and_written_quickly(results):
    """A small share even of a bake with half the usual rays."""
    assert results["blender SHADOWED"]["ratio"]["cpu"] < 0.15


def test_a_picture_is_there_long_before_the_end(results):
    """And what comes before it makes the bake little longer."""
    result = results["first_picture 20000"]
    assert result["first"] < 0.8 * result["last"]
    assert results["previews"]["ratio"]["cpu"] < 1.3


def test_table_names_every_target(results):
    """One row at least for each number that is wanted."""
    for wanted in ("<= 1.22", "<= 1.40", "<= 1.05", "<= 600 MiB", "<= 3%", ">= 5 million/s", "<= 1.10", "<= 1 s"):
        assert wanted in results["table"]
