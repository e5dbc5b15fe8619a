# SPDX-License-Identifier: GPL-3.0-or-later
"""File > Export > glTF writes transport, and materials as they were, by Blender's own settings."""

import re

import numpy as np
import pytest

from tests.scene.export.conftest import COLOUR, principled


@pytest.mark.parametrize("form", ["GLB", "GLTF_SEPARATE"])
def test_default_settings_carry_transport_bit_for_bit(blender, part, ball, exported, tmp_path, form):
    """As float attributes and nothing else of ours; other attributes stay at home as they do without us."""
    ball.data.attributes.new("_SECRET", "FLOAT", "POINT")
    _, meshes = exported(tmp_path / ("scene.glb" if form == "GLB" else "scene.gltf"), export_format=form)
    assert set(meshes) == {"Sphere", "Cube"}
    layers = part("layers")
    for ob in (ball, blender.data.objects["Box"]):
        written = meshes[ob.data.name]
        assert {name for name in written if not name.startswith("TEXCOORD")} == {"POSITION", "NORMAL", *layers.LAYERS}
        stored = {values.tobytes() for values in layers.read(ob.data)}
        found = np.stack([written[name][:, :3] for name in layers.LAYERS], axis=1).astype(np.float32)
        assert {values.tobytes() for values in found} == stored


def test_materials_are_the_persons_own_and_come_back(blender, stage, ball, exported, tmp_path):
    """Base colours are written; afterwards nodes, outputs and pixels are as they were."""
    tree = ball.data.materials[0].node_tree
    stage.top_camera()
    before, shown = stage.node_snapshot(tree), stage.render(tmp_path / "before.exr")
    document, _ = exported(tmp_path / "scene.glb")
    [material] = document["materials"]
    assert material["pbrMetallicRoughness"]["baseColorFactor"][:3] == pytest.approx(COLOUR, abs=1e-6)
    assert stage.node_snapshot(tree) == before
    np.testing.assert_array_equal(stage.render(tmp_path / "after.exr"), shown)


def test_a_failed_export_puts_the_materials_back(blender, stage, ball, tmp_path):
    """It calls no hook once it has failed."""
    tree = ball.data.materials[0].node_tree
    before = stage.node_snapshot(tree)
    in_the_way = tmp_path / "scene.glb"
    in_the_way.mkdir()
    with pytest.raises(Exception, match=r"."):
        blender.ops.export_scene.gltf(filepath=str(in_the_way))
    assert stage.node_snapshot(tree) == before


def test_linked_duplicates_share_one_mesh(blender, scene, part, ball, exported, tmp_path):
    """In their own axes, on corners: written once, with the mark of the axes, and shown by both nodes."""
    box = blender.data.objects["Box"]
    box.prt.space = "OBJECT"
    blender.ops.prt.bake(mode="UNSHADOWED")
    twin = box.copy()
    twin.location.x, twin.rotation_euler.z = 4.0, 1.0
    scene.collection.objects.link(twin)
    document, meshes = exported(tmp_path / "twins.glb")
    shown = [node["mesh"] for node in document["nodes"] if node["name"] in {box.name, twin.name}]
    assert len(shown) == 2 and len(set(shown)) == 1
    assert part("layers").domain_of(box.data) == "CORNER"
    assert (meshes[box.data.name]["_PRT_0"][:, 3] < -1.5).all() and (
        meshes[ball.data.name]["_PRT_0"][:, 3] > -1.5
    ).all()


def transport_of(example, path):
    """By the number of vertices, the transport of each mesh of a file and the light it shows."""
    light = example.read_light(path)
    return {len(mesh.positions): (mesh.transport, example.relight(mesh, light)) for mesh in example.read_baked(path)}


def test_sixteen_bits_are_half_the_bytes(blender, scene, part, ball, exported, example, tmp_path, capfd):
    """By scales in the extras it is the same transport in either axes but for the rounding, of which the report says how much it is."""
    blender.data.objects["Box"].prt.space = "OBJECT"
    blender.ops.prt.bake(mode="INTERREFLECTED", samples=32)
    exported(tmp_path / "float.glb")
    scene.prt.gltf.precision = "SHORT"
    capfd.readouterr()
    document, _ = exported(tmp_path / "short.glb")
    said = "".join(capfd.readouterr())
    for mesh in document["meshes"]:
        [primitive] = mesh["primitives"]
        for name in part("layers").LAYERS:
            accessor = document["accessors"][primitive["attributes"][name]]
            assert (accessor["componentType"], accessor["normalized"], accessor["type"]) == (5122, True, "VEC4")
            assert document["bufferViews"][accessor["bufferView"]]["byteLength"] == 8 * accessor["count"]
        assert np.shape(primitive["extras"]["prt_relight"]["scales"]) == (9, 2)
    wanted, found = (transport_of(example, tmp_path / f"{name}.glb") for name in ("float", "short"))
    assert wanted.keys() == found.keys() and len(wanted) == 2
    error = sum(((found[n][0] - wanted[n][0]) ** 2).sum() for n in wanted)
    whole = sum((wanted[n][0] ** 2).sum() for n in wanted)
    reported = float(re.search(r"change the transport by ([\d.]+)% \(relative RMS\)", said)[1]) / 100.0
    assert 0.0 < reported < 1e-4 and reported == pytest.approx(np.sqrt(error / whole), abs=1e-6)
    for vertices in wanted:
        np.testing.assert_allclose(found[vertices][1], wanted[vertices][1], atol=2e-4)


def test_transport_behind_modifiers_is_said_or_exported(blender, ball, exported, tmp_path, capfd):
    """A carrier's layers come with applied modifiers; without, the export names the objects."""
    ball.modifiers.new("Finer", "SUBSURF").render_levels = 1
    blender.ops.prt.bake(mode="UNSHADOWED")
    capfd.readouterr()
    _, meshes = exported(tmp_path / "scene.glb")
    said = "".join(capfd.readouterr())
    assert "_PRT_0" not in meshes["Sphere"] and "the transport of 'Ball' lies behind modifiers" in said
    _, meshes = exported(tmp_path / "applied.glb", export_apply=True)
    assert "_PRT_8" in meshes["Sphere"] and not any(name.startswith("COLOR_") for name in meshes["Sphere"])


def test_files_without_bakes_are_exported_as_ever(blender, scene, stage, exported, tmp_path):
    """Nothing of ours in them, nor what we would turn on."""
    plain = stage.object_of("Plain", stage.cube(), principled(blender))
    plain.data.attributes.new("_OTHER", "FLOAT", "POINT")
    document, meshes = exported(tmp_path / "plain.glb")
    assert "_OTHER" not in meshes["Cube"] and "extras" not in document["scenes"][0]
