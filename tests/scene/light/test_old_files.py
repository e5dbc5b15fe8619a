# SPDX-License-Identifier: GPL-3.0-or-later
"""Files whose light was stored before lamps were taken out of skies render as they do with the light of today."""

import numpy as np
import pytest

RESOLUTION = 32


@pytest.fixture
def lit(blender, stage):
    """A baked ball under a sky and a sun of the user's; returns the world."""
    world, _ = stage.environment(stage.picture("Six", stage.six_coloured_sky()), 0.5)
    stage.object_of("Ball", stage.icosphere(4), stage.diffuse("White", (0.8, 0.8, 0.8)))
    lamp = blender.data.objects.new("Lamp", blender.data.lights.new("Lamp", "SUN"))
    lamp.rotation_euler = (0.6, 0.0, 0.3)
    blender.context.scene.collection.objects.link(lamp)
    stage.top_camera(resolution=RESOLUTION)
    assert blender.ops.prt.bake(mode="SHADOWED", samples=64, lamps="NONE") == {"FINISHED"}
    return world


def as_of_old(world, strength):
    """Store a light as it once was: threes of numbers without a fourth, and one number for the strength, driven as such."""
    for name in [*(f"prt_light_{i}" for i in range(9)), *(f"prt_turn_{axis}" for axis in "xyz")]:
        world[name] = list(world[name])[:3]
    world.driver_remove('["prt_strength"]')
    world["prt_strength"] = strength
    driver = world.driver_add('["prt_strength"]').driver
    variable = driver.variables.new()
    variable.name, target = "s", variable.targets[0]
    target.id_type, target.id = "WORLD", world
    background = next(node for node in world.node_tree.nodes if node.bl_idname == "ShaderNodeBackground")
    target.data_path = f'node_tree.nodes["{background.name}"].inputs[1].default_value'
    driver.expression = "s"


def background_of(world):
    return next(node for node in world.node_tree.nodes if node.bl_idname == "ShaderNodeBackground")


def test_a_strength_of_one_number(blender, part, stage, lit, tmp_path):
    """The same frame, with the user's lamp, at the strength that the file was saved with and at another; once reloaded, too."""
    path = str(tmp_path / "old.blend")
    wanted = {}
    for strength in (0.5, 1.5):
        background_of(lit).inputs["Strength"].default_value = strength
        wanted[strength] = stage.render(tmp_path / f"new {strength}.exr")
    assert np.abs(wanted[1.5] - wanted[0.5])[..., :3].max() > 0.5
    background_of(lit).inputs["Strength"].default_value = 0.5
    as_of_old(lit, 0.5)
    np.testing.assert_allclose(stage.render(tmp_path / "old.exr"), wanted[0.5], atol=2e-3)
    blender.ops.wm.save_as_mainfile(filepath=path)
    blender.ops.wm.open_mainfile(filepath=path)
    world = blender.context.scene.world
    assert isinstance(world["prt_strength"], float) and part("light").has_light(world)
    for strength, frame in wanted.items():
        background_of(world).inputs["Strength"].default_value = strength
        np.testing.assert_allclose(stage.render(tmp_path / f"loaded {strength}.exr"), frame, atol=2e-3)
        assert part("light").strength_of(world) == pytest.approx(strength, rel=1e-6)  # drivers write single precision


def test_the_next_projection_brings_it_up_to_date(blender, part, stage, lit, tmp_path):
    """Without another bake, and with the same frame."""
    wanted = stage.render(tmp_path / "new.exr")
    as_of_old(lit, 0.5)
    assert part("light_state").light_state(lit).text == "Light is fresh"
    blender.ops.prt.project_light(lamps="NONE")
    assert len(lit["prt_strength"]) == 4
    np.testing.assert_allclose(stage.render(tmp_path / "again.exr"), wanted, atol=2e-3)
