# SPDX-License-Identifier: GPL-3.0-or-later
"""What tests of exported glTF share: a baked scene of two meshes, the export of it, and what reads the file."""

import importlib.util
from pathlib import Path

import pytest

COLOUR = (0.7, 0.3, 0.1)
DOCS = Path(__file__).resolve().parents[3] / "docs"


@pytest.fixture(scope="module")
def example():
    """The worked example, which reads such files with NumPy alone."""
    spec = importlib.util.spec_from_file_location("relight_gltf", DOCS / "examples" / "relight_gltf.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def principled(blender, name="Clay"):
    from headless import use_nodes

    material = blender.data.materials.new(name)
    use_nodes(material)
    material.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (*COLOUR, 1.0)
    return material


@pytest.fixture
def ball(blender, scene, stage):
    """A smooth ball over a flat box, baked and relit, under a turned sky: transport on points and on corners."""
    _, mapping = stage.environment(stage.picture("Six", stage.six_coloured_sky(64)), strength=1.5)
    mapping.inputs["Rotation"].default_value = (0.4, -0.9, 2.3)
    material = principled(blender)
    found = stage.object_of("Ball", stage.icosphere(2), material, (0, 0, 1))
    stage.object_of("Box", stage.cube(), material, (0, 0, -1.2))
    blender.ops.prt.bake(mode="SHADOWED", samples=32)
    return found


@pytest.fixture
def exported(blender, example):
    """Export; the document, and each mesh's attributes by the name of the mesh."""

    def run(path, **options):
        assert blender.ops.export_scene.gltf(filepath=str(path), **options) == {"FINISHED"}
        document, chunk = example._open(path)
        buffers = [example._buffer(buffer, chunk, path.parent) for buffer in document["buffers"]]
        return document, {
            mesh["name"]: {
                name: example._accessor(document, buffers, index)
                for name, index in mesh["primitives"][0]["attributes"].items()
            }
            for mesh in document["meshes"]
        }

    return run
