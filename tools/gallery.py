# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the pictures and numbers of README and docs: every HDRI that Blender ships, every mode, beside Cycles.

    python tools/gallery.py [--output FOLDER]

Writes docs/gallery.md and docs/pictures; by way of the demo, so that they show what a user gets.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import demo
import demo_scene
import frames
import gallery_scenes
import headless
import numpy as np
import numpy.typing as npt
from headless import bpy
from PIL import Image, ImageDraw, ImageSequence
from tqdm import tqdm

HDRIS = ("forest", "city", "courtyard", "interior", "night", "studio", "sunrise", "sunset")
MODES = ("UNSHADOWED", "SHADOWED", "INTERREFLECTED")
NO_LAMPS = "INTERREFLECTED, NO LAMPS"
PERCENTAGE = 50
SMALL_PERCENTAGE, SMALL_TRUTH_SAMPLES = 25, 64
TRUTH_SAMPLES = 128
TURN_WIDTH = 420
CAPTION = 18


@dataclass(frozen=True)
class Shot:
    """One view: as displayed, and (height, width, 4) linear."""

    shown: Image.Image
    linear: npt.NDArray[Any]


def main() -> None:
    """Draw everything and say where it is."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--output", type=Path, default=headless.CHECKOUT / "docs")
    output: Path = parser.parse_args().output.resolve()
    work = headless.CHECKOUT / "build" / "gallery"
    for folder in (output / "pictures" / "gallery", work):
        folder.mkdir(parents=True, exist_ok=True)
    headless.enable_extension()
    try:
        demo.run(None, work)
        publish_demo(work, output / "pictures")
        lines = [*publish_gallery(work, output), *publish_scenes(work, output)]
        (output / "gallery.md").write_text("\n".join([*lines, ""]))
    finally:
        headless.disable_extension()


def publish_demo(made: Path, pictures: Path) -> None:
    """The demo's own pictures, small enough to be committed."""
    for name in ("stills", "eevee_beside_cycles"):
        Image.open(made / f"{name}.png").convert("RGB").resize(
            (1280, 1280 * 9 // (64 if name == "stills" else 32))
        ).save(pictures / f"{name}.jpg", quality=88)
    turn = Image.open(made / "turn.gif")
    small = []
    for frame in ImageSequence.Iterator(turn):
        small.append(frame.convert("RGB").resize((TURN_WIDTH, TURN_WIDTH * 9 // 16), Image.Resampling.LANCZOS))
    frames.save_gif(pictures / "turn.gif", small)


def publish_gallery(work: Path, output: Path) -> list[str]:
    """One sheet per HDRI; the lines of docs/gallery.md, with a table of how far each mode is from the truth."""
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    demo_scene.build()
    scene = bpy.context.scene
    frames.set_up_render(scene)
    scene.render.resolution_percentage = PERCENTAGE
    truths = {hdri: truth(scene, hdri, work) for hdri in tqdm(HDRIS, desc="Cycles", file=sys.stdout)}
    shots: dict[str, dict[str, Shot]] = {hdri: {} for hdri in HDRIS}
    for mode in MODES:
        bpy.ops.prt.bake(mode=mode)
        for hdri in tqdm(HDRIS, desc=f"EEVEE, {mode.lower()}", file=sys.stdout):
            change_sky(scene, hdri)
            shots[hdri][mode] = relit(scene, work, "AUTO")
    for hdri in tqdm(HDRIS, desc="EEVEE, without lamps", file=sys.stdout):
        change_sky(scene, hdri)
        shots[hdri][NO_LAMPS] = relit(scene, work, "NONE")
    for hdri in HDRIS:
        sheet(truths[hdri], shots[hdri]).save(output / "pictures" / "gallery" / f"{hdri}.jpg", quality=85)
    clamps(scene, work).save(output / "pictures" / "gallery" / "clamp.jpg", quality=88)
    return page(truths, shots)


def publish_scenes(work: Path, output: Path) -> list[str]:
    """Five scenes under each HDRI: a sheet of EEVEE beside Cycles for each; further lines, with a table of how far they are apart."""
    errors: dict[str, list[tuple[float, float]]] = {}
    for name, build in gallery_scenes.SCENES.items():
        scene = baked(build)
        pairs, errors[name] = [], []
        for hdri in tqdm(HDRIS, desc=name, file=sys.stdout):
            wanted = truth(scene, hdri, work, SMALL_TRUTH_SAMPLES)
            bare, shown = (relit(scene, work, lamps) for lamps in ("NONE", "AUTO"))
            pairs.append((wanted.shown, shown.shown))
            of_shown, of_bare = (frames.relative_rms(one.linear, wanted.linear) for one in (shown, bare))
            errors[name].append((of_shown, of_bare))
        contact(pairs).save(output / "pictures" / "gallery" / f"{name.lower()}.jpg", quality=85)
    return scenes_page(errors)


def baked(build: gallery_scenes.Build) -> bpy.types.Scene:
    """A small scene with interreflected light."""
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    build()
    scene = bpy.context.scene
    frames.set_up_render(scene)
    scene.render.resolution_percentage = SMALL_PERCENTAGE
    bpy.ops.prt.bake(mode="INTERREFLECTED")
    return scene


def contact(pairs: Sequence[tuple[Image.Image, Image.Image]]) -> Image.Image:
    """Pictures by Cycles above those by EEVEE, four HDRIs in a row."""
    width, height = pairs[0][0].size
    whole = Image.new("RGB", (4 * width, len(pairs) // 4 * (2 * height + CAPTION)), "white")
    for number, (pair, hdri) in enumerate(zip(pairs, HDRIS, strict=True)):
        left, top = number % 4 * width, number // 4 * (2 * height + CAPTION)
        ImageDraw.Draw(whole).text((left + 4, top + 3), f"{hdri}: Cycles, EEVEE", fill="black")
        for row, picture in enumerate(pair):
            whole.paste(picture, (left, top + CAPTION + row * height))
    return whole


def scenes_page(errors: dict[str, list[tuple[float, float]]]) -> list[str]:
    """The lines on five scenes."""
    lines = [
        "",
        "## Five scenes",
        "",
        "Interreflected, whole materials, under each HDRI. Numbers in brackets are without lamps taken out of the sky.",
        "",
        "| HDRI | " + " | ".join(errors) + " |",
        "|---|" + "---|" * len(errors),
    ]
    for row, hdri in enumerate(HDRIS):
        cells = (f"{shown:.1%} ({bare:.1%})" for shown, bare in (column[row] for column in errors.values()))
        lines.append(f"| {hdri} | " + " | ".join(cells) + " |")
    for name in errors:
        about = str(gallery_scenes.SCENES[name].__doc__)
        lines += ["", f"### {name}", "", about, "", f"![{name}](pictures/gallery/{name.lower()}.jpg)"]
    return lines


def clamps(scene: bpy.types.Scene, work: Path) -> Image.Image:
    """An orange lamp in a grey room, by Cycles; by EEVEE with each channel clamped by itself; and as we clamp."""
    sky_texture(scene).image = orange_lamp()
    kept = relit(scene, work, "NONE")
    group = bpy.data.node_groups["PRT Relight: Without Negatives"]
    [clamp] = [node for node in group.nodes if getattr(node, "operation", "") == "MAXIMUM" and node.type == "VECT_MATH"]
    greyed = clamp.inputs[0].links[0].from_socket
    group.links.new(greyed.node.inputs[2].links[0].from_socket, clamp.inputs[0])
    apart = shoot(scene, work)
    group.links.new(greyed, clamp.inputs[0])
    frames.use_cycles(scene)
    scene.cycles.samples = TRUTH_SAMPLES
    truth = shoot(scene, work)
    width, height = truth.shown.size
    strip = Image.new("RGB", (3 * width, height + CAPTION), "white")
    captions = ("Cycles", "EEVEE, each channel clamped by itself", "EEVEE, clamped towards grey, as it is")
    for column, (shot, caption) in enumerate(zip((truth, apart, kept), captions, strict=True)):
        ImageDraw.Draw(strip).text((column * width + 4, 3), caption, fill="black")
        strip.paste(shot.shown, (column * width, CAPTION))
    return strip


def orange_lamp() -> bpy.types.Image:
    """A panorama: one strong orange lamp above the horizon, in a dim grey room."""
    height = 128
    texels = np.ones((height, 2 * height, 4), dtype=np.float32)
    texels[..., :3] = 0.06
    texels[80:92, 100:112, :3] = (160.0, 70.0, 12.0)
    image = bpy.data.images.new("Orange Lamp", 2 * height, height, float_buffer=True)
    image.pixels.foreach_set(texels.ravel())
    return image


def sky_texture(scene: bpy.types.Scene) -> bpy.types.Node:
    """The world's Environment Texture."""
    return next(node for node in scene.world.node_tree.nodes if node.bl_idname == "ShaderNodeTexEnvironment")


def change_sky(scene: bpy.types.Scene, hdri: str) -> None:
    """Another picture in the world's Environment Texture."""
    sky_texture(scene).image = bpy.data.images.load(str(headless.studio_hdri(hdri)), check_existing=True)


def truth(scene: bpy.types.Scene, hdri: str, work: Path, samples: int = TRUTH_SAMPLES) -> Shot:
    """The view by Cycles, with as many bounces as the interreflected bake."""
    change_sky(scene, hdri)
    frames.use_cycles(scene)
    scene.cycles.samples = samples
    return shoot(scene, work)


def relit(scene: bpy.types.Scene, work: Path, lamps: str) -> Shot:
    """The view by EEVEE in the sky that is set, with these of its spots as lamps."""
    bpy.ops.prt.project_light(lamps=lamps)
    scene.render.engine = headless.eevee_engine()
    return shoot(scene, work)


def shoot(scene: bpy.types.Scene, work: Path) -> Shot:
    """The view by the engine that is set."""
    shown = Image.open(frames.render(scene, work / "shown.png")).convert("RGB")
    return Shot(shown, frames.render_linear(scene, work / "linear.exr"))


def sheet(truth: Shot, shots: dict[str, Shot]) -> Image.Image:
    """Cycles above; below it EEVEE in each mode, and under each its difference."""
    width, height = truth.shown.size
    whole = Image.new("RGB", (width * len(MODES), 3 * (height + CAPTION)), "white")
    draw = ImageDraw.Draw(whole)

    def place(column: int, row: int, picture: Image.Image, caption: str) -> None:
        top = row * (height + CAPTION)
        draw.text((column * width + 4, top + 3), caption, fill="black")
        whole.paste(picture, (column * width, top + CAPTION))

    place(0, 0, truth.shown, "Cycles, path-traced")
    place(1, 0, scale_of_differences(width, height), "Differences, as a share of the picture's mean radiance")
    for column, mode in enumerate(MODES):
        place(column, 1, shots[mode].shown, f"EEVEE, {mode.lower()}")
        error = frames.relative_rms(shots[mode].linear, truth.linear)
        place(column, 2, difference(shots[mode].linear, truth.linear), f"difference: {error:.1%} relative RMS")
    return whole


def difference(ours: npt.NDArray[Any], truth: npt.NDArray[Any]) -> Image.Image:
    """Red where ours is too bright, blue where it is too dark, white where it is right."""
    mean = truth[truth[..., 3] > 0.99][:, :3].mean()
    return coloured(np.where(ours[..., 3] > 0.99, (ours - truth)[..., :3].mean(axis=-1) / mean, 0.0)[::-1])


def coloured(shares: npt.NDArray[Any]) -> Image.Image:
    """A picture of signed shares, saturated at half."""
    strength = np.clip(2.0 * np.abs(shares), 0.0, 1.0)[..., None]
    hue = np.where(shares[..., None] > 0.0, (200, 30, 30), (30, 60, 200))
    return Image.fromarray((255 + strength * (hue - 255)).astype(np.uint8))


def scale_of_differences(width: int, height: int) -> Image.Image:
    """From -50 % to +50 %, with ticks."""
    bar = coloured(np.broadcast_to(np.linspace(-0.5, 0.5, width - 40), (24, width - 40)))
    picture = Image.new("RGB", (width, height), "white")
    picture.paste(bar, (20, height // 2 - 12))
    draw = ImageDraw.Draw(picture)
    for share, words in ((-0.5, "-50%, too dark"), (0.0, "right"), (0.5, "+50%, too bright")):
        x = 20 + (share + 0.5) * (width - 40)
        draw.text((x, height // 2 + 18), words, fill="black", anchor=("lt", "mt", "rt")[round(2 * share) + 1])
    return picture


def page(truths: dict[str, Shot], shots: dict[str, dict[str, Shot]]) -> list[str]:
    """The lines on the demo's scene."""
    lines = [
        "# Gallery",
        "",
        "Made by `make gallery`: the demo's scene under every HDRI that Blender ships. Numbers are the relative RMS difference",
        "from Cycles in linear light, where a surface is seen; Cycles traces as many bounces as were baked (three), denoised. What is left",
        "of an interreflected bake is almost all the order of the light: spots that are too wide for lamps, or too dim. The last column is without",
        "lamps: nine coefficients cannot hold a sun.",
        "",
        "| HDRI | " + " | ".join(mode.capitalize() for mode in (*MODES, NO_LAMPS)) + " |",
        "|---|" + "---|" * (len(MODES) + 1),
    ]
    for hdri in HDRIS:
        errors = (frames.relative_rms(shots[hdri][mode].linear, truths[hdri].linear) for mode in (*MODES, NO_LAMPS))
        lines.append(f"| {hdri} | " + " | ".join(f"{error:.1%}" for error in errors) + " |")
    for hdri in HDRIS:
        lines += ["", f"## {hdri.capitalize()}", "", f"![{hdri}](pictures/gallery/{hdri}.jpg)"]
    lines += [
        "",
        "## A coloured lamp",
        "",
        "Nine coefficients ring: opposite a strong orange lamp, red and green become negative before blue does. Channels that",
        "are clamped one by one leave blue blotches where the room is grey; the shader goes towards grey until no channel is negative.",
        "",
        "![An orange lamp in a grey room](pictures/gallery/clamp.jpg)",
    ]
    return lines


if __name__ == "__main__":
    main()
