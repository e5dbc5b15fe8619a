# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures how fast the engine is, how large, and how it grows: all experiments in one run.

    python tools/bench [--quick] [--output FOLDER] [--page FILE]

Writes results.json, the table and pictures of the curves into the folder (build/bench).
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT), str(ROOT / "tools")]

import experiments as run  # noqa: E402 - these need the path
import report  # noqa: E402

from prt_addon.core.problem import Mode  # noqa: E402

MODES: tuple[Mode, ...] = ("SHADOWED", "INTERREFLECTED")
MEMORY: tuple[tuple[str, Mode], ...] = (("core", "SHADOWED"), ("operator", "SHADOWED"), ("core", "INTERREFLECTED"))

Experiment = tuple[str, Callable[[], run.Result]]


def whole() -> Iterator[Experiment]:
    """A quarter of an hour on two cores."""
    for mode in MODES:
        yield f"over_its_rays {mode}", partial(run.over_its_rays, mode, 100_000, 256, 3)
    yield "engine_start", lambda: run.engine_start(9)
    yield "each_bounce", lambda: run.each_bounce(100_000, 128, 6, 3)
    yield "against_uniform", lambda: run.against_uniform(2_000, 64)
    sizes = (10_000, 31_600, 100_000, 316_000, 1_000_000)
    yield "growth receivers", lambda: run.growth("SHADOWED", [(size, 16) for size in sizes], 2)
    yield "growth bounced", lambda: run.growth("INTERREFLECTED", [(size, 16) for size in sizes], 1)
    yield "growth samples", lambda: run.growth("SHADOWED", [(20_000, 4**k) for k in range(2, 6)], 2)
    yield "open_receivers", lambda: run.open_receivers(1_000_000, 5)
    for how, mode in MEMORY:
        yield f"memory {how} {mode}", partial(run.memory, how, mode, 1_000_000, 64)
    for mode in MODES:
        yield f"blender {mode}", partial(run.blender_share, mode, 100_000, 256, 2)
    yield "previews", lambda: run.previews("INTERREFLECTED", 100_000, 256, 3)
    for size in (10_000, 100_000, 1_000_000):
        yield f"first_picture {size}", partial(run.first_picture, size, 3 if size < 1_000_000 else 1)
    for lamps in (0, 1, 4):
        yield f"eevee_frames {lamps}", partial(run.eevee_frames, lamps, 5)
    for lamps in (0, 1):
        yield f"first_frames {lamps}", partial(run.first_frames, lamps, 2)
    yield "page_frames", lambda: run.page_frames(100_000)


def quick() -> Iterator[Experiment]:
    """A minute: enough to see that nothing became twice as slow or large."""
    for mode in MODES:
        yield f"over_its_rays {mode}", partial(run.over_its_rays, mode, 20_000, 128, 3)
    yield "engine_start", lambda: run.engine_start(3)
    yield "each_bounce", lambda: run.each_bounce(10_000, 128, 3, 3)
    yield "against_uniform", lambda: run.against_uniform(400, 32)
    sizes = (4_000, 16_000, 64_000)
    yield "growth receivers", lambda: run.growth("SHADOWED", [(size, 16) for size in sizes], 2)
    yield "growth samples", lambda: run.growth("SHADOWED", [(4_000, 4**k) for k in range(2, 5)], 2)
    yield "open_receivers", lambda: run.open_receivers(300_000, 5)
    for mode in MODES:
        yield f"memory core {mode}", partial(run.memory, "core", mode, 100_000, 16)
    yield "memory operator SHADOWED", lambda: run.memory("operator", "SHADOWED", 100_000, 16)
    yield "blender SHADOWED", lambda: run.blender_share("SHADOWED", 20_000, 128, 2)
    yield "previews", lambda: run.previews("INTERREFLECTED", 20_000, 256, 2)
    yield "first_picture 20000", lambda: run.first_picture(20_000, 1)


def main() -> None:
    """Run, print, write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="a minute instead of a quarter of an hour")
    parser.add_argument("--output", type=Path, default=ROOT / "build" / "bench")
    parser.add_argument("--page", type=Path, help="also write the table here, and the pictures beside it")
    arguments = parser.parse_args()
    arguments.output.mkdir(parents=True, exist_ok=True)
    results = {}
    for name, result in in_blender(quick() if arguments.quick else whole()):
        results[name] = result
        (arguments.output / "results.json").write_text(json.dumps(results, indent=1) + "\n")
    command = "python tools/bench --quick" if arguments.quick else "make bench"
    for path in filter(None, (arguments.output / "benchmark.md", arguments.page)):
        report.write_page(path, results, command)
    print(report.table(results, command))


def in_blender(experiments: Iterator[Experiment]) -> Iterator[tuple[str, run.Result]]:
    """All results with their names; the extension is enabled for those that need it."""
    import headless

    headless.enable_extension()
    try:
        for name, experiment in experiments:
            begun = time.monotonic()
            with headless.quiet():
                result = experiment()
            print(f"{name}: {time.monotonic() - begun:.0f} s", file=sys.stderr, flush=True)
            yield name, result
    finally:
        headless.disable_extension()


if __name__ == "__main__":
    main()
