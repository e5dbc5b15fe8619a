# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds a floor, a ball and a cube to bake and to change, and finds what is stale of them."""

import numpy as np
import pytest

from tests.operators.check.changes import select


@pytest.fixture
def stage(stage_under_sky):
    """Under a sky of six colours in all tests here."""
    return stage_under_sky


@pytest.fixture
def three(blender, stage):
    """A textured floor, a red ball and a cube without a material, none selected."""
    floor = stage.object_of("Floor", stage.grid(4, 3.0), stage.diffuse("Tiles"))
    floor.data.uv_layers.new()
    tree = floor.data.materials[0].node_tree
    texture = tree.nodes.new("ShaderNodeTexImage")
    texture.image = stage.picture("Texels", np.random.default_rng(1).random((4, 4, 3)))
    shader = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeBsdfDiffuse")
    tree.links.new(texture.outputs["Color"], shader.inputs["Color"])
    ball = stage.object_of("Ball", stage.icosphere(2), stage.diffuse("Red", (0.8, 0.1, 0.1)), (0, 0, 1.5))
    cube = stage.object_of("Cube", stage.cube(0.5), None, (1.5, 0, 0.5))
    return floor, ball, cube


@pytest.fixture
def bake(blender, scene):
    """Bake all, or some, with the scene's settings."""

    def run(mode, *objects):
        scene.prt.mode, scene.prt.samples = mode, 8
        select(blender, *objects)
        blender.ops.prt.bake()
        select(blender)

    return run


@pytest.fixture
def stale(blender, part):
    """The causes of all stale objects, by name; the others must be fresh."""

    def find():
        blender.context.view_layer.update()
        meshes = [ob for ob in blender.context.scene.objects if ob.type == "MESH"]
        found = part("freshness").freshness(blender.context, meshes)
        assert {one.state for one in found} <= {"FRESH", "STALE"}
        return {one.name: set(one.causes) for one in found if one.state == "STALE"}

    return find
