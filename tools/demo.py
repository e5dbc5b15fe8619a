# SPDX-License-Identifier: GPL-3.0-or-later
"""The main job on real input: bake, relight, turn the world, and compare with a path tracer.

    python tools/demo.py [--blend FILE] [--output FOLDER]

Writes stills, a turning GIF, the same view path-traced by Cycles, and the .blend.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from pathlib import Path

import demo_scene
import headless
import numpy as np
from headless import bpy
from PIL import Image
from tqdm import tqdm

STILLS = 4
TURN_FRAMES = 24
CYCLES_SAMPLES = 64


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
    if blend:
        bpy.ops.wm.open_mainfile(filepath=str(blend.resolve()))
        demo_scene.ensure_camera()
    else:
        bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
        demo_scene.build()
    scene = bpy.context.scene
    begun = time.monotonic()
    try:
        bpy.ops.prt.bake()
    except RuntimeError as refusal:
        sys.exit(str(refusal))
    print(f"Baked in {time.monotonic() - begun:.1f} s.")
    bpy.ops.wm.save_as_mainfile(filepath=str(output / "demo.blend"), copy=True)
    print("The first EEVEE frame compiles shaders, which can take a minute on a new machine.")
    set_up_render(scene)
    rotation = turning_rotation(scene)
    start = rotation[2]

    angles = [start + 2 * math.pi * i / TURN_FRAMES for i in range(TURN_FRAMES)]
    frames = []
    for number, angle in enumerate(tqdm(angles, desc="EEVEE turn", unit="frame", file=sys.stdout)):
        rotation[2] = angle
        frames.append(render(scene, output / f"turn_{number:02}.png"))
    stills = frames[:: TURN_FRAMES // STILLS]
    for number, path in enumerate(stills):
        Image.open(path).save(output / f"still_{360 * number // STILLS:03}.png")
    pictures = [Image.open(path).convert("RGB") for path in frames]
    pictures[0].save(output / "turn.gif", save_all=True, append_images=pictures[1:], duration=83, loop=0)

    rotation[2] = start
    print("Cycles, the same view path-traced ...", flush=True)
    ours = render_linear(scene, output / "eevee.exr")
    eevee = Image.open(frames[0])
    use_cycles(scene)
    truth = render_linear(scene, output / "cycles.exr")
    cycles = Image.open(render(scene, output / "cycles.png"))
    side_by_side([eevee, cycles]).save(output / "eevee_beside_cycles.png")
    side_by_side([Image.open(path) for path in stills]).save(output / "stills.png")
    for path in frames:
        path.unlink()
    print(f"\nEverything is in {output}:")
    for path in sorted(output.iterdir()):
        print(f"  {path.name}")
    print(
        f"EEVEE's picture is {relative_rms(ours, truth):.1%} from Cycles' (relative RMS in linear light, {scene.prt.mode})."
    )


def set_up_render(scene: bpy.types.Scene) -> None:
    """EEVEE, about 640 pixels wide, without the lamps' shadows and the fine world probe that relit surfaces ignore."""
    render_settings = scene.render
    render_settings.engine = headless.eevee_engine()
    render_settings.resolution_percentage = max(1, min(100, round(640 / render_settings.resolution_x * 100)))
    scene.eevee.taa_render_samples = 4
    scene.eevee.use_shadows = False
    scene.world.probe_resolution, scene.world.sun_threshold = "128", 0.0


def use_cycles(scene: bpy.types.Scene) -> None:
    """Cycles on the same question: as many diffuse bounces as were baked, and no glossy ones."""
    scene.render.engine = "CYCLES"
    scene.cycles.samples = CYCLES_SAMPLES
    scene.cycles.use_denoising = True
    scene.cycles.max_bounces = scene.cycles.diffuse_bounces = demo_scene.diffuse_bounces(scene)


def turning_rotation(scene: bpy.types.Scene) -> bpy.types.bpy_prop_array:
    """The Euler angles of the world's Mapping node, which the bake made sure of."""
    mapping = next(node for node in scene.world.node_tree.nodes if node.bl_idname == "ShaderNodeMapping")
    return mapping.inputs["Rotation"].default_value


def render(scene: bpy.types.Scene, path: Path) -> Path:
    """One frame as it is displayed, with the sky behind it."""
    scene.render.film_transparent = False
    scene.render.image_settings.file_format = "PNG"
    scene.render.filepath = str(path)
    with headless.quiet():
        bpy.ops.render.render(write_still=True)
    return path


def render_linear(scene: bpy.types.Scene, path: Path) -> np.ndarray:
    """One frame in linear light, (height, width, 4), transparent where there is only sky."""
    scene.render.film_transparent = True
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.render.filepath = str(path)
    with headless.quiet():
        bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(str(path), check_existing=False)
    pixels = np.empty(image.size[0] * image.size[1] * 4, dtype=np.float32)
    image.pixels.foreach_get(pixels)
    return pixels.reshape(image.size[1], image.size[0], 4)


def relative_rms(ours: np.ndarray, truth: np.ndarray) -> float:
    """RMS of the difference over the RMS of the truth, where both show a surface."""
    surface = np.minimum(ours[..., 3], truth[..., 3]) > 0.99
    difference = ours[surface][:, :3] - truth[surface][:, :3]
    return float(np.sqrt((difference**2).mean() / (truth[surface][:, :3] ** 2).mean()))


def side_by_side(pictures: list[Image.Image]) -> Image.Image:
    """Pictures of one size in a row."""
    width, height = pictures[0].size
    row = Image.new("RGB", (width * len(pictures), height))
    for number, picture in enumerate(pictures):
        row.paste(picture.convert("RGB"), (width * number, 0))
    return row


if __name__ == "__main__":
    main()
