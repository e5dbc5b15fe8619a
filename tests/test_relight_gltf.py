# SPDX-License-Identifier: GPL-3.0-or-later
"""The worked example outside Blender, docs/examples/relight_gltf.py, gives Blender's and EEVEE's numbers."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

EXAMPLE = Path(__file__).resolve().parent.parent / "docs" / "examples" / "relight_gltf.py"
COLOUR = (0.8, 0.5, 0.2)


@pytest.fixture
def shaded(blender, tmp_path):
    """Export, run the example in a process that cannot import bpy, and return positions and colours."""

    def run(name, **options):
        path = tmp_path / name
        blender.ops.export_scene.gltf(filepath=str(path), use_selection=True, **options)
        alone = "import sys, runpy; sys.modules['bpy'] = None; runpy.run_path(sys.argv[0], run_name='__main__')"
        command = [sys.executable, "-c", f"import sys; sys.argv = sys.argv[1:]; {alone}"]
        subprocess.run([*command, EXAMPLE, path, tmp_path / "shaded.npz"], check=True, capture_output=True)
        with np.load(tmp_path / "shaded.npz") as found:
            return found["positions"], found["colours"]

    return run


def nearest(points, positions):
    """For each point the index of the position there; all must be there."""
    distance = np.linalg.norm(points[:, None] - positions, axis=-1)
    assert distance.min(axis=1).max() < 1e-5
    return distance.argmin(axis=1)


def principled(blender):
    """A material whose colour the exporter reads; without gloss, which it does not export."""
    from headless import use_nodes

    material = blender.data.materials.new("Clay")
    use_nodes(material)
    inputs = material.node_tree.nodes["Principled BSDF"].inputs
    inputs["Base Color"].default_value, inputs["Specular IOR Level"].default_value = (*COLOUR, 1.0), 0.0
    return material


def sky(stage, strength=1.5):
    _, mapping = stage.environment(stage.picture("Six", stage.six_coloured_sky()), strength=strength)
    mapping.inputs["Rotation"].default_value = (0.4, -0.9, 2.3)


@pytest.mark.slow
def test_every_pixel_of_eevee(blender, part, scene, stage, shaded, tmp_path):
    """A floor whose vertices are the camera's pixels and a ring more, under a roof just out of sight: the same colours within 1e-3."""
    pixels = 32
    floor = stage.object_of("Floor", stage.grid(pixels + 1, 1.5 * (1.0 + 1.0 / pixels)), principled(blender))
    stage.object_of("Wall", stage.grid(2, 1.6), None, (-1.55, 0.0, 0.5)).rotation_euler.y = np.pi / 2
    stage.top_camera(scale=3.0, resolution=pixels)
    sky(stage)
    floor.select_set(True)
    blender.context.view_layer.objects.active = floor
    blender.ops.prt.bake(mode="SHADOWED", samples=64)
    frame = stage.render(tmp_path / "frame.exr")[..., :3]
    positions, colours = shaded("floor.glb")
    points = stage.pixel_points(scale=3.0, resolution=pixels).reshape(-1, 2)
    rows = nearest(np.concatenate([points, np.zeros((len(points), 1))], axis=1), positions)
    difference = np.abs(colours[rows] - frame.reshape(-1, 3))
    assert np.ptp(colours, axis=0).min() > 0.05, "shadows fall on it"
    print(f"difference {difference.max() / colours.max():.1e}")
    assert difference.max() < 1e-3 * colours.max()


@pytest.mark.parametrize("space, form", [("SCENE", "GLB"), ("OBJECT", "GLTF_SEPARATE")])
def test_every_vertex_of_a_turned_object(blender, part, scene, stage, shaded, space, form):
    """Flat faces, a turned and scaled object, either space, either kind of file: as NumPy has it inside Blender."""
    from mathutils import Euler

    cube = stage.object_of("Cube", stage.cube(1.0), principled(blender), (1.0, -2.0, 0.5))
    cube.rotation_euler, cube.scale = (0.3, 1.1, -0.7), (1.0, 2.0, 0.5)
    cube.prt.space = space
    stage.object_of("Roof", stage.grid(2, 2.0), None, (1.0, -2.0, 2.5))
    sky(stage)
    cube.select_set(True)
    blender.context.view_layer.objects.active = cube
    blender.ops.prt.bake(mode="SHADOWED", samples=64)
    positions, colours = shaded("cube.glb" if form == "GLB" else "cube.gltf", export_format=form)
    axes = np.array(Euler((0.3, 1.1, -0.7)).to_matrix()) if space == "OBJECT" else np.eye(3)
    light = part("rotation").rotation_matrix(axes.T) @ part("light").shown_light(scene.world)
    radiance = stage.without_negatives(np.einsum("nic,ic->nc", part("layers").read(cube.data), light))
    matrix = np.array(cube.matrix_world)
    corners = np.array([cube.data.vertices[loop.vertex_index].co for loop in cube.data.loops])
    corners = corners @ matrix[:3, :3].T + matrix[:3, 3]
    assert len(positions) == len(corners) == 24
    for point, wanted in zip(corners, radiance, strict=True):
        here = np.linalg.norm(positions - point, axis=1) < 1e-5
        assert here.sum() == 3
        assert np.abs(colours[here] / COLOUR - wanted).max(axis=1).min() < 1e-3 * radiance.max()
