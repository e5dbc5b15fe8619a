# SPDX-License-Identifier: GPL-3.0-or-later
"""Cycles evaluates the colours that are not read, and leaves no trace of having done so."""

import numpy as np
import pytest

from tests.recording import recording
from tests.scene.material.materials import (
    middle,
    node_into_colour,
    plan_albedo,
    sentences,
    shader_material,
    whereabouts,
)

Colour = tuple[float, float, float]


def test_cycles_evaluates_what_is_not_read(blender, part, scene, stage):
    """A colour that is a function of position: the very values, on the faces of that slot only, and it is said."""
    ob = stage.object_of("A", stage.grid(4, 1.0), stage.diffuse("Plain", (0.1, 0.2, 0.3)), (5.0, 6.0, 7.0))
    special = stage.diffuse("Special")
    node_into_colour(special, "ShaderNodeTexCoord", "Object")
    ob.data.materials.append(special)
    right = np.array([face.center.x > 0 for face in ob.data.polygons])
    ob.data.polygons.foreach_set("material_index", right.astype(np.int32))
    albedo, plan = plan_albedo(part, blender, ob)
    triangle = np.arange(len(plan.scene.occluders.triangles))
    position = plan.scene.occluders.vertices[plan.scene.occluders.triangles] - (5.0, 6.0, 7.0)
    at_corner_1 = albedo.at(triangle, np.ones(len(triangle), np.float32), np.zeros(len(triangle), np.float32))
    here = position[:, :, 0].mean(axis=1) > 0
    np.testing.assert_allclose(at_corner_1[here], np.clip(position[here, 1], 0, 1), atol=1e-3)
    np.testing.assert_allclose(at_corner_1[~here], np.tile([[0.1, 0.2, 0.3]], (np.sum(~here), 1)), rtol=1e-6)
    assert sentences(plan) == [
        "Material 'Special': its colour comes from 'Texture Coordinate'; Cycles evaluated it at the vertices."
    ]


def test_evaluation_leaves_no_trace(blender, part, scene, stage):
    """Data-blocks and their users, selection, active object and engine; in two scenes and any mode."""
    noisy = stage.diffuse("Noisy")
    node_into_colour(noisy, "ShaderNodeTexNoise", "Color")
    one = stage.object_of("One", stage.grid(4), noisy)
    several = shader_material(blender, ("ShaderNodeBsdfGlass", (1, 1, 1)), ("ShaderNodeBsdfDiffuse", (1, 0, 0)))
    node_into_colour(several, "ShaderNodeTexNoise", "Color")
    two = stage.object_of("Two", stage.grid(2), several, (3, 0, 0))
    blender.context.view_layer.objects.active = two
    one.select_set(True)
    before = whereabouts(blender)
    _, plan = plan_albedo(part, blender, one)
    assert len(plan.notices) == 2 and all("Cycles evaluated it" in said for said in sentences(plan))
    assert whereabouts(blender) == before


def test_materials_of_several_shaders(blender, part, scene, stage):
    """What they reflect adds up, glossy or not; what they let through does not count."""
    red, green, blue = (0.8, 0, 0), (0, 0.8, 0), (0, 0, 0.8)
    diffuse, glossy, clear = "ShaderNodeBsdfDiffuse", "ShaderNodeBsdfAnisotropic", "ShaderNodeBsdfTransparent"
    cases: list[tuple[list[tuple[str, Colour]], Colour]] = [
        ([(diffuse, red), (diffuse, green)], (0.4, 0.4, 0)),
        ([(diffuse, red), (glossy, blue)], (0.4, 0, 0.4)),
        ([(glossy, blue)], blue),
        ([(diffuse, red), (clear, (1, 1, 1))], red),
        ([(glossy, green), (clear, (1, 1, 1))], green),
    ]
    for shaders, expected in cases:
        ob = stage.object_of("Mixed", stage.grid(1), shader_material(blender, *shaders))
        albedo, _ = plan_albedo(part, blender, ob)
        np.testing.assert_allclose(albedo.at(np.array([0]), *middle())[0], expected, atol=0.02, err_msg=str(shaders))
        blender.data.objects.remove(ob)


@pytest.mark.parametrize(
    ("kind", "output", "evaluations"), [("ShaderNodeNewGeometry", "Position", 2), ("ShaderNodeTexNoise", 1, 1)]
)
def test_unread_colours_of_instances(blender, part, scene, stage, monkeypatch, kind, output, evaluations):
    """Each where it stands, if its colour depends on the place in the world; else once for all."""
    material = stage.diffuse("Placed")
    node_into_colour(material, kind, output)
    thing = stage.object_of("Thing", stage.grid(1, 0.01), material, (0, 0, 0))
    holder = blender.data.collections.new("Holder")
    scene.collection.objects.unlink(thing)
    holder.objects.link(thing)
    for x in (0.25, 0.75):
        empty = blender.data.objects.new("Instancer", None)
        empty.location, empty.instance_type, empty.instance_collection = (x, 0, 0), "COLLECTION", holder
        scene.collection.objects.link(empty)
    ground = stage.object_of("Ground", stage.grid(1), location=(0, 0, -1))
    module, counted = part("cycles_colour"), part("notices").counted
    evaluated: list[str] = []
    monkeypatch.setattr(
        module, "_pass_at_corners", recording(module._pass_at_corners, evaluated, of=lambda *arguments: arguments[1])
    )
    albedo, plan = plan_albedo(part, blender, ground)
    assert evaluated == ["DIFFUSE"] * evaluations
    assert [one.names for one in counted(plan.notices) if "Cycles evaluated it" in one.sentence] == [("Placed",)], (
        "once"
    )
    count = len(plan.scene.occluders.triangles)
    colours = albedo.at(np.arange(count), *np.full((2, count), 1 / 3, dtype=np.float32))
    if kind == "ShaderNodeNewGeometry":
        np.testing.assert_allclose(np.sort(colours[2:, 0]), [0.25, 0.25, 0.75, 0.75], atol=0.01)
    else:
        np.testing.assert_array_equal(colours[2:4], colours[4:6])
        assert np.ptp(colours[2:4]) > 0


def test_without_cycles_the_viewport_colour_stands_in(blender, part, scene, stage, monkeypatch):
    """Blender refuses to bake, as it does in some contexts: what is taken instead is said."""
    ob = stage.object_of("A", stage.grid(1, 1.0), stage.diffuse("Noisy"))
    material = ob.data.materials[0]
    material.diffuse_color = (0.2, 0.4, 0.6, 1.0)
    node_into_colour(material, "ShaderNodeTexNoise", "Color")
    before = whereabouts(blender)

    def refuses(*_args, **_options):
        raise RuntimeError("Operator bpy.ops.object.bake.poll() failed, context is incorrect")

    monkeypatch.setattr(part("cycles_colour"), "_pass_at_corners", refuses)
    albedo, plan = plan_albedo(part, blender, ob)
    np.testing.assert_allclose(albedo.constant[0], (0.2, 0.4, 0.6), rtol=1e-6)
    assert sentences(plan) == [
        "Material 'Noisy': its colour comes from 'Noise Texture'; light takes on its viewport colour."
    ]
    assert whereabouts(blender) == before


def test_colours_from_custom_properties(blender, part, scene, stage):
    """An object's own, and the scene's, as Attribute nodes read them."""
    for kind, owner in (("OBJECT", None), ("VIEW_LAYER", scene)):
        material = stage.diffuse(kind)
        tree = material.node_tree
        attribute = tree.nodes.new("ShaderNodeAttribute")
        attribute.attribute_type, attribute.attribute_name = kind, "paint"
        shader = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeBsdfDiffuse")
        tree.links.new(attribute.outputs["Color"], shader.inputs["Color"])
        ob = stage.object_of(kind, stage.grid(1), material)
        (owner or ob)["paint"] = [0.1, 0.4, 0.7]
        albedo, _ = plan_albedo(part, blender, ob)
        np.testing.assert_allclose(albedo.at(np.array([0]), *middle())[0], (0.1, 0.4, 0.7), atol=2e-3, err_msg=kind)
        blender.data.objects.remove(ob)


def test_what_the_camera_alone_sees_does_not_bounce(blender, part, scene, stage):
    """Light Path mixes a colour for the camera with one for light."""
    material = stage.diffuse("Two-faced")
    tree = material.node_tree
    path, mix = tree.nodes.new("ShaderNodeLightPath"), tree.nodes.new("ShaderNodeMix")
    mix.data_type = "RGBA"
    entries = {entry.identifier: entry for entry in mix.inputs}
    entries["A_Color"].default_value, entries["B_Color"].default_value = (0.1, 0.6, 0.2, 1), (0.9, 0, 0, 1)
    tree.links.new(path.outputs["Is Camera Ray"], entries["Factor_Float"])
    shader = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeBsdfDiffuse")
    result = next(output for output in mix.outputs if output.identifier == "Result_Color")
    tree.links.new(result, shader.inputs["Color"])
    ob = stage.object_of("Floor", stage.grid(1), material)
    before = whereabouts(blender)
    albedo, _ = plan_albedo(part, blender, ob)
    np.testing.assert_allclose(albedo.at(np.array([0]), *middle())[0], (0.1, 0.6, 0.2), atol=2e-3)
    assert whereabouts(blender) == before
