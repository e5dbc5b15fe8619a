# SPDX-License-Identifier: GPL-3.0-or-later
"""Exported glTF holds the transport of backs, where meshes have it, beside that of fronts."""

import numpy as np
import pytest

from prt_addon.core.layout import BACKS, LAYERS
from prt_addon.core.shown import shown
from tests.scene.export.conftest import COLOUR, principled


@pytest.mark.parametrize("others_too", [False, True])
@pytest.mark.parametrize("paint", [False, True])
def test_backs_go_with_fronts(blender, part, scene, stage, exported, tmp_path, others_too, paint):
    """The layers of a sheet's backs are attributes of the file, bit for bit, and no vertex colours; a ball has none."""
    stage.environment(stage.picture("Six", stage.six_coloured_sky(64)))
    sheet = stage.object_of("Sheet", stage.grid(4), principled(blender))
    stage.object_of("Ball", stage.icosphere(1), principled(blender), (0.0, 0.0, 3.0))
    blender.ops.prt.bake(mode="SHADOWED", samples=32)
    if paint:
        sheet.data.color_attributes.new("Paint", "FLOAT_COLOR", "POINT").data.foreach_set("color", [0.25] * 4 * 25)
        sheet.data.color_attributes.active_color_name = "Paint"
    _, meshes = exported(tmp_path / "sheet.glb", export_attributes=others_too)
    names = {name for name in meshes["Grid"] if name.startswith(("_PRT", "COLOR"))}
    transport, colours = ({name for name in names if name.startswith(kind)} for kind in ("_PRT", "COLOR"))
    assert transport == {*LAYERS, *BACKS} and len(colours) <= 2 * paint
    assert not any(name in BACKS for name in meshes["Sphere"])
    assert rows_of(meshes["Grid"], BACKS) == stored_rows(sheet.data, BACKS)
    for name in colours:  # the paint, and the white that the exporter puts first
        value = meshes["Grid"][name][0, 0]
        assert min(abs(value - 1.0), abs(value - 0.25)) < 1e-3 and np.ptp(meshes["Grid"][name][:, :3]) == 0.0


def rows_of(attributes, names):
    """The floats of each vertex in some layers, as bytes."""
    return {row.tobytes() for row in np.stack([attributes[name] for name in names], axis=1).astype(np.float32)}


def stored_rows(mesh, names):
    """The same of a mesh in Blender."""
    layers = [np.empty(4 * len(mesh.attributes[name].data), dtype=np.float32) for name in names]
    for name, values in zip(names, layers, strict=True):
        mesh.attributes[name].data.foreach_get("color", values)
    return {row.tobytes() for row in np.stack([values.reshape(-1, 4) for values in layers], axis=1)}


@pytest.fixture
def sheets(blender, part, scene, stage):
    """Sheets over a floor whose backs have transport, by name: on points; on corners; in their own axes, turned; on a carrier."""
    stage.environment(stage.picture("Six", stage.six_coloured_sky(64)), strength=0.2)
    stage.object_of("Floor", stage.grid(8, 8.0), principled(blender), (0.0, 0.0, -2.0)).prt.sides = "FRONTS"
    found = {}
    for number, name in enumerate(("Points", "Corners", "Own axes", "Carried")):
        found[name] = stage.object_of(name, stage.grid(3), principled(blender), (4.0 * number, 0.0, 0.0))
        found[name].data.name = name
    stage.crease(found["Corners"].data)
    found["Own axes"].prt.space, found["Own axes"].rotation_euler = "OBJECT", (0.5, 0.2, -1.0)
    modifier = found["Carried"].modifiers.new("Finer", "SUBSURF")
    modifier.levels = modifier.render_levels = 1
    blender.ops.prt.bake(mode="INTERREFLECTED", samples=32)
    domains = {name: part("layers").domain_of(part("carrier").transport_mesh(ob)) for name, ob in found.items()}
    assert domains["Corners"] == "CORNER" and domains["Points"] == "POINT"
    return found


def test_backs_on_any_domain_axes_and_carrier(part, sheets, exported, tmp_path):
    """Bit for bit what is stored, wherever that is."""
    _, meshes = exported(tmp_path / "sheets.glb", export_apply=True)
    names = BACKS
    for name, ob in sheets.items():
        stored = part("carrier").transport_mesh(ob)
        assert (stored is ob.data) == (name != "Carried")
        assert rows_of(meshes[name], names) == stored_rows(stored, names)


def test_the_light_of_now_is_that_of_fronts(blender, part, scene, sheets, exported, example, tmp_path):
    """Vertex colours have one side; without transport nothing of the other is left."""
    scene.prt.gltf.light, scene.prt.gltf.transport = True, False
    _, colours = exported(tmp_path / "light.glb", export_apply=True)
    scene.prt.gltf.transport = True
    exported(tmp_path / "both.glb", export_apply=True)
    light = example.read_light(tmp_path / "both.glb")
    [floor, *meshes] = sorted(example.read_baked(tmp_path / "both.glb"), key=lambda mesh: mesh.backs is not None)
    assert len(meshes) == 4 and floor.backs is None
    fronts, backs = ([example.relight(mesh, light, side) / COLOUR for mesh in meshes] for side in (False, True))
    for name in sheets:
        assert not any("_PRT_B" in attribute for attribute in colours[name])
        written = colours[name]["COLOR_0"][:, :3]
        near = [
            [each.shape == written.shape and np.allclose(each, written, atol=1e-4) for each in side]
            for side in (fronts, backs)
        ]
        assert any(near[0]) and not any(near[1])


def test_backs_in_sixteen_bits(scene, part, sheets, exported, example, tmp_path):
    """They have scales of their own, and light within a thousandth of what is stored as floats, in either axes."""
    exported(tmp_path / "float.glb", export_apply=True)
    scene.prt.gltf.precision = "SHORT"
    document, _ = exported(tmp_path / "short.glb", export_apply=True)
    marked = [mesh["primitives"][0] for mesh in document["meshes"] if "_PRT_B0" in mesh["primitives"][0]["attributes"]]
    assert len(marked) == 4
    for primitive in marked:
        extras = primitive["extras"]["prt_relight"]
        assert np.shape(extras["backs"]) == (3, 2) and np.shape(extras["scales"]) == (9, 2)
        for name in BACKS:
            accessor = document["accessors"][primitive["attributes"][name]]
            assert (accessor["componentType"], accessor["normalized"]) == (5122, True)
    light = example.read_light(tmp_path / "float.glb")
    wanted, found = (
        [
            example.relight(mesh, light, True)
            for mesh in example.read_baked(tmp_path / f"{kind}.glb")
            if mesh.backs is not None
        ]
        for kind in ("float", "short")
    )
    for one, other in zip(wanted, found, strict=True):
        assert 0.0 < np.abs(one - other).max() < 1e-3 * one.max()


def test_the_example_shades_backs_as_blender_does(scene, part, sheets, exported, example, tmp_path):
    """What NumPy makes of the stored layers under the world's light."""
    exported(tmp_path / "sheets.glb")
    light = example.read_light(tmp_path / "sheets.glb")
    sheet = sheets["Points"].data
    wanted = shown(part("layers").read_backs(sheet), part("light").shown_light(scene.world))
    found = [example.relight(mesh, light, True) / COLOUR for mesh in example.read_baked(tmp_path / "sheets.glb")]
    assert np.ptp(wanted, axis=0).max() > 0.02
    near = [
        each
        for each in found
        if each.shape == wanted.shape and np.allclose(each.mean(axis=0), wanted.mean(axis=0), rtol=1e-4)
    ]
    assert len(near) == 1
