# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs the experiments. Each returns a dictionary of plain numbers, as it goes into the JSON."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import numpy.typing as npt
import scenes
from measure import Seconds, by_turns, exponent, median, now, ratio, timed
from naive import uniform_sphere
from rays_alone import rays_alone

from prt_addon.core.bake.bake import bake, bounce
from prt_addon.core.bake.run import DEFAULT_RUN
from prt_addon.core.bake.trace import trace_island
from prt_addon.core.problem import BakeProblem, BakeSettings, Island, Mode, Occluders, ReceiverGroup
from prt_addon.core.transport.direct import Receivers, shadowed
from prt_addon.core.transport.raycast import RayScene
from prt_addon.worker import tasks
from prt_addon.worker.job import bake_job, end_engine

Result = dict[str, Any]


def _bake(groups: Sequence[ReceiverGroup], occluders: Occluders, settings: BakeSettings) -> Callable[[], Seconds]:
    return lambda: timed(lambda: bake(BakeProblem.of(groups, occluders, settings)))


def over_its_rays(mode: Mode, receivers: int, samples: int, turns: int) -> Result:
    """A whole bake in the engine's process, from its start to its end, over its rays alone."""
    groups, occluders = scenes.bake_input(scenes.court(receivers))
    sunk, _ = scenes.bake_input(scenes.court(receivers), mended=True)
    settings = BakeSettings(mode, samples)
    problem = BakeProblem.of(groups, occluders, settings)

    def in_the_engine() -> None:
        job = bake_job(problem, patience=0.0)
        job.start()
        job.result()

    runs = [
        lambda: timed(in_the_engine),
        lambda: rays_alone(groups, occluders, settings),
        _bake(groups, occluders, settings),
        _bake(sunk, occluders, settings),
    ]
    times = by_turns(runs, turns)
    alone = median([turn[1] for turn in times])
    return {
        "mode": mode,
        "receivers": problem.receivers,
        "samples": samples,
        "ratio": asdict(ratio(times, 0, 1)),
        "ratio_here": asdict(ratio(times, 2, 1)),
        "ratio_mended": asdict(ratio(times, 3, 1)),
        "bake": asdict(median([turn[0] for turn in times])),
        "rays_alone": asdict(alone),
        "rays_per_second": problem.work.rays / alone.wall,
    }


def engine_start(turns: int) -> Result:
    """From nothing to the answer to a job of one receiver, and the answer of an engine that runs already."""
    up = np.array([[0.0, 0.0, 1.0]])
    nothing = Occluders(np.empty((0, 3)), np.empty((0, 3), dtype=np.int32))

    def first_answer() -> None:
        job = bake_job(BakeProblem.of([ReceiverGroup("Point", up, up, 1.0)], nothing, BakeSettings("UNSHADOWED")))
        job.start()
        job.result()

    times = []
    for _ in range(turns):
        end_engine()
        times.append((timed(first_answer).wall, timed(first_answer).wall))
    end_engine()
    first, again = (float(np.median(column)) for column in zip(*times, strict=True))
    return {"first": first, "again": again}


def each_bounce(receivers: int, samples: int, bounces: int, turns: int) -> Result:
    """The time of 0, 1, 2, ... bounces after the rays, over the time of the rays alone."""
    groups, occluders = scenes.bake_input(scenes.court(receivers))
    settings = BakeSettings("INTERREFLECTED", samples)
    traced = trace_island(Island(groups, occluders), settings)

    def bounces_of(count: int) -> Callable[[], Seconds]:
        return lambda: timed(lambda: bounce(traced, occluders, replace(settings, bounces=count)))

    runs = [*map(bounces_of, range(bounces + 1)), lambda: rays_alone(groups, occluders, settings)]
    times = by_turns(runs, turns)
    shares = [asdict(ratio(times, count, bounces + 1)) for count in range(bounces + 1)]
    return {"receivers": len(traced.hits), "hits_per_receiver": traced.hits.count / len(traced.hits), "shares": shares}


def against_uniform(receivers: int, samples: int) -> Result:
    """The plain estimator with as many samples as it needs for the same error, and how much longer it takes."""
    groups, occluders = scenes.bake_input(scenes.court(receivers))
    scene = RayScene(occluders.vertices, occluders.triangles)
    points = Receivers.of(groups, scene)
    truth = shadowed(scene, points, 1 << 14, seed=1)

    def error(result: npt.NDArray[Any]) -> float:
        return float(np.sqrt(np.mean((result - truth) ** 2)))

    begun = now()
    ours = error(shadowed(scene, points, samples))
    one = now() - begun
    trial = error(uniform_sphere(scene, points, samples))
    needed = round(samples * (trial / ours) ** 2)  # its variance falls with the number of samples
    begun = now()
    plain = error(uniform_sphere(scene, points, needed))
    other = now() - begun
    return {
        "receivers": len(points),
        "samples": samples,
        "error": ours,
        "uniform_error_at_same_samples": trial,
        "uniform_samples": needed,
        "uniform_error": plain,
        "ratio": asdict(other.over(one)),
    }


def growth(mode: Mode, sizes: Sequence[tuple[int, int]], turns: int) -> Result:
    """Bakes of (receivers, samples), their rays alone, and the power of the ray count that each grows with."""
    found: dict[str, list[float]] = {"receivers": [], "samples": [], "rays": [], "bake": [], "rays_alone": []}
    for receivers, samples in sizes:
        groups, occluders = scenes.bake_input(scenes.court(receivers))
        settings = BakeSettings(mode, samples)
        runs = [_bake(groups, occluders, settings), lambda: rays_alone(groups, occluders, settings)]  # noqa: B023
        times = by_turns(runs, turns)
        count = BakeProblem.of(groups, occluders, settings).work.rays
        row = (count / samples, samples, count, *(min(turn[k].cpu for turn in times) for k in (0, 1)))
        for values, value in zip(found.values(), row, strict=True):
            values.append(value)
    return {
        "mode": mode,
        **found,
        "exponent": exponent(found["rays"], found["bake"]),
        "rays_exponent": exponent(found["rays"], found["rays_alone"]),
    }


def open_receivers(receivers: int, turns: int) -> Result:
    """Unshadowed receivers per second."""
    normals = np.random.default_rng(0).normal(size=(receivers, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    group = ReceiverGroup("Normals", normals, normals, 1.0)
    nothing = Occluders(np.empty((0, 3)), np.empty((0, 3), dtype=np.int32))
    times = [_bake([group], nothing, BakeSettings("UNSHADOWED"))() for _ in range(turns)]
    return {
        "per_second": receivers / min(t.wall for t in times),
        "per_core_second": receivers / min(t.cpu for t in times),
    }


def memory(how: str, mode: Mode, receivers: int, samples: int) -> Result:
    """Peak of a bake in a process of its own; see `memory`."""
    command = [sys.executable, str(Path(__file__).with_name("memory.py")), how, mode, str(receivers), str(samples)]
    answer = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout
    return json.loads(answer.splitlines()[-1])


def blender_share(mode: Mode, receivers: int, samples: int, turns: int) -> Result:
    """Reading meshes and writing attributes in Blender, over the bake between them. Needs `headless`' extension."""
    import importlib

    import blender_scene
    import headless

    def part(name: str) -> Any:
        return importlib.import_module(f"{headless.PACKAGE}.prt_addon.{name}")

    read, layers, engine = part("scene.bake.read"), part("scene.mesh.layers"), part("core.bake.bake")
    objects = blender_scene.court(receivers)
    settings = part("core.problem").BakeSettings(mode, samples)

    def write(ob: Any, one: Any, result: Any) -> None:
        found, transport, direct = one.receivers, result.transport[one.group], result.direct[one.group]
        elements = found.element_receiver
        layers.write(ob.data, found.domain, transport, direct, elements, settings, evidence=one.evidence)

    def turn() -> list[Seconds]:
        clock = [now()]
        plan = read.read_bake(headless.bpy.context, objects, settings)
        clock.append(now())
        result = engine.bake(plan.problem)
        clock.append(now())
        for ob, one in zip(objects, plan.objects, strict=True):
            write(ob, one, result)
        clock.append(now())
        return [after - before for before, after in pairwise(clock)]

    times = [turn() for _ in range(turns)]
    reading, baking, writing = (median([one[k] for one in times]) for k in range(3))
    return {
        "mode": mode,
        "read": asdict(reading.over(baking)),
        "write": asdict(writing.over(baking)),
        "ratio": asdict((reading + writing).over(baking)),
    }


def previews(mode: Mode, receivers: int, samples: int, turns: int) -> Result:
    """A bake with previews over one without."""
    problem = BakeProblem.of(*scenes.bake_input(scenes.court(receivers), mended=True), BakeSettings(mode, samples))
    tried = [
        lambda task=task: timed(lambda: task(problem, DEFAULT_RUN)) for task in (tasks.bake_with_previews, tasks.bake)
    ]
    return {
        "mode": mode,
        "receivers": problem.receivers,
        "samples": samples,
        "ratio": asdict(ratio(by_turns(tried, turns), 0, 1)),
    }


def first_picture(receivers: int, turns: int) -> Result:
    """Seconds from the press of the button until something is written and shaded, a preview or the end; without the redraw, which
    is EEVEE's. Needs `headless`' extension.
    """
    import importlib

    import blender_scene
    import headless

    def part(name: str) -> Any:
        return importlib.import_module(f"{headless.PACKAGE}.{name}")

    jobs, whole_bake = part("prt_addon.worker.job"), part("prt_addon.scene.bake.whole_bake")
    settings, tick = part("prt_addon.core.problem").BakeSettings("INTERREFLECTED"), part("operators.job").TICK
    is_worth, context = part("prt_addon.core.bake.previews").is_worth, headless.bpy.context

    def press() -> tuple[float, float]:
        """When the first picture is there, and when the last is."""
        blender_scene.court(receivers)
        jobs.end_engine()
        begun, seen = time.perf_counter(), []
        jobs.wake_engine()
        whole = whole_bake.WholeBake(context, settings, None, True)
        is_previewed = is_worth(whole.plan.problem)
        job = jobs.bake_job(whole.plan.problem, previews=is_previewed)
        if is_previewed:
            job.show(whole.first_preview())
        job.start()
        while job.running:
            time.sleep(tick)
            job.step()
            if preview := job.take_shown():
                whole.show(context, preview)
                seen.append(time.perf_counter() - begun)
        whole.write(context, job.result())
        seen.append(time.perf_counter() - begun)
        return seen[0], seen[-1]

    first, last = (float(np.median(column)) for column in zip(*(press() for _ in range(turns)), strict=True))
    return {"receivers": receivers, "samples": settings.samples, "first": first, "last": last}


def eevee_frames(lamps: int, turns: int) -> Result:
    """Frames of relit materials over those of the user's alone; see `eevee_frames`. Needs `headless`' extension."""
    import eevee_frames as frames

    with TemporaryDirectory() as folder:
        return frames.eevee_frames(lamps, turns, Path(folder))


def first_frames(lamps: int, turns: int) -> Result:
    """First frames of a process, relit over the user's material alone; see `eevee_frames`. Needs `headless`' extension."""
    import eevee_frames as frames

    with TemporaryDirectory() as folder:
        return frames.first_frames(lamps, turns, Path(folder))


def page_frames(vertices: int) -> Result:
    """Frames of an exported page in a browser that draws by software; see `pages`."""
    import pages

    return pages.page_frames(vertices)
