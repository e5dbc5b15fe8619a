# SPDX-License-Identifier: GPL-3.0-or-later
"""Khronos' validator finds neither errors nor warnings in what File > Export > glTF 2.0 writes of bakes."""

import json
from pathlib import Path

import pytest

from tests.web.node import run_node

VALIDATE = Path(__file__).with_name("validate_gltf.mjs")
SEVERE = {0, 1}
"""Errors and warnings, as the validator numbers what it says."""


def complaints(path):
    """What the validator has to say against a file."""
    report = json.loads(run_node(VALIDATE, path))
    return [message for message in report["issues"]["messages"] if message["severity"] in SEVERE]


@pytest.fixture
def varied(blender, scene, stage):
    """Transport on points, on corners in own axes, on a carrier, on linked duplicates, and an instance of a collection; of backs, too."""
    stage.environment(stage.picture("Six", stage.six_coloured_sky(64)), strength=0.2)
    stage.object_of("Points", stage.icosphere(2), None, (0, 0, 1))
    own = stage.object_of("Own axes", stage.cube(), None, (3, 0, 0))
    own.prt.space, own.rotation_euler = "OBJECT", (0.5, 0.2, -1.0)
    stage.object_of("Sheet", stage.grid(3), None, (6, 0, 0))
    carried = stage.object_of("Carried", stage.cube(), None, (-3, 0, 0))
    carried.modifiers.new("Finer", "SUBSURF").render_levels = 1
    first = stage.object_of("First", stage.cube(), None, (0, 4, 0))
    second = first.copy()
    second.location.x, second.rotation_euler.z = 3.0, 1.0
    scene.collection.objects.link(second)
    inside = blender.data.collections.new("Inside")
    inside.objects.link(stage.object_of("Instanced", stage.icosphere(1), None, (0, -4, 0)))
    scene.collection.children.link(inside)
    instance = blender.data.objects.new("Instance", None)
    instance.instance_type, instance.instance_collection, instance.location = "COLLECTION", inside, (4, 0, 0)
    scene.collection.objects.link(instance)
    blender.ops.prt.bake(mode="SHADOWED", samples=16)


@pytest.mark.once
@pytest.mark.parametrize("precision", ["FLOAT", "SHORT"])
@pytest.mark.parametrize("light", [False, True])
@pytest.mark.parametrize("applied", [False, True])
@pytest.mark.parametrize("form", ["GLB", "GLTF_SEPARATE"])
def test_nothing_to_complain_about(blender, scene, varied, tmp_path, form, applied, light, precision):
    """With modifiers applied and not, with the light of now and without, in floats and in 16 bits, in one file and in several."""
    path = tmp_path / ("scene.glb" if form == "GLB" else "scene.gltf")
    scene.prt.gltf.light, scene.prt.gltf.precision = light, precision
    assert blender.ops.export_scene.gltf(filepath=str(path), export_format=form, export_apply=applied) == {"FINISHED"}
    assert b'"_PRT_8"' in path.read_bytes() and b'"_PRT_B2"' in path.read_bytes() and complaints(path) == []


def test_a_broken_file_is_complained_about(tmp_path):
    """The validator is really asked."""
    path = tmp_path / "broken.gltf"
    path.write_text('{"asset": {"version": "2.0"}, "scene": 3}', encoding="utf-8")
    assert complaints(path)
