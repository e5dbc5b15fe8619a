# SPDX-License-Identifier: GPL-3.0-or-later
"""File > Export > glTF writes transport, light, and materials as they were, by Blender's own settings."""

import importlib.util
import json
import re
from pathlib import Path

import numpy as np
import pytest

from prt_addon.core.layout import BACKS, LAYERS
from prt_addon.core.shown import shown

COLOUR = (0.7, 0.3, 0.1)
DOCS = Path(__file__).resolve().parents[3] / "docs"
EXAMPLE = DOCS / "examples" / "relight_gltf.py"


@pytest.fixture(scope="module")
def example():
    """The worked example, which reads such files with NumPy alone."""
    spec = importlib.util.spec_from_file_location("relight_gltf", EXAMPLE)
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


def test_skinned_meshes_in_own_axes_are_left_out_by_name(blender, scene, ball, exported, tmp_path, capfd):
    """As glTF puts them where their bones are, whatever the object's axes; the rest has its colours."""
    ball.prt.space = "OBJECT"
    scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.1
    blender.ops.prt.bake(mode="UNSHADOWED")
    bones = blender.data.objects.new("Bones", blender.data.armatures.new("Bones"))
    scene.collection.objects.link(bones)
    blender.context.view_layer.objects.active = bones
    blender.ops.object.mode_set(mode="EDIT")
    bones.data.edit_bones.new("Bone").tail = (0.0, 0.0, 1.0)
    blender.ops.object.mode_set(mode="OBJECT")
    ball.parent = bones
    ball.modifiers.new("Armature", "ARMATURE").object = bones
    ball.vertex_groups.new(name="Bone").add(range(len(ball.data.vertices)), 1.0, "ADD")
    scene.prt.gltf.light = True
    capfd.readouterr()
    _, meshes = exported(tmp_path / "skinned.glb")
    assert "'Ball' has no light as vertex colors" in "".join(capfd.readouterr())
    assert "JOINTS_0" in meshes["Sphere"] and "COLOR_0" not in meshes["Sphere"] and "COLOR_0" in meshes["Cube"]


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


def test_a_world_without_light_is_said(scene, ball, exported, tmp_path, capfd):
    """No vertex colours then."""
    scene.prt.gltf.light, scene.world = True, None
    capfd.readouterr()
    _, meshes = exported(tmp_path / "dark.glb")
    assert "carries no light to export" in "".join(capfd.readouterr()) and "COLOR_0" not in meshes["Sphere"]


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


def test_what_lamps_of_the_sky_show_is_told_apart(blender, part, scene, stage, exported, tmp_path):
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
