# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders three frames of one bake, as the button shows them: without shadows, after its first rays, and its end.

python tools/previews.py [--output FILE]
"""

from __future__ import annotations

import argparse
import importlib
import tempfile
from pathlib import Path
from typing import Any

import demo_scene
import headless
from frames import render, set_up_render, side_by_side
from headless import bpy
from PIL import Image

SAMPLES = 256
QUALITY = 85


def main() -> None:
    """Bake, draw what is seen on the way, say where it is."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--output", type=Path, default=headless.CHECKOUT / "build" / "previews.jpg")
    output: Path = parser.parse_args().output
    headless.enable_extension()
    try:
        with tempfile.TemporaryDirectory() as folder:
            side_by_side([Image.open(path).convert("RGB") for path in draw(Path(folder))]).save(output, quality=QUALITY)
    finally:
        headless.disable_extension()
    print(output)


def draw(folder: Path) -> list[Path]:
    """A picture of each preview and of the whole bake, in a folder."""
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    demo_scene.build()
    scene = bpy.context.scene
    set_up_render(scene)
    settings = part("core.problem").BakeSettings("INTERREFLECTED", SAMPLES)
    whole = part("scene.bake.whole_bake").WholeBake(
        bpy.context, settings, part("scene.sky.projection").LightSettings(), True
    )
    run, pictures = part("core.bake.run").DEFAULT_RUN, list[Path]()
    for preview in (whole.first_preview(), *part("core.bake.previews").previews(whole.plan.problem, run)):
        whole.show(bpy.context, preview)
        pictures.append(render(scene, folder / f"{len(pictures)}.png"))
    whole.write(bpy.context, part("core.bake.bake").bake(whole.plan.problem, run))
    return [*pictures, render(scene, folder / "end.png")]


def part(name: str) -> Any:
    """A module of the extension under the name that Blender gave it."""
    return importlib.import_module(f"{headless.PACKAGE}.prt_addon.{name}")


if __name__ == "__main__":
    main()
