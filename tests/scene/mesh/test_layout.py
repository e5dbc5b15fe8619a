# SPDX-License-Identifier: GPL-3.0-or-later
"""The four floats of a layer mean the same to the bake that writes them and to the shader that reads them."""

import numpy as np
import pytest


@pytest.fixture
def sky(scene, stage):
    """A coloured sky, and a camera above."""
    stage.environment(stage.picture("Sky", stage.six_coloured_sky(32)))
    stage.top_camera(scale=4.0)


def floats(ob):
    """(9, elements, 4) the layers as they are stored."""
    layers = [ob.data.attributes[f"_PRT_{i}"].data for i in range(9)]
    found = np.empty((9, len(layers[0]), 4), dtype=np.float32)
    for layer, values in zip(layers, found, strict=True):
        layer.foreach_get("color", values.ravel())
    return found


def write_floats(ob, values):
    for i in range(9):
        ob.data.attributes[f"_PRT_{i}"].data.foreach_set("color", values[i].ravel())
    ob.data.update()


@pytest.mark.parametrize("space", ["SCENE", "OBJECT"])
def test_alpha_is_the_direct_part(blender, scene, stage, sky, space):
    """Of an interreflected bake it is, bit for bit, what a shadowed bake has in its colours."""
    ball = stage.object_of("Ball", stage.icosphere(2, 0.5), stage.diffuse(), (0, 0, 0.8))
    stage.object_of("Floor", stage.grid(8, 1.5), stage.diffuse("Floor", (0.9, 0.2, 0.1)))
    ball.prt.space = space
    blender.ops.prt.bake(mode="SHADOWED", samples=64)
    shadowed = floats(ball)
    blender.ops.prt.bake(mode="INTERREFLECTED", samples=64, bounces=2)
    bounced = floats(ball)
    mark = {"SCENE": 1, "OBJECT": 2}[space]
    np.testing.assert_array_equal(bounced[..., 3], shadowed[..., 3])
    np.testing.assert_array_equal(shadowed[1:, :, 3], shadowed[1:, :, 0])
    np.testing.assert_array_equal(shadowed[0, :, 3], shadowed[0, :, 0] - np.float32(mark))
    assert (bounced[0, :, 3] < 0.2822 - mark).all() and (bounced[0, :, 3] >= -mark).all()
    assert (bounced[0, :, 0] >= shadowed[0, :, 0]).all()
    if space == "SCENE":  # what moves alone bounces nothing but its own light
        assert bounced[0, :, 0].sum() > 1.05 * shadowed[0, :, 0].sum()


def test_joined_geometry_shows_its_own_material(blender, scene, stage, sky, tmp_path):
    """It has no transport: it must not turn black, nor take the rest along."""
    material = stage.diffuse()
    baked = stage.object_of("Baked", stage.icosphere(2, 0.6), material, (-0.9, 0, 0))
    blender.ops.prt.bake(mode="SHADOWED", samples=16)
    joined = stage.object_of("Joined", stage.icosphere(2, 0.6), None, (0.9, 0, 0))
    joined.data.materials.append(material)
    apart = stage.render(tmp_path / "apart.exr")
    assert apart[..., :3].max(axis=-1)[:, 40:].max() > 0.1
    with blender.context.temp_override(active_object=baked, selected_editable_objects=[baked, joined], object=baked):
        blender.ops.object.join()
    np.testing.assert_allclose(stage.render(tmp_path / "together.exr"), apart, atol=2e-3)


def test_bakes_of_version_1_keep_shading(blender, scene, stage, sky, tmp_path):
    """Beside bakes of this version, in the same material; with alpha 0, and 1 in the second layer of an object's own axes."""
    material = stage.diffuse()
    objects = [stage.object_of(f"Ball {x}", stage.icosphere(2, 0.4), material, (x, 0, 0)) for x in (-1.2, 0.0, 1.2)]
    objects[1].prt.space = objects[2].prt.space = "OBJECT"
    for ob in objects:
        ob.rotation_euler = (0.4, 0.2, 1.1)
    blender.ops.prt.bake(mode="SHADOWED", samples=16)
    now = stage.render(tmp_path / "now.exr")
    for ob, own_axes in ((objects[0], 0.0), (objects[1], 1.0)):
        values = floats(ob)
        values[..., 3] = 0.0
        values[1, :, 3] = own_axes
        write_floats(ob, values)
        ob.data["prt_bake"] = ob.data["prt_bake"].to_dict() | {"version": 1}
    np.testing.assert_allclose(stage.render(tmp_path / "before.exr"), now, atol=2e-3)
    assert now[..., :3].max() > 0.2


def test_mesh_without_transport_shows_its_own_material(blender, scene, stage, sky, tmp_path):
    """A black vertex of a bake is baked all the same: what no light reaches does not glow."""
    material = stage.diffuse()
    ob = stage.object_of("Ball", stage.icosphere(2), material)
    blender.ops.prt.bake(mode="SHADOWED", samples=16)
    values = floats(ob)
    values[..., :3] = 0.0
    values[..., 3] = 0.0
    values[0, :, 3] = -1.0
    write_floats(ob, values)
    assert stage.render(tmp_path / "black.exr")[32, 32, :3].max() < 1e-4
    values[0, :, 3] = 0.0
    write_floats(ob, values)
    assert stage.render(tmp_path / "own.exr")[32, 32, :3].max() > 0.05
