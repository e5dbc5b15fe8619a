# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the homework on the energy of rough metal: its tables as pictures, and spheres in a white furnace, beside Cycles."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import frames
import headless
import numpy as np
import numpy.typing as npt
from headless import bmesh, bpy
from PIL import Image, ImageDraw

from prt_addon.core.microfacet import compensation
from prt_addon.core.microfacet.albedo import by_ggx_sampling, by_quadrature, by_uniform_sampling
from prt_addon.core.microfacet.table import average_albedo, energy_table

ROUGHNESS = tuple(np.arange(1, 11) / 10.0)
SILVER, COPPER = np.array([1.0, 1.0, 1.0]), np.array([0.95, 0.64, 0.54])
SKY = 0.6
"""Radiance of the furnace: what is darker than the background has lost light."""
TABLE = 65
_PIXELS, _CAPTION, _SAMPLES = 72, 16, 64
_RAYS = 100_000

Sphere = Callable[[float, npt.NDArray[Any]], npt.NDArray[Any]]
"""Radiance (pixels, pixels, 3) of a sphere of a roughness and a colour under a sky of 1; 1 beside it."""


def draw(folder: Path) -> list[Path]:
    """Write tables and spheres, and print how far the spheres are from Cycles'; returns the pictures."""
    made = [*tables(folder), folder / "furnace.png"]
    cycles = Cycles(folder)
    rows: list[tuple[str, Sphere, npt.NDArray[Any]]] = [
        ("one bounce", one_bounce, SILVER),
        ("with the light of all bounces", all_bounces, SILVER),
        ("Cycles, multiscatter GGX", cycles, SILVER),
        ("one bounce", one_bounce, COPPER),
        ("with the light of all bounces", all_bounces, COPPER),
        ("as the course colours it", course_bounces, COPPER),
        ("Cycles, multiscatter GGX", cycles, COPPER),
    ]
    shown = [[sphere(roughness, colour) for roughness in ROUGHNESS] for _, sphere, colour in rows]
    sheet([caption for caption, *_ in rows], shown).save(made[-1], optimize=True)
    print("roughness, what copper returns of light from everywhere: one bounce, all bounces, the course's, Cycles'")
    for roughness, *spheres in zip(ROUGHNESS, *shown[3:], strict=True):
        print(f"{roughness:.1f}", *(np.round(sphere[_disc()[0]].mean(axis=0), 3) for sphere in spheres))
    print_variances()
    return made


def print_variances() -> None:
    """How far single samples of E(mu) scatter, directions uniform or normals drawn as GGX spreads them."""
    print("mu, roughness, E: by quadrature, uniform directions, GGX normals; variance of one sample")
    for mu in (0.1, 0.5, 0.9):
        for roughness in (0.2, 0.5, 1.0):
            exact = by_quadrature(mu, roughness).white
            found = [sample(mu, roughness, _RAYS) for sample in (by_uniform_sampling, by_ggx_sampling)]
            means = (f"{one.value:.4f} +- {one.standard_error:.4f} ({one.variance:.3g})" for one in found)
            print(f"{mu:.1f} {roughness:.1f} {exact:.4f}", *means)


def tables(folder: Path) -> list[Path]:
    """E(mu), E_avg and the split sum: mu along columns, roughness along rows, from 0 at the top left to 1."""
    energy = energy_table(TABLE)
    average = np.broadcast_to(energy.average[:, None], (TABLE, TABLE))
    split = np.stack([energy.albedo.scale, energy.albedo.bias, np.zeros_like(average)], axis=-1)
    pictures = {"GGX_E_LUT": energy.albedo.white, "GGX_Eavg_LUT": average, "GGX_AB_LUT": split}
    for name, values in pictures.items():
        Image.fromarray(np.rint(255.0 * np.clip(values, 0.0, 1.0)).astype(np.uint8)).save(folder / f"{name}.png")
    return [folder / f"{name}.png" for name in pictures]


def one_bounce(roughness: float, colour: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Light that has met one mirror: `F E(mu)`, F the same at all angles."""
    shown, mu = _disc()
    return _on_sky(shown, colour * _albedo(mu, roughness))


def all_bounces(roughness: float, colour: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """And all other light."""
    return _compensated(roughness, colour, compensation.bounce_colour(colour, average_albedo(roughness)))


def course_bounces(roughness: float, colour: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """The same with the course's colour."""
    return _compensated(roughness, colour, compensation.course_bounce_colour(colour, average_albedo(roughness)))


def _compensated(roughness: float, colour: npt.NDArray[Any], bounce: npt.NDArray[Any]) -> npt.NDArray[Any]:
    shown, mu = _disc()
    albedo = _albedo(mu, roughness)
    return _on_sky(shown, colour * albedo + bounce * (1.0 - albedo))


def _albedo(mu: npt.NDArray[Any], roughness: float) -> npt.NDArray[Any]:
    """(pixels, 1) E, between a hundred cosines."""
    cosines = np.linspace(0.1, 1.0, 100)
    return np.interp(mu, cosines, by_quadrature(cosines, roughness).white)[:, None]


class Cycles:
    """A sphere of multiscatter GGX, path-traced."""

    def __init__(self, folder: Path) -> None:
        self._picture = folder / "sphere.exr"
        bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
        scene = self._scene = bpy.context.scene
        scene.world = bpy.data.worlds.new("Furnace")
        headless.use_nodes(scene.world)
        scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
        self._shader = _sphere(scene)
        camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
        scene.collection.objects.link(camera)
        camera.location, camera.data.type, camera.data.ortho_scale = (0.0, 0.0, 9.0), "ORTHO", 2.0
        scene.camera, scene.render.engine = camera, "CYCLES"
        scene.render.resolution_x = scene.render.resolution_y = _PIXELS
        scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.use_adaptive_sampling = _SAMPLES, False, False
        scene.cycles.pixel_filter_type, scene.cycles.filter_width = "GAUSSIAN", 0.01  # the middle of each pixel

    def __call__(self, roughness: float, colour: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """A `Sphere`."""
        self._shader.inputs["Roughness"].default_value = roughness
        self._shader.inputs["Color"].default_value = (*colour, 1.0)
        shown, _ = _disc()
        return _on_sky(shown, frames.render_linear(self._scene, self._picture)[shown][:, :3])


def _sphere(scene: bpy.types.Scene) -> bpy.types.ShaderNode:
    """A smooth sphere of radius 1 in the scene; returns its shader."""
    mesh = bpy.data.meshes.new("Sphere")
    bm = bmesh.new()
    bmesh.ops.create_icosphere(bm, subdivisions=6, radius=1.0)
    bm.to_mesh(mesh)
    bm.free()
    mesh.polygons.foreach_set("use_smooth", [True] * len(mesh.polygons))
    scene.collection.objects.link(bpy.data.objects.new("Sphere", mesh))
    material = bpy.data.materials.new("Metal")
    headless.use_nodes(material)
    mesh.materials.append(material)
    tree = material.node_tree
    shader = tree.nodes.new("ShaderNodeBsdfAnisotropic")
    shader.distribution = "MULTI_GGX"
    tree.links.new(shader.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
    return shader


def _disc() -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
    """Which pixels show the sphere, and the cosine between its normal and the view at each of these."""
    line = (np.arange(_PIXELS) + 0.5) / _PIXELS * 2.0 - 1.0
    radius2 = line[:, None] ** 2 + line**2
    shown = radius2 < 0.98
    return shown, np.sqrt(1.0 - radius2[shown])


def _on_sky(shown: npt.NDArray[Any], radiance: npt.NDArray[Any]) -> npt.NDArray[Any]:
    picture = np.ones((_PIXELS, _PIXELS, 3))
    picture[shown] = radiance
    return picture


def sheet(captions: list[str], rows: list[list[npt.NDArray[Any]]]) -> Image.Image:
    """Rows of spheres under their captions."""
    height = _PIXELS + _CAPTION
    whole = Image.new("RGB", (_PIXELS * len(ROUGHNESS), height * len(rows) + _CAPTION), "white")
    draw = ImageDraw.Draw(whole)
    for number, (caption, spheres) in enumerate(zip(captions, rows, strict=True)):
        draw.text((4, number * height + 2), caption, fill="black")
        strip = np.clip(SKY * np.concatenate(spheres, axis=1), 0.0, 1.0) ** (1.0 / 2.2)
        whole.paste(Image.fromarray(np.rint(255.0 * strip).astype(np.uint8)), (0, number * height + _CAPTION))
    for column, roughness in enumerate(ROUGHNESS):
        draw.text((column * _PIXELS + 4, height * len(rows) + 2), f"roughness {roughness:.1f}"[-3:], fill="black")
    return whole
