# SPDX-License-Identifier: GPL-3.0-or-later
"""The light of the world goes with exported glTF, in the extras of the scene; lamps of the sky are in it."""

import json

import numpy as np
import pytest

from tests.scene.export.conftest import COLOUR, DOCS


def test_the_light_goes_with_it(part, scene, ball, exported, example, tmp_path):
    """In the scene's extras: light, turn and strength, by which the file shades as Blender's numbers do."""
    document, _ = exported(tmp_path / "scene.glb")
    extras = document["scenes"][0]["extras"]["prt_relight"]
    light = part("light")
    np.testing.assert_allclose(extras["light"], light.read_light(scene.world))
    np.testing.assert_allclose(np.transpose(extras["turn"]), light.read_turn(scene.world), atol=1e-6)
    assert not np.any(extras["lamps"])
    assert extras["strength"] == pytest.approx(1.5) and extras["order"] == 2
    [mesh] = [mesh for mesh in example.read_baked(tmp_path / "scene.glb") if len(mesh.positions) > 24]
    shaded = example.relight(mesh, extras) / COLOUR
    wanted = np.einsum("nic,ic->nc", part("layers").read(ball.data), light.shown_light(scene.world))
    assert shaded.mean(axis=0) == pytest.approx(np.maximum(wanted, 0.0).mean(axis=0), rel=0.02)


def test_the_part_of_lamps_goes_with_it(scene, part, ball, exported, tmp_path):
    """As the world stores it; the light beside it stays whole."""
    light = part("light")
    whole, lamps = light.read_light(scene.world), np.linspace(0.1, 0.9, 9)
    light.store_light(scene.world, whole, lamps)
    for name, channel in zip(light.TURN, (0.5, 0.25, 0.125), strict=True):
        scene.world[name] = [*list(scene.world[name])[:3], 1.0 + channel]
    document, _ = exported(tmp_path / "lamps.glb")
    extras = document["scenes"][0]["extras"]["prt_relight"]
    np.testing.assert_allclose(extras["lamps"], np.multiply.outer(lamps, (0.5, 0.25, 0.125)), rtol=1e-6)
    np.testing.assert_allclose(extras["light"], whole, rtol=1e-6)


def test_lamps_of_the_sky_are_not_exported_as_lights(blender, part, scene, stage, exported, tmp_path):
    """The light is whole, and says what they show; so they are not exported as lights, as the user's own lamp is."""
    stage.environment(stage.picture("Sunny", stage.sunny_sky()), 0.5)
    stage.object_of("Ball", stage.icosphere(2, 0.6), None, (0.0, 0.0, 1.2))
    blender.ops.prt.bake(mode="UNSHADOWED", lamps="ONE")
    own = blender.data.lights.new("Own", "SUN")
    scene.collection.objects.link(blender.data.objects.new("Own", own))
    document, _ = exported(tmp_path / "suns.glb", export_lights=True)
    [light] = document["extensions"]["KHR_lights_punctual"]["lights"]
    extras = document["scenes"][0]["extras"]["prt_relight"]
    assert light["name"] == "Own" and np.any(extras["lamps"])
    np.testing.assert_allclose(extras["lamps"], part("light").read_lamps(scene.world), rtol=1e-6)
    np.testing.assert_allclose(extras["light"], part("light").read_light(scene.world), rtol=1e-6)


def test_extras_hold_what_the_schema_says(scene, ball, exported, example, tmp_path):
    """With a light and without; the axes are those in which the exporter writes positions."""
    text = (DOCS / "formats.md").read_text(encoding="utf-8")
    schema = json.loads(next(block for block in text.split("```json\n")[1:] if "$schema" in block).split("```")[0])
    document, _ = exported(tmp_path / "scene.glb")
    extras = document["scenes"][0]["extras"]["prt_relight"]
    assert extras.keys() == schema["properties"].keys()
    assert extras["version"] == schema["properties"]["version"]["const"]
    assert extras["order"] == schema["properties"]["order"]["const"]
    assert extras["layout"] == ball.data["prt_bake"]["version"]
    assert np.shape(extras["light"]) == (9, 3) and np.shape(extras["turn"]) == np.shape(extras["axes"]) == (3, 3)
    ball.location = (1.0, 2.0, 3.0)
    document, _ = exported(tmp_path / "moved.glb")
    [node] = [node for node in document["nodes"] if node["name"] == "Ball"]
    np.testing.assert_allclose(np.transpose(extras["axes"]) @ (1.0, 2.0, 3.0), node["translation"])
    scene.world = None
    document, _ = exported(tmp_path / "dark.glb")
    assert document["scenes"][0]["extras"]["prt_relight"].keys() == {*schema["required"], "backs"}
