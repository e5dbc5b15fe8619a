# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials without nodes show their viewport colour, relit and in Cycles, and have none again afterwards."""

import numpy as np
import pytest


def test_material_without_nodes_keeps_its_colour_and_gets_them_off_again(blender, part, scene, stage, tmp_path):
    """Before 5.0 a material can be its viewport colour alone: shown, bounced, and given back so; Cycles shows it, too."""
    if blender.app.version >= (5, 0, 0):
        pytest.skip("all materials have nodes")
    material = blender.data.materials.new("Plain")
    material.diffuse_color = (0.1, 0.2, 0.3, 1.0)
    ob = stage.object_of("Cube", stage.cube(), material)
    stage.environment(stage.picture("Sky", stage.six_coloured_sky(16)))
    stage.top_camera(resolution=16)
    before = stage.render(tmp_path / "before.exr", "CYCLES", 4)
    part("shading").add_shading([ob])
    np.testing.assert_array_equal(stage.render(tmp_path / "after.exr", "CYCLES", 4), before)
    unbaked = stage.render(tmp_path / "unbaked.exr")[8, 8, :3]
    np.testing.assert_allclose(unbaked / unbaked.sum(), before[8, 8, :3] / before[8, 8, :3].sum(), atol=0.03)
    group = next(node for node in part("our_nodes").our_nodes(material.node_tree) if node.type == "GROUP")
    assert tuple(group.inputs["Base Color"].default_value) == tuple(material.diffuse_color)
    albedo = (
        part("read")
        .read_bake(blender.context, [ob], part("problem").BakeSettings("INTERREFLECTED"))
        .scene.occluders.albedo
    )
    assert tuple(albedo.constant[0]) == tuple(material.diffuse_color)[:3]
    material.diffuse_color = (0.4, 0.2, 0.1, 1.0)
    blender.context.view_layer.update()
    part("follow_surface").follow_surface(material)
    recoloured = stage.render(tmp_path / "recoloured.exr", "CYCLES", 4)[8, 8, :3]
    np.testing.assert_allclose(recoloured / before[8, 8, :3], (4, 1, 1 / 3), rtol=1e-3)
    part("shading").remove_shading([ob])
    assert not part("nodes").nodes_are_on(material)
    assert not list(part("our_nodes").our_nodes(material.node_tree))
