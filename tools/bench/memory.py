# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures the memory of one bake, in a process of its own.

    python tools/bench/memory.py core|operator MODE RECEIVERS SAMPLES

Prints JSON: bytes resident at the peak of the bake, bytes that it took beyond what was there before and its result, and
for interreflection the bytes of kept hits per receiver.
"""

from __future__ import annotations

import json
import resource
import sys
from pathlib import Path
from typing import cast

ROOT = Path(__file__).resolve().parents[2]


def main() -> None:
    """Bake as the command line says."""
    how, mode, receivers, samples = sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4])
    sys.path[:0] = [str(ROOT), str(ROOT / "tools")]
    found = {"core": bake_in_core, "operator": bake_in_blender}[how](mode, receivers, samples)
    print(json.dumps({"how": how, "mode": mode, "samples": samples, **found}))


def bake_in_core(mode: str, receivers: int, samples: int) -> dict[str, float]:
    """`core.bake` on arrays."""
    import scenes

    from prt_addon.core.bake.bake import bake, bounce
    from prt_addon.core.bake.trace import trace_island
    from prt_addon.core.problem import BakeProblem, BakeSettings, Mode

    groups, occluders = scenes.bake_input(scenes.court(receivers))
    before = resident()
    reset_peak()
    settings = BakeSettings(cast(Mode, mode), samples)
    problem = BakeProblem.of(groups, occluders, settings)
    per_receiver = 0.0
    if mode == "INTERREFLECTED":
        traced = trace_island(problem.islands[0], settings)
        results = bounce(traced, occluders, settings)
        per_receiver = traced.hits.nbytes / len(traced.hits)
    else:
        results = bake(problem).transport
    beyond = peak() - before - sum(result.nbytes for result in results)
    return {"receivers": problem.receivers, "peak": peak(), "beyond": beyond, "hits_per_receiver": per_receiver}


def bake_in_blender(mode: str, receivers: int, samples: int) -> dict[str, float]:
    """The operator, on a mesh in Blender: the peaks of its process and of the engine's, together."""
    import importlib

    import blender_scene
    import headless

    headless.enable_extension()
    try:
        with headless.quiet():
            objects = blender_scene.court(receivers)
            count = sum(len(ob.data.vertices) for ob in objects)
            before = resident()
            reset_peak()
            headless.bpy.ops.prt.bake(mode=mode, samples=samples, update_light=False, update_shading=False)
        engine = importlib.import_module(f"{headless.PACKAGE}.prt_addon.session").session.engine.process
        most = peak() + _status("VmHWM", str(engine))
        return {
            "receivers": count,
            "peak": most,
            "beyond": most - before - 9 * 4 * 4 * count,
            "hits_per_receiver": 0.0,
        }
    finally:
        headless.disable_extension()


def resident() -> int:
    """Bytes of memory the process has now; its peak where the system does not say."""
    return _status("VmRSS") or _largest()


def peak() -> int:
    """The most it had, since `reset_peak` where the system can."""
    return _status("VmHWM") or _largest()


def reset_peak() -> None:
    """Forget the peak of what went before (Linux)."""
    switch = Path("/proc/self/clear_refs")
    if switch.exists():
        switch.write_text("5")


def _largest() -> int:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)


def _status(key: str, process: str = "self") -> int:
    status = Path(f"/proc/{process}/status")
    if not status.exists():
        return 0
    line = next(line for line in status.read_text().splitlines() if line.startswith(key))
    return int(line.split()[1]) * 1024


if __name__ == "__main__":
    main()
