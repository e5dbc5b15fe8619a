# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures how a bake in shards grows with the scene: seconds, memory and disk of reading, one shard, all shards and the merge.

    python tools/bench/scale.py RECEIVERS [--samples 16] [--shards 16] [--mode INTERREFLECTED]

Prints JSON. Every shard runs here, one after the other, and the merge; the engine ends between them, as on a farm.
"""

from __future__ import annotations

import argparse
import importlib
import json
import resource
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]


def main() -> None:
    """Bake as the command line says."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("receivers", type=int)
    parser.add_argument("--samples", type=int, default=16)
    parser.add_argument("--shards", type=int, default=16)
    parser.add_argument("--mode", default="INTERREFLECTED")
    given = parser.parse_args()
    sys.path[:0] = [str(ROOT), str(ROOT / "tools")]
    import headless

    headless.enable_extension()
    try:
        print(json.dumps(grown(given.receivers, given.samples, given.shards, given.mode)))
    finally:
        headless.disable_extension()


def grown(receivers: int, samples: int, shards: int, mode: str) -> dict[str, Any]:
    """Seconds of a shard (the dearest) and of the merge, GiB at the peak of Blender and of the engine, GiB of shards."""
    import blender_scene
    from headless import bpy

    blender_scene.court(receivers)
    scene = resident("self")
    settings = {"mode": mode, "samples": samples, "bounces": 1}
    with tempfile.TemporaryDirectory() as folder:
        slowest, engine = 0.0, 0.0
        for index in range(shards):
            begun = time.monotonic()
            bpy.ops.prt.bake_shard(index=index, count=shards, directory=folder, **settings)
            slowest, engine = max(slowest, time.monotonic() - begun), max(engine, end_engine())
        disk = sum(path.stat().st_size for path in Path(folder).iterdir()) / 2**30
        blender = peak()
        begun = time.monotonic()
        bpy.ops.prt.merge_shards(directory=folder, update_light=False, update_shading=False, **settings)
        merging, merge_engine = time.monotonic() - begun, end_engine()
    return {
        "receivers": receivers,
        "scene_gib": scene,
        "shard_seconds": slowest,
        "shard_blender_gib": blender,
        "shard_engine_gib": engine,
        "disk_gib": disk,
        "merge_seconds": merging,
        "merge_blender_gib": peak(),
        "merge_engine_gib": merge_engine,
    }


def end_engine() -> float:
    """End the engine; GiB resident at its peak."""
    import headless

    session = importlib.import_module(f"{headless.PACKAGE}.prt_addon.session").session
    found = resident(session.engine.process, "VmHWM") if session.engine else 0.0
    importlib.import_module(f"{headless.PACKAGE}.prt_addon.worker.job").end_engine()
    return found


def peak() -> float:
    """GiB resident at this process's peak."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20


def resident(process: int | str, what: str = "VmRSS") -> float:
    """GiB resident of a process, or at its peak (`VmHWM`)."""
    status = Path(f"/proc/{process}/status").read_text().split("\n")
    return int(next(line for line in status if line.startswith(what)).split()[1]) / 2**20


if __name__ == "__main__":
    main()
