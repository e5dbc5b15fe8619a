# SPDX-License-Identifier: GPL-3.0-or-later
"""`prt.freeze`: the colour attribute is what EEVEE shows, in every encoding and in either axes."""

import numpy as np
import pytest


@pytest.fixture
def ball(blender, scene, stage):
    """A white ball over a floor, under a sky of six colours that is turned."""
    _, mapping = stage.environment(stage.picture("Six", stage.six_coloured_sky(64)), strength=0.3)
    mapping.inputs["Rotation"].default_value = (0.4, -0.9, 2.3)
    found = stage.object_of("Ball", stage.icosphere(4), stage.diffuse("White", (1.0, 1.0, 1.0)))
    stage.object_of("Floor", stage.grid(8, 3.0), stage.diffuse("Floor"), (0, 0, -1.1))
    return found


def colours(ob):
    data = ob.data.attributes["PRT Light"].data
    found = np.empty((len(data), 4), dtype=np.float32)
    data.foreach_get("color", found.ravel())
    return found[:, :3]


@pytest.mark.parametrize("space", ["SCENE", "OBJECT"])
def test_it_is_what_eevee_shows(blender, scene, stage, ball, tmp_path, space):
    """Looked down upon: pixels in the middle of the ball have the colours of the nearest vertices."""
    ball.prt.space, ball.rotation_euler = space, (0.5, 0.2, 1.0)
    blender.context.view_layer.update()
    blender.ops.prt.bake(mode="SHADOWED", samples=64)
    assert blender.ops.prt.freeze() == {"FINISHED"}
    stage.top_camera(scale=3.0)
    frame = stage.render(tmp_path / "frame.exr")[..., :3]
    places = np.array([ball.matrix_world @ vertex.co for vertex in ball.data.vertices])
    pixels = stage.pixel_points(scale=3.0)
    checked = 0
    for row, column in zip(*np.nonzero(np.linalg.norm(pixels, axis=-1) < 0.6), strict=True):
        distance = np.linalg.norm(places[:, :2] - pixels[row, column], axis=1) + 9.0 * (places[:, 2] < 0.0)
        if distance.min() < 0.01:
            np.testing.assert_allclose(colours(ball)[distance.argmin()], frame[row, column], atol=0.015)
            checked += 1
    assert checked > 5


def test_encodings(blender, part, scene, ball):
    """Floats in linear light, floats as screens show them, and bytes: one light; another freeze takes the place of the first."""
    blender.ops.prt.bake(mode="SHADOWED", samples=32)
    found = {}
    for encoding in ("LINEAR", "SRGB", "BYTE"):
        assert blender.ops.prt.freeze(encoding=encoding) == {"FINISHED"}
        found[encoding] = colours(ball)
        assert ball.data.attributes["PRT Light"].data_type == ("BYTE_COLOR" if encoding == "BYTE" else "FLOAT_COLOR")
    decode = part("equirect_projection").srgb_to_linear
    np.testing.assert_allclose(decode(found["SRGB"]), found["LINEAR"], atol=1e-5)
    np.testing.assert_allclose(found["BYTE"], np.minimum(found["LINEAR"], 1.0), atol=0.01)
    assert [name for name in ball.data.attributes.keys() if name.startswith("PRT")] == ["PRT Light"]  # noqa: SIM118


def evaluated(blender, ob, name="PRT Light"):
    """(elements, 4) of a colour attribute on what the modifiers come to, its domain and its type; None if it is not there."""
    mesh = ob.evaluated_get(blender.context.evaluated_depsgraph_get()).to_mesh()
    layer = mesh.attributes.get(name)
    if layer is None:
        return None
    values = np.empty((len(layer.data), 4), dtype=np.float32)
    layer.data.foreach_get("color", values.ravel())
    return values, layer.domain, layer.data_type


@pytest.mark.parametrize("space", ["SCENE", "OBJECT"])
@pytest.mark.parametrize("domain", ["POINT", "CORNER"])
def test_carried_transport_freezes_behind_the_modifiers(blender, part, scene, stage, ball, domain, space):
    """On what they come to, as transport there shows it, for both of two linked duplicates; the object's own mesh stays as it is."""
    box = stage.object_of(
        "Box", stage.cube(0.5) if domain == "CORNER" else stage.icosphere(1, 0.5), stage.diffuse("Box"), (1.5, 0, 0)
    )
    box.modifiers.new("Array", "ARRAY").count = 2
    box.rotation_euler, box.prt.space = (0.4, 0.3, 0.8), space
    twin = box.copy()
    twin.location, twin.rotation_euler = (-1.5, 0.0, 0.0), (1.0, 0.3, -0.8)
    scene.collection.objects.link(twin)
    blender.context.view_layer.update()
    blender.ops.prt.bake(mode="SHADOWED", samples=32)
    names = [attribute.name for attribute in box.data.attributes]
    light, rotation, found = part("light").shown_light(scene.world), part("rotation").rotation_matrix, []
    for encoding in ("LINEAR", "BYTE"):
        assert blender.ops.prt.freeze(encoding=encoding) == {"FINISHED"}
        for ob in (box, twin):
            colours, where, kind = evaluated(blender, ob)
            assert where == domain and kind == ("BYTE_COLOR" if encoding == "BYTE" else "FLOAT_COLOR")
            transport = np.stack([evaluated(blender, ob, name)[0][:, :3] for name in part("layers").LAYERS], axis=1)
            axes = np.array(ob.matrix_world)[:3, :3]
            seen = rotation(axes.T) @ light if space == "OBJECT" else light
            wanted = stage.without_negatives(np.einsum("nic,ic->nc", transport, seen))
            np.testing.assert_allclose(
                colours[:, :3],
                np.minimum(wanted, 1.0) if encoding == "BYTE" else wanted,
                atol=0.01 if encoding == "BYTE" else 1e-5,
            )
            found.append(colours)
    assert np.abs(found[0] - found[1]).max() > 0.05
    assert [attribute.name for attribute in box.data.attributes] == names
    groups = [tree.name for tree in blender.data.node_groups if "prt_carrier_version" in tree]
    assert groups == [f"PRT Carrier ({domain.title()}s, Light in Bytes)"]
    blender.ops.prt.bake(mode="UNSHADOWED")
    assert evaluated(blender, box) is None and evaluated(blender, box, "_PRT_8") is not None


def test_frozen_light_behind_modifiers_can_be_applied(blender, ball):
    """It stays where the modifiers are applied."""
    floor = blender.data.objects["Floor"]
    floor.modifiers.new("Finer", "SUBSURF").render_levels = 1
    blender.ops.prt.bake(mode="UNSHADOWED")
    blender.ops.prt.freeze()
    wanted = evaluated(blender, floor)[0]
    blender.context.view_layer.objects.active = floor
    for modifier in list(floor.modifiers):
        blender.ops.object.modifier_apply(modifier=modifier.name)
    np.testing.assert_array_equal(colours(floor), wanted[:, :3])
    assert len(wanted) == len(floor.data.vertices) > 81


def test_what_cannot_be_frozen_is_said(blender, scene, stage, ball, capfd):
    """Light that bytes cannot hold; a library's objects; the rest is done."""
    with pytest.raises(RuntimeError, match="None of these objects is baked"):
        blender.ops.prt.freeze()
    blender.ops.prt.bake(mode="UNSHADOWED")
    scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 30.0
    blender.context.view_layer.update()
    capfd.readouterr()
    assert blender.ops.prt.freeze(encoding="BYTE") == {"FINISHED"}
    said = capfd.readouterr().out
    assert "The light of 2 objects is brighter than bytes can hold" in said
    assert "Froze the light of 2 object(s)" in said
