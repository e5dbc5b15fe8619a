# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes results as a table of ratios, beside what they shall be, and as pictures."""

from __future__ import annotations

import os
import platform
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

Results = dict[str, dict[str, Any]]
Row = tuple[str, str, str]

_MIB = 1 << 20
_HEAD = """# Benchmark

Made by `{command}` on {cores} cores, with Python {python} and NumPy {numpy}: everything in one run, what is compared by turns,
medians of the turns' ratios. Ratios of time are given as wall clock / processor seconds; on a machine with other work the
latter is the steadier. "Its rays alone" are the same rays, made beforehand, handed to `EmbreeScene.run` in the same chunks
on as many threads. Larger scenes leave the processor's cache: time grows with the receivers as that of the rays alone does.

| What | Measured | Wanted |
|---|---|---|
"""


def table(results: Results, command: str) -> str:
    """Markdown, with the command that made it."""
    rows = [row for name, result in results.items() for row in _ROWS[name.split()[0]](result)]
    machine = {"cores": os.cpu_count(), "python": platform.python_version(), "numpy": np.__version__}
    return _HEAD.format(command=command, **machine) + "".join(f"| {' | '.join(row)} |\n" for row in rows)


def write_page(path: Path, results: Results, command: str) -> None:
    """The table, and the pictures in a folder `pictures/benchmark` beside it."""
    folder = path.parent / "pictures" / "benchmark"
    folder.mkdir(parents=True, exist_ok=True)
    shown = [
        f"![{picture.stem}]({picture.relative_to(path.parent).as_posix()})\n" for picture in pictures(results, folder)
    ]
    path.write_text("\n".join([table(results, command), *shown]))


def _both(ratio: dict[str, float], digits: int = 2) -> str:
    return f"{ratio['wall']:.{digits}f} / {ratio['cpu']:.{digits}f}"


def _over_its_rays(result: dict[str, Any]) -> Iterator[Row]:
    bounced = result["mode"] == "INTERREFLECTED"
    what = "Interreflected, three bounces" if bounced else "Shadowed"
    size = f"{result['receivers']:,} receivers, {result['samples']} samples"
    yield f"{what}, over its rays alone ({size})", _both(result["ratio"]), "<= 1.40" if bounced else "<= 1.22"
    yield "The same without a process of its own", _both(result["ratio_here"]), ""
    yield "That with all receivers mended that are sunk into the ground", _both(result["ratio_mended"]), ""


def _engine_start(result: dict[str, Any]) -> Iterator[Row]:
    times = f"{1e3 * result['first']:.0f} / {1e3 * result['again']:.0f} ms"
    yield "The engine's answer to one receiver, with its start / without", times, ""


def _each_bounce(result: dict[str, Any]) -> Iterator[Row]:
    none, one, *_, last = result["shares"]
    further = len(result["shares"]) - 2
    hits = f"{result['hits_per_receiver']:.0f} hits a receiver"
    yield (
        f"The first bounce, over the rays alone ({hits})",
        _both({clock: one[clock] - none[clock] for clock in one}, 3),
        "",
    )
    mean = {clock: (last[clock] - one[clock]) / further for clock in one}
    yield f"Each further bounce, mean of {further}", _both(mean, 3), ""


def _against_uniform(result: dict[str, Any]) -> Iterator[Row]:
    samples, needed = result["samples"], result["uniform_samples"]
    yield f"Uniform sphere, samples for the error of {samples} ({result['error']:.1e})", f"{needed:,}", ""
    yield "Uniform sphere, time over ours at that error", _both(result["ratio"], 0), ""


def _growth(result: dict[str, Any]) -> Iterator[Row]:
    by = "receivers" if len(set(result["receivers"])) > 1 else "samples"
    low, high = result[by][0], result[by][-1]
    mode = result["mode"].lower()
    yield f"Exponent of time in {by}, {low:,.0f} to {high:,.0f}, {mode}", f"{result['exponent']:.3f}", "<= 1.05"
    yield "The same of its rays alone", f"{result['rays_exponent']:.3f}", ""


def _open_receivers(result: dict[str, Any]) -> Iterator[Row]:
    rates = f"{result['per_second'] / 1e6:.1f} / {result['per_core_second'] / 1e6:.1f} million"
    yield "Unshadowed receivers, per second / per core and second", rates, ">= 5 million/s"


def _memory(result: dict[str, Any]) -> Iterator[Row]:
    size = f"{result['mode'].lower()}, {result['receivers']:,} receivers, {result['samples']} samples, {result['how']}"
    shadowed = result["mode"] == "SHADOWED"
    yield f"Peak resident: {size}", f"{result['peak'] / _MIB:,.0f} MiB", "<= 2,048 MiB" if shadowed else ""
    wanted = "<= 600 MiB" if shadowed else ""
    yield "The same, beyond the mesh and its result", f"{result['beyond'] / _MIB:,.0f} MiB", wanted
    if result["hits_per_receiver"]:
        yield "Kept hits, bytes per receiver", f"{result['hits_per_receiver']:,.0f}", ""


def _blender(result: dict[str, Any]) -> Iterator[Row]:
    parts = f"reading {result['read']['cpu']:.1%}, writing {result['write']['cpu']:.1%}"
    share = f"{result['ratio']['wall']:.1%} / {result['ratio']['cpu']:.1%}"
    yield f"Blender's meshes over the bake, {result['mode'].lower()} ({parts})", share, "<= 3%"


def _previews(result: dict[str, Any]) -> Iterator[Row]:
    size = f"{result['mode'].lower()}, {result['receivers']:,} receivers, {result['samples']} samples"
    yield f"With previews over without ({size})", _both(result["ratio"]), "<= 1.10"


def _first_picture(result: dict[str, Any]) -> Iterator[Row]:
    what = f"From the button to the first picture / the last, {result['receivers']:,} receivers, {result['samples']} samples"
    wanted = "<= 1 s" if result["receivers"] <= 100_000 else ""
    yield what, f"{result['first']:.1f} / {result['last']:.1f} s", wanted


def _eevee_frames(result: dict[str, Any]) -> Iterator[Row]:
    lamps = f"{result['lamps']} lamp{'' if result['lamps'] == 1 else 's'}"
    yield f"A relit frame of EEVEE over the user's material alone, {lamps}", _both(result["relit"]), "<= 1.30"
    yield "That with a white surface lit for a shader to read, and no transport", _both(result["second"]), ""


def _first_frames(result: dict[str, Any]) -> Iterator[Row]:
    lamps = f"{result['lamps']} lamp{'' if result['lamps'] == 1 else 's'}"
    what = f"The first frame of a process, shaders compiled anew, over that of the users' {result['materials']} materials alone, {lamps}"
    yield what, _both(result["relit"]), "<= 1.50"


def _page_frames(result: dict[str, Any]) -> Iterator[Row]:
    for what, key in (("the camera moves", "camera"), ("the sky turns", "sky")):
        frame = result[key]
        drawn = f"{result['vertices']:,} vertices, 1280 x 720, drawn at {frame['scale']:.0%} along each side"
        times = f"{1e3 * frame['wall']:.0f} / {1e3 * frame['cpu']:.0f} ms"
        yield f"A frame of a web page in a browser without a graphics card while {what} ({drawn})", times, "<= 33 ms"


_ROWS = {
    "over_its_rays": _over_its_rays,
    "engine_start": _engine_start,
    "each_bounce": _each_bounce,
    "against_uniform": _against_uniform,
    "growth": _growth,
    "open_receivers": _open_receivers,
    "memory": _memory,
    "blender": _blender,
    "previews": _previews,
    "first_picture": _first_picture,
    "eevee_frames": _eevee_frames,
    "first_frames": _first_frames,
    "page_frames": _page_frames,
}


def pictures(results: Results, folder: Path) -> Iterator[Path]:
    """Curves of growth and of the bounces, as PNG; none without matplotlib."""
    try:
        from matplotlib.figure import Figure
    except ImportError:
        return
    for name, result in results.items():
        figure = Figure(figsize=(6, 4), layout="constrained")
        axes = figure.subplots()
        if name.startswith("growth"):
            by = "receivers" if len(set(result["receivers"])) > 1 else "samples"
            for key, power, marker in (("bake", "exponent", "o-"), ("rays_alone", "rays_exponent", "s--")):
                label = f"{key.replace('_', ' ')}, exponent {result[power]:.3f}"
                axes.loglog(result[by], result[key], marker, label=label)
            axes.set(xlabel=by, ylabel="processor seconds", title=result["mode"].capitalize())
        elif name == "each_bounce":
            for clock, marker in (("wall", "o-"), ("cpu", "s--")):
                axes.plot([share[clock] for share in result["shares"]], marker, label=clock)
            axes.set(xlabel="bounces", ylabel="time over that of the rays alone", ylim=(0, None))
        else:
            continue
        axes.grid(True, which="both", alpha=0.3)
        axes.legend()
        path = folder / f"{name.replace(' ', '_')}.png"
        figure.savefig(path, dpi=100)
        yield path
