# SPDX-License-Identifier: GPL-3.0-or-later
"""The path tracer that bakes are judged by gives closed forms, quadrature, and what a bake without loss gives."""

import numpy as np
import pytest

from prt_addon.core.problem import BakeSettings, Occluders, ReceiverGroup
from prt_addon.core.report.path_tracer import Bounces, trace_light
from prt_addon.core.sky.projection import project_equirect
from prt_addon.core.sky.sampler import Skylight
from prt_addon.core.sphere import sh
from prt_addon.core.surface import Albedo
from prt_addon.core.transport.direct import Receivers
from prt_addon.core.transport.raycast import RayScene
from prt_addon.core.workers import Workers
from tests.core import shapes
from tests.core.baking import bake
from tests.core.references import hemisphere_quadrature, random_directions

SUN = (40, 50)  # texel


@pytest.fixture(scope="module")
def sunny():
    """A gradient with a sun of 3e4 times its brightness."""
    pixels = np.full((64, 128, 3), (0.2, 0.5, 1.0), dtype=np.float32) * np.linspace(0.2, 1.8, 64)[:, None, None]
    pixels = pixels.astype(np.float32)
    pixels[SUN] = 3e4
    return pixels


def receivers_at(points, normals):
    return Receivers(points, normals, np.arange(len(points)), np.full(len(points), 1e-4))


def solid_angle(row, height=64, width=128):
    return 2.0 * np.pi / width * np.diff(np.sin(np.pi * (np.array([row, row + 1]) / height - 0.5)))[0]


def texel_direction(row, column, height=64, width=128):
    azimuth, elevation = 2.0 * np.pi * (0.5 - (column + 0.5) / width), np.pi * ((row + 0.5) / height - 0.5)
    ring = np.cos(elevation)
    return np.array([ring * np.cos(azimuth), ring * np.sin(azimuth), np.sin(elevation)])


def test_constant_sky_shows_its_radiance_and_the_closed_form():
    """An open receiver under c shows c, and its transport is the cosine's."""
    normals = random_directions(50)
    sky = Skylight(np.full((1, 16, 32, 3), (0.25, 0.5, 2.0), dtype=np.float32), np.eye(3))
    found = trace_light(None, receivers_at(normals, normals), sky, 1024, 1)
    np.testing.assert_allclose(found.radiance[:, 0], np.tile((0.25, 0.5, 2.0), (50, 1)), rtol=0.01)
    wanted = sh.basis(normals, 6) * sh.per_coefficient(sh.cosine_lobe(6)) / np.pi
    np.testing.assert_allclose(found.transport, np.repeat(wanted[..., None], 3, axis=-1), atol=0.01)


def test_a_sun_is_found_by_few_paths(sunny):
    """Open receivers, against quadrature of the gradient and the sun's own texel: 64 paths are within a percent."""
    normals = random_directions(64, seed=4)
    sky = Skylight(sunny[None], np.eye(3))
    found = trace_light(None, receivers_at(normals, normals), sky, 64, 1).radiance[:, 0]
    dark = sunny.copy()
    dark[SUN] = sunny[SUN[0], 0]
    rest = Skylight(dark[None], np.eye(3))
    wanted = np.empty_like(found)
    for x, normal in enumerate(normals):
        directions, weights = hemisphere_quadrature(normal, 64)
        cosine = directions @ normal / np.pi
        wanted[x] = (rest.radiance(directions)[:, 0] * (weights * cosine)[:, None]).sum(axis=0)
        height = max(normal @ texel_direction(*SUN), 0.0)
        wanted[x] += (sunny[SUN] - dark[SUN]) * solid_angle(SUN[0]) * height / np.pi
    assert np.sqrt(((found - wanted) ** 2).mean() / (wanted**2).mean()) < 0.01


def test_agrees_with_a_bake_that_loses_nothing():
    """A sky of order 2, bounces in colour, shading normals: the baked dot product, without bias."""
    vertices, triangles = shapes.joined(shapes.bumpy_sphere(4), shapes.grid(16, 6.0))
    vertices[-17 * 17 :, 2] -= 1.8
    normals = shapes.vertex_normals(vertices, triangles)
    albedo = Albedo(np.tile((0.9, 0.5, 0.2), (len(triangles), 1)))
    occluders = Occluders(vertices, triangles, triangles.astype(np.int64), albedo)
    directions = np.stack([texel_direction(row, column) for row in range(64) for column in range(128)])
    light = np.random.default_rng(5).normal(size=(9, 3))
    light[0] = 8.0
    pixels = (sh.basis(directions) @ light).reshape(64, 128, 3).astype(np.float32)
    group = ReceiverGroup("both", vertices, normals, 3.0)
    [transport] = bake([group], occluders, BakeSettings("INTERREFLECTED", 1024, bounces=2))
    wanted = np.einsum("nic,ic->nc", transport, project_equirect(pixels))
    scene = RayScene(vertices, triangles)
    bounces = Bounces(
        2, scene.normalised(vertices)[triangles], normals[triangles], np.ones(len(triangles), dtype=bool), albedo
    )
    chosen = np.arange(0, len(vertices), 11)
    found = trace_light(
        scene,
        receivers_at(scene.normalised(vertices[chosen]), normals[chosen]),
        Skylight(pixels[None], np.eye(3)),
        256,
        1,
        bounces,
    ).radiance[:, 0]
    error = found - wanted[chosen]
    assert np.abs(error.mean(axis=0) / wanted.mean(axis=0)).max() < 0.005
    assert np.sqrt((error**2).mean() / (wanted**2).mean()) < 0.05
    unbounced = bake([group], occluders, BakeSettings("SHADOWED", 64))[0]
    lost = wanted - np.einsum("ni,ic->nc", unbounced, project_equirect(pixels))
    assert (lost.mean(axis=0) / wanted.mean(axis=0)).max() > 0.05, "bounces matter here"


def test_band_limited_skies_differ_by_the_sky_alone(sunny):
    """Projected paths hold the same noise: a sky of order 2 looked up, and its nine numbers, agree path by path."""
    vertices, triangles = shapes.bumpy_sphere(4)
    normals = shapes.vertex_normals(vertices, triangles)
    scene = RayScene(vertices, triangles)
    some = receivers_at(scene.normalised(vertices[::100]), normals[::100])
    directions = np.stack([texel_direction(row, column, 256, 512) for row in range(256) for column in range(512)])
    light = project_equirect(sunny)
    smooth = (sh.basis(directions) @ light).reshape(256, 512, 3).astype(np.float32)
    found = trace_light(scene, some, Skylight(smooth[None], np.eye(3)), 16, 1)
    projected = np.einsum("nkc,kc->nc", found.transport[:, :9], light)
    np.testing.assert_allclose(found.radiance[:, 0], projected, atol=5e-3 * np.abs(projected).max())


def test_same_bits_for_any_number_of_threads(sunny):
    """And others for another seed."""
    vertices, triangles = shapes.torus()
    normals = shapes.vertex_normals(vertices, triangles)
    scene = RayScene(vertices, triangles)
    some = receivers_at(scene.normalised(vertices), normals)
    bounces = Bounces(
        1,
        scene.normalised(vertices)[triangles],
        normals[triangles],
        np.ones(len(triangles), dtype=bool),
        Albedo(np.full((len(triangles), 3), 0.5)),
    )
    sky = Skylight(sunny[None], np.eye(3))
    one, two, other = (
        trace_light(scene, some, sky, 64, seed, bounces, workers=Workers(threads))
        for threads, seed in ((1, 1), (3, 1), (2, 2))
    )
    assert np.array_equal(one.radiance, two.radiance) and np.array_equal(one.transport, two.transport)
    assert not np.array_equal(one.radiance, other.radiance)
