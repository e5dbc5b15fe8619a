# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes whose corners lie inside other geometry, as people build them, look in EEVEE as in Cycles."""

import numpy as np
import pytest


def box(stage, name, material, centre, size):
    ob = stage.object_of(name, stage.cube(1.0), material, centre)
    ob.scale = size
    return ob


@pytest.mark.parametrize("mode", ["SHADOWED", "INTERREFLECTED"])
def test_road_between_kerbs(blender, scene, stage, tmp_path, mode):
    """A road of one quad, whose corners lie in its kerbs, seen from above: 100 % off where they stay black."""
    grey, white = stage.diffuse("Grey", (0.5, 0.5, 0.5)), stage.diffuse("White", (0.8, 0.8, 0.8))
    stage.object_of("Road", stage.grid(1, 1.0), grey).scale = (10, 2, 1)
    for y in (-2.0, 2.0):
        box(stage, f"Kerb {y}", white, (0, y, 0.05), (20.5, 0.6, 0.5))
    world, _ = stage.environment(stage.picture("Six", stage.six_coloured_sky()))
    world.cycles.sampling_method = "NONE"
    stage.top_camera(scale=3.3)
    blender.ops.prt.bake(mode=mode, samples=512, bounces=2)
    ours = stage.render(tmp_path / "ours.exr")[..., :3]
    scene.cycles.max_bounces = scene.cycles.diffuse_bounces = 2 if mode == "INTERREFLECTED" else 0
    truth = stage.render(tmp_path / "truth.exr", "CYCLES", samples=64)[..., :3]
    error = np.sqrt(((ours - truth) ** 2).mean() / (truth**2).mean())
    assert error < 0.15, f"{error:.1%}"
