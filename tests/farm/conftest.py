# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the file that all farms bake."""

import pytest


@pytest.fixture
def blend(blender, scene, stage, tmp_path):
    """A saved scene of objects baked for the scene and by themselves, and its settings."""
    stage.environment(stage.picture("Sky", stage.six_coloured_sky(16)))
    stage.object_of("Floor", stage.grid(24, 2.0), stage.diffuse("Grey", (0.7, 0.7, 0.7)))
    stage.object_of("Ball", stage.icosphere(3, 0.6), stage.diffuse("Red", (0.9, 0.1, 0.1)), (0, 0, 0.7))
    moving = stage.object_of("Moving", stage.cube(), stage.diffuse("Blue", (0.1, 0.2, 0.9)), (1.2, 0, 1.5))
    moving.prt.space = "OBJECT"
    scene.prt.mode, scene.prt.samples, scene.prt.bounces, scene.prt.seed = "INTERREFLECTED", 48, 2, 5
    path = tmp_path / "my scene.blend"
    blender.ops.wm.save_as_mainfile(filepath=str(path))
    return path
