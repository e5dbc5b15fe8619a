# SPDX-License-Identifier: GPL-3.0-or-later
"""Does the main job on real input: bakes, relights, turns the world, and compares with a path tracer.

    python tools/demo.py [--blend FILE] [--output FOLDER]

Writes a web page, stills, a turning GIF, the same view path-traced by Cycles, and the .blend.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from pathlib import Path
from typing import Any

import demo_scene
import headless
from frames import (
    relative_rms,
    render,
    render_linear,
    save_gif,
    set_up_render,
    side_by_side,
    turning_rotation,
    use_cycles,
)
from headless import bpy
from PIL import Image
from tqdm import tqdm

STILLS = 4
TURN_FRAMES = 24


def main() -> None:
    """Run the demo and say where things are."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--blend", type=Path, help="a file of your own instead of the built-in scene")
    parser.add_argument("--output", type=Path, default=headless.CHECKOUT / "build" / "demo")
    arguments = parser.parse_args()
    output: Path = arguments.output.resolve()
    output.mkdir(parents=True, exist_ok=True)
    headless.enable_extension()
    try:
        run(arguments.blend, output)
    finally:
        headless.disable_extension()


def run(blend: Path | None, output: Path) -> None:
    """Build or open the scene, bake it, and draw all pictures into a folder."""
    scene = opened(blend)
    bake(output)
    print("The first EEVEE frame compiles shaders, which can take a minute on a new machine.")
    set_up_render(scene)
    frames = turn_sky(scene, output)
    stills = frames[:: TURN_FRAMES // STILLS]
    for number, path in enumerate(stills):
        Image.open(path).save(output / f"still_{360 * number // STILLS:03}.png")
    save_gif(output / "turn.gif", [Image.open(path).convert("RGB") for path in frames])
    apart = compare(scene, frames[0], output)
    side_by_side([Image.open(path) for path in stills]).save(output / "stills.png")
    for path in frames:
        path.unlink()
    print(f"\nEverything is in {output}:")
    for path in sorted(output.iterdir()):
        print(f"  {path.name}")
    print(f"EEVEE's picture is {apart:.1%} from Cycles' (relative RMS in linear light, {scene.prt.mode}).")


def opened(blend: Path | None) -> Any:
    """The scene of a file, or the built-in one."""
    if blend:
        bpy.ops.wm.open_mainfile(filepath=str(blend.resolve()))
        demo_scene.ensure_camera()
    else:
        bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
        demo_scene.build()
    return bpy.context.scene


def bake(output: Path) -> None:
    """Bake as the button does, and save the file and its web page."""
    begun = time.monotonic()
    try:
        bpy.ops.prt.bake()
    except RuntimeError as refusal:
        sys.exit(str(refusal))
    print(f"Baked in {time.monotonic() - begun:.1f} s.")
    bpy.ops.wm.save_as_mainfile(filepath=str(output / "demo.blend"), copy=True)
    bpy.ops.prt.export_web_page(filepath=str(output / "demo.html"), still=False)


def turn_sky(scene: Any, output: Path) -> list[Path]:
    """Render the frames of a full turn of the sky, which then stands as before."""
    rotation = turning_rotation(scene)
    start, frames = rotation[2], []
    angles = [start + 2 * math.pi * i / TURN_FRAMES for i in range(TURN_FRAMES)]
    for number, angle in enumerate(tqdm(angles, desc="EEVEE turn", unit="frame", file=sys.stdout)):
        rotation[2] = angle
        frames.append(render(scene, output / f"turn_{number:02}.png"))
    rotation[2] = start
    return frames


def compare(scene: Any, frame: Path, output: Path) -> float:
    """Path-trace the view of a frame by Cycles, and show both; returns how far they are apart."""
    print("Cycles, the same view path-traced ...", flush=True)
    ours = render_linear(scene, output / "eevee.exr")
    use_cycles(scene)
    truth = render_linear(scene, output / "cycles.exr")
    cycles = Image.open(render(scene, output / "cycles.png"))
    side_by_side([Image.open(frame), cycles]).save(output / "eevee_beside_cycles.png")
    return relative_rms(ours, truth)


if __name__ == "__main__":
    main()
