# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures what nine coefficients can show of a room at best: docs/order.md.

    python tools/order_bound.py [--page FILE]

Cycles draws the room under each of nine skies, the spherical harmonics themselves. Any picture of nine coefficients is a sum of these.
The sum that is nearest to the room under a real sky, found by least squares for each channel, is what no bake of that order can better.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

import frames
import gallery
import gallery_scenes
import headless
import numpy as np
import numpy.typing as npt
from headless import bpy, mathutils
from tqdm import tqdm

ROWS = 64
Picture = npt.NDArray[Any]
Sun = tuple[mathutils.Matrix, float, float, tuple[float, float, float]]

ABOUT = """\
# What nine coefficients can show of a room

Made by `make order`. The room of the [gallery](gallery.md#room) gets all its light through one window. Cycles draws it under each of the nine
spherical harmonics as a sky: whatever a bake of nine coefficients shows is a sum of these pictures. *At best* is the sum that is nearest to the
room under the real sky, chosen picture by picture with the truth at hand; *EEVEE* is what a bake shows with the light of the sky. With lamps,
their direct light, drawn by Cycles, is added to both. Numbers are the relative RMS difference from Cycles in linear light.

| HDRI | EEVEE | At best | EEVEE, with lamps | At best, with lamps |
|---|---|---|---|---|"""


def main() -> None:
    """Measure, and write the page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--page", type=Path, default=headless.CHECKOUT / "docs" / "order.md")
    page: Path = parser.parse_args().page.resolve()
    work = headless.CHECKOUT / "build" / "order"
    work.mkdir(parents=True, exist_ok=True)
    headless.enable_extension()
    try:
        page.write_text("\n".join([ABOUT, *rows(work), ""]))
    finally:
        headless.disable_extension()


def rows(work: Path) -> list[str]:
    """The table's, one for each HDRI."""
    scene = gallery.baked(gallery_scenes.room)
    scene.eevee.taa_render_samples = 16  # the shadows of wide lamps are soft
    basis = pictures_of_basis(scene, work)
    lines = []
    for hdri in tqdm(gallery.HDRIS, desc="Skies", file=sys.stdout):
        truth = gallery.truth(scene, hdri, work, gallery.SMALL_TRUTH_SAMPLES).linear
        cells = []
        for lamps in ("NONE", "AUTO"):
            shown = gallery.relit(scene, work, lamps).linear
            best = nearest_sum(truth, basis, light_of_lamps(scene, work))
            cells += [f"{frames.relative_rms(one, truth):.1%}" for one in (shown, best)]
        lines.append(f"| {hdri} | " + " | ".join(cells) + " |")
    return lines


def pictures_of_basis(scene: bpy.types.Scene, work: Path) -> Picture:
    """(height, width, 3, 9) the scene by Cycles under each spherical harmonic: where it is positive, less where it is negative."""
    texture, pictures = gallery.sky_texture(scene), []
    frames.use_cycles(scene)
    for harmonic in tqdm(np.moveaxis(harmonics(), -1, 0), desc="Harmonics", file=sys.stdout):
        drawn = []
        for sign in (1.0, -1.0):
            texture.image = panorama(np.maximum(sign * harmonic, 0.0))
            drawn.append(frames.render_linear(scene, work / "harmonic.exr")[..., :3].astype(np.float64))
        pictures.append(drawn[0] - drawn[1])
    return np.stack(pictures, axis=-1)


def harmonics() -> Picture:
    """(ROWS, 2 ROWS, 9) real spherical harmonics on a panorama, row 0 at the bottom; Cartesian, as in Ramamoorthi & Hanrahan 2001."""
    rows, columns = np.meshgrid(np.arange(ROWS), np.arange(2 * ROWS), indexing="ij")
    height, angle = np.pi * ((rows + 0.5) / ROWS - 0.5), 2.0 * np.pi * (0.5 - (columns + 0.5) / (2.0 * ROWS))
    x, y, z = np.cos(height) * np.cos(angle), np.cos(height) * np.sin(angle), np.sin(height)
    second = (1.092548 * x * y, 1.092548 * y * z, 0.315392 * (3.0 * z * z - 1.0), 1.092548 * x * z)
    first = (0.488603 * y, 0.488603 * z, 0.488603 * x)
    return np.stack([np.full_like(x, 0.282095), *first, *second, 0.546274 * (x * x - y * y)], axis=-1)


def panorama(values: Picture) -> bpy.types.Image:
    """A grey picture of (ROWS, 2 ROWS) radiances."""
    image = bpy.data.images.new("Harmonic", 2 * ROWS, ROWS, float_buffer=True)
    texels = np.ones((*values.shape, 4), dtype=np.float32)
    texels[..., :3] = values[..., None]
    image.pixels.foreach_set(texels.ravel())
    return image


def light_of_lamps(scene: bpy.types.Scene, work: Path) -> Picture:
    """(height, width, 3) the direct light of the lamps that stand for spots of the sky, by Cycles; black without any."""
    suns = [describe(ob) for ob in scene.objects if ob.type == "LIGHT"]
    if not suns:
        return np.zeros(3)
    sky, scene.world = scene.world, bpy.data.worlds.new("Black")
    headless.use_nodes(scene.world)
    scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.0
    made = [place(scene, sun) for sun in suns]
    frames.use_cycles(scene)
    scene.cycles.max_bounces = scene.cycles.diffuse_bounces = 0
    light = frames.render_linear(scene, work / "lamps.exr")[..., :3].astype(np.float64)
    bpy.data.batch_remove(made)
    scene.world = sky
    return light


def describe(ob: bpy.types.Object) -> Sun:
    """A sun's place, energy, angle and colour."""
    return ob.matrix_world.copy(), ob.data.energy, ob.data.angle, tuple(ob.data.color)


def place(scene: bpy.types.Scene, sun: Sun) -> bpy.types.Object:
    """A sun that Cycles sees, unlike those of a sky."""
    data = bpy.data.lights.new("Sun", "SUN")
    ob = bpy.data.objects.new("Sun", data)
    scene.collection.objects.link(ob)
    ob.matrix_world, data.energy, data.angle, data.color = sun
    return ob


def nearest_sum(truth: Picture, basis: Picture, added: Picture) -> Picture:
    """(height, width, 4) what is added, and the sum of nine pictures with which it is nearest to the truth, channel by channel."""
    surface, best = truth[..., 3] > 0.99, truth.astype(np.float64)
    wanted = truth[..., :3] - added
    for channel in range(3):
        columns = basis[:, :, channel]
        weights, *_ = np.linalg.lstsq(columns[surface], wanted[surface][:, channel], rcond=None)
        best[..., channel] = columns @ weights
    best[..., :3] += added
    return best


if __name__ == "__main__":
    main()
