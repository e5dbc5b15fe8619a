# SPDX-License-Identifier: GPL-3.0-or-later
"""Exported glTF shows the light of now as vertex colours, if that is wanted, beside the user's own paint."""

import numpy as np
import pytest

from tests.scene.export.conftest import COLOUR


def test_the_persons_own_paint_stays(ball, exported, tmp_path):
    """As the exporter writes it, and numbered from 0; a mesh without paint has no vertex colours at all."""
    paint = ball.data.color_attributes.new("Paint", "BYTE_COLOR", "CORNER")
    paint.data.foreach_set("color", np.tile([0.2, 0.4, 0.6, 1.0], len(paint.data)))
    _, meshes = exported(tmp_path / "scene.glb")
    colours = {name for name in meshes["Sphere"] if name.startswith("COLOR_")}
    assert colours == {f"COLOR_{number}" for number in range(len(colours))} and colours
    found = [meshes["Sphere"][name][:, :3] for name in sorted(colours)]
    assert any(np.allclose(values, (0.2, 0.4, 0.6), atol=0.01) for values in found)
    assert len(colours) <= 2 and not any(name.startswith("COLOR_") for name in meshes["Cube"])


@pytest.mark.parametrize("transport", [True, False])
@pytest.mark.parametrize("space", ["SCENE", "OBJECT"])
def test_the_light_of_now_as_vertex_colours(blender, scene, part, ball, exported, example, tmp_path, space, transport):
    """As the example shades a file with transport, before the user's paint; with transport or without."""
    ball.prt.space, ball.rotation_euler = space, (0.5, 0.2, -1.0)
    scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.1
    blender.ops.prt.bake(mode="SHADOWED", samples=32)
    paint = ball.data.color_attributes.new("Paint", "BYTE_COLOR", "POINT")
    paint.data.foreach_set("color", np.tile([0.2, 0.4, 0.6, 1.0], len(paint.data)))
    document, _ = exported(tmp_path / "both.glb")
    [mesh] = [mesh for mesh in example.read_baked(tmp_path / "both.glb") if len(mesh.positions) > 24]
    wanted = example.relight(mesh, document["scenes"][0]["extras"]["prt_relight"]) / COLOUR
    scene.prt.gltf.light, scene.prt.gltf.transport = True, transport
    document, meshes = exported(tmp_path / "light.glb", export_apply=True)
    written = meshes["Sphere"]
    assert np.ptp(wanted, axis=0).min() > 0.05
    np.testing.assert_allclose(written["COLOR_0"][:, :3], np.minimum(wanted, 1.0), atol=1e-5)
    np.testing.assert_allclose(written["COLOR_1"][:, :3], np.tile((0.2, 0.4, 0.6), (len(wanted), 1)), atol=0.01)
    assert ("_PRT_0" in written) == transport
    assert ("prt_relight" in document["scenes"][0].get("extras", {})) == transport


def colours_of_nodes(example, path, marked):
    """(transport, `COLOR_0`) of all nodes whose meshes are in own axes, or of all whose are not."""
    document, chunk = example._open(path)
    buffers = [example._buffer(buffer, chunk, path.parent) for buffer in document["buffers"]]
    found = []
    for node in document["nodes"]:
        if "mesh" in node:
            [primitive] = document["meshes"][node["mesh"]]["primitives"]
            layers = example._layers(document, buffers, primitive, [f"_PRT_{i}" for i in range(9)], "scales")
            if (layers[0][0, 3] < -1.5) == marked:
                transport = np.stack([layer[:, :3] for layer in layers], axis=1)
                colours = primitive["attributes"].get("COLOR_0")
                found.append((transport, None if colours is None else example._accessor(document, buffers, colours)))
    return found


@pytest.fixture
def turned(blender, scene, ball):
    """The ball in its own axes: itself, a linked duplicate below a turned parent, and an instance of a collection; their matrices."""
    ball.prt.space, ball.rotation_euler = "OBJECT", (0.5, 0.2, -1.0)
    scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.1
    blender.ops.prt.bake(mode="SHADOWED", samples=32)
    parent = blender.data.objects.new("Parent", None)
    parent.rotation_euler, parent.scale = (0.3, 1.2, 0.4), (1.0, 2.0, 1.0)
    scene.collection.objects.link(parent)
    twin = ball.copy()
    twin.parent, twin.rotation_euler = parent, (0.0, 0.0, 0.0)
    scene.collection.objects.link(twin)
    inside = blender.data.collections.new("Inside")
    inside.objects.link(ball)
    inside.objects.link(blender.data.objects["Box"])
    instance = blender.data.objects.new("Instance", None)
    instance.instance_type, instance.instance_collection = "COLLECTION", inside
    instance.rotation_euler, instance.location = (1.0, 0.0, 2.0), (5.0, 0.0, 0.0)
    scene.collection.objects.link(instance)
    blender.context.view_layer.update()
    return [ball.matrix_world, twin.matrix_world, instance.matrix_world @ ball.matrix_world]


@pytest.mark.parametrize("precision", ["FLOAT", "SHORT"])
@pytest.mark.parametrize("yup", [True, False])
def test_each_turned_object_shows_its_own_light(
    scene, part, stage, turned, exported, example, tmp_path, yup, precision
):
    """They share their transport, and no colours; what is baked for the scene shows one light wherever it is instanced, as in EEVEE."""
    scene.prt.gltf.light, scene.prt.gltf.precision = True, precision
    document, _ = exported(tmp_path / "turned.glb", export_yup=yup)
    light, rotation = part("light").shown_light(scene.world), part("rotation").rotation_matrix
    found = colours_of_nodes(example, tmp_path / "turned.glb", marked=True)
    wanted = []
    for matrix in turned:
        axes = np.array(matrix)[:3, :3] / np.linalg.norm(np.array(matrix)[:3, :3], axis=0)
        seen = np.einsum("nic,ic->nc", found[0][0], rotation(axes.T) @ light)
        wanted.append(np.minimum(stage.without_negatives(seen), 1.0))
    assert len(found) == 3 and np.abs(wanted[0] - wanted[1]).max() > 0.05 < np.abs(wanted[1] - wanted[2]).max()
    for colours in wanted:
        assert sum(np.allclose(each[1][:, :3], colours, atol=1e-4) for each in found) == 1
    boxes = colours_of_nodes(example, tmp_path / "turned.glb", marked=False)
    assert len(boxes) == 2 and np.array_equal(boxes[0][1], boxes[1][1])
    layers = [mesh["primitives"][0]["attributes"]["_PRT_0"] for mesh in document["meshes"]]
    assert len(layers) == 4 and len(set(layers)) == 2
    axes = document["scenes"][0]["extras"]["prt_relight"]["axes"]
    assert (axes == np.eye(3).tolist()) != yup


def test_skinned_meshes_in_own_axes_are_left_out_by_name(blender, scene, stage, ball, exported, tmp_path, capfd):
    """As glTF puts them where their bones are, whatever the object's axes; the rest has its colours."""
    ball.prt.space = "OBJECT"
    scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.1
    blender.ops.prt.bake(mode="UNSHADOWED")
    ball.parent = bones = stage.rig()
    ball.modifiers.new("Armature", "ARMATURE").object = bones
    ball.vertex_groups.new(name="Bone").add(range(len(ball.data.vertices)), 1.0, "ADD")
    scene.prt.gltf.light = True
    capfd.readouterr()
    _, meshes = exported(tmp_path / "skinned.glb")
    assert "'Ball' has no light as vertex colors" in "".join(capfd.readouterr())
    assert "JOINTS_0" in meshes["Sphere"] and "COLOR_0" not in meshes["Sphere"] and "COLOR_0" in meshes["Cube"]


def test_a_world_without_light_is_said(scene, ball, exported, tmp_path, capfd):
    """No vertex colours then."""
    scene.prt.gltf.light, scene.world = True, None
    capfd.readouterr()
    _, meshes = exported(tmp_path / "dark.glb")
    assert "carries no light to export" in "".join(capfd.readouterr()) and "COLOR_0" not in meshes["Sphere"]
