# SPDX-License-Identifier: GPL-3.0-or-later
"""Light passes cut-outs, veils and panes as if their outlines were modelled, or as their share says."""

import numpy as np
import pytest

SIDE = 8
HOLES = np.indices((SIDE, SIDE)).sum(axis=0) % 3 > 0  # row 0 at the bottom
SAMPLES = 256


def floor_transport(blender, part, ob):
    """(N, 9) of an object, shadowed, straight from what was read; and the plan."""
    plan = part("read").read_bake(blender.context, [ob], part("problem").BakeSettings("SHADOWED", samples=SAMPLES))
    (island,) = plan.problem.islands
    caster = part("raycast").RayScene.of(island.occluders)
    receivers = part("direct").Receivers.of(island.groups[:1], caster)
    return part("direct").shadowed(caster, receivers, SAMPLES), plan


@pytest.fixture
def floor(scene, stage):
    return stage.object_of("Floor", stage.grid(6, 1.0), stage.diffuse("Ground"))


def card(stage, material):
    """A square above the floor, unwrapped to the whole picture."""
    ob = stage.object_of("Card", stage.grid(1, 1.0), material, (0.2, 0.1, 0.5))
    uv = ob.data.uv_layers.new()
    places = np.array([ob.data.vertices[loop.vertex_index].co[:2] for loop in ob.data.loops]) / 2.0 + 0.5
    uv.data.foreach_set("uv", places.ravel())
    return ob


def modelled(stage):
    """The same card, as the squares that are left of it."""

    def build(bm):
        for row, column in np.argwhere(~HOLES):
            corners = [(column, row), (column + 1, row), (column + 1, row + 1), (column, row + 1)]
            bm.faces.new([bm.verts.new((2.0 * x / SIDE - 1.0, 2.0 * y / SIDE - 1.0, 0.0)) for x, y in corners])

    return stage.object_of("Card", stage.from_bmesh("Squares", build), stage.diffuse("Leaf"), (0.2, 0.1, 0.5))


def principled(blender, stage, **inputs):
    material = blender.data.materials.new("Leaf")
    stage.use_nodes(material)
    for name, value in inputs.items():
        material.node_tree.nodes["Principled BSDF"].inputs[name.replace("_", " ")].default_value = value
    return material


def stencil(stage, tree, alpha=True):
    """An Image Texture that is 0 in the holes: in its alpha, or in its colour."""
    values = np.where(HOLES, 0.0, 1.0)
    image = stage.picture("Stencil", np.repeat(values[..., None], 3, axis=-1))
    if alpha:
        rgba = np.concatenate([np.full((SIDE, SIDE, 3), 0.3), values[..., None]], axis=-1).astype(np.float32)
        image.pixels.foreach_set(rgba.ravel())
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image, node.interpolation = image, "Closest"
    return node


def by_alpha(blender, stage):
    """Principled BSDF, its Alpha fed by a picture's."""
    material = principled(blender, stage)
    tree = material.node_tree
    tree.links.new(stencil(stage, tree).outputs["Alpha"], tree.nodes["Principled BSDF"].inputs["Alpha"])
    return material


def by_mix(blender, stage):
    """Mix Shader of a Transparent BSDF and another, by a picture's colour."""
    material = principled(blender, stage)
    tree = material.node_tree
    mix, clear = tree.nodes.new("ShaderNodeMixShader"), tree.nodes.new("ShaderNodeBsdfTransparent")
    tree.links.new(stencil(stage, tree, alpha=False).outputs["Color"], mix.inputs[0])
    tree.links.new(clear.outputs[0], mix.inputs[1])
    tree.links.new(tree.nodes["Principled BSDF"].outputs[0], mix.inputs[2])
    tree.links.new(mix.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
    return material


def by_mix_turned_round(blender, stage):
    """The same with the two shaders exchanged, and the picture inverted by a node."""
    material = by_mix(blender, stage)
    tree = material.node_tree
    mix = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeMixShader")
    first, second, factor = (entry.links[0].from_socket for entry in (mix.inputs[1], mix.inputs[2], mix.inputs[0]))
    invert = tree.nodes.new("ShaderNodeInvert")
    tree.links.new(factor, invert.inputs["Color"])
    for socket, entry in ((second, mix.inputs[1]), (first, mix.inputs[2]), (invert.outputs[0], mix.inputs[0])):
        tree.links.new(socket, entry)
    return material


def by_threshold(blender, stage):
    """Alpha by a Math node, as scans of leaves have it."""
    material = by_alpha(blender, stage)
    tree = material.node_tree
    alpha = tree.nodes["Principled BSDF"].inputs["Alpha"]
    math = tree.nodes.new("ShaderNodeMath")
    math.operation = "GREATER_THAN"
    tree.links.new(alpha.links[0].from_socket, math.inputs[0])
    tree.links.new(math.outputs[0], alpha)
    return material


def in_a_group(blender, stage):
    """The whole surface inside a node group."""
    material = principled(blender, stage)
    tree, group = material.node_tree, blender.data.node_groups.new("Leaf", "ShaderNodeTree")
    group.interface.new_socket("Surface", in_out="OUTPUT", socket_type="NodeSocketShader")
    shader, output = group.nodes.new("ShaderNodeBsdfPrincipled"), group.nodes.new("NodeGroupOutput")
    group.links.new(stencil(stage, group).outputs["Alpha"], shader.inputs["Alpha"])
    group.links.new(shader.outputs[0], output.inputs[0])
    node = tree.nodes.new("ShaderNodeGroup")
    node.node_tree = group
    tree.links.new(node.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
    return material


@pytest.mark.parametrize("build", [by_alpha, by_mix, by_mix_turned_round, by_threshold, in_a_group])
def test_a_cut_out_shadows_as_its_outline(blender, part, floor, stage, build):
    """Whatever nodes make the holes: what is not read, Cycles evaluates all over the faces."""
    squares = modelled(stage)
    wanted, _ = floor_transport(blender, part, floor)
    blender.data.objects.remove(squares)
    whole = stage.object_of("Whole", stage.grid(1, 1.0), None, (0.2, 0.1, 0.5))
    blocked, _ = floor_transport(blender, part, floor)
    blender.data.objects.remove(whole)
    card(stage, build(blender, stage))
    found, plan = floor_transport(blender, part, floor)
    assert np.abs(blocked - wanted).max() > 0.1  # of at most 0.28
    exact = build in (by_alpha, by_mix)
    np.testing.assert_allclose(found, wanted, atol=1e-3 if exact else 8e-3)
    assert not [notice for notice in plan.notices if "lets light through" in notice.sentence]


@pytest.mark.parametrize(
    ("inputs", "stopped"),
    [
        ({"Alpha": 0.25}, 0.25),
        ({"Transmission_Weight": 1.0, "Base_Color": (1.0, 1.0, 1.0, 1.0)}, 0.0),
        ({"Transmission_Weight": 1.0, "Base_Color": (0.25, 0.25, 0.25, 1.0)}, 0.5),
        ({"Transmission_Weight": 1.0, "Metallic": 1.0}, 1.0),
        ({"Alpha": 0.5, "Transmission_Weight": 0.5, "Base_Color": (1.0, 1.0, 1.0, 1.0)}, 0.25),
    ],
)
def test_veils_and_panes_stop_their_share(blender, part, floor, stage, inputs, stopped):
    """Between no card and a whole one, as far as the draws of 256 rays go."""
    clear, _ = floor_transport(blender, part, floor)
    ob = card(stage, principled(blender, stage))
    whole, _ = floor_transport(blender, part, floor)
    ob.data.materials[0] = principled(blender, stage, **inputs)
    found, _ = floor_transport(blender, part, floor)
    wanted = stopped * whole + (1.0 - stopped) * clear
    np.testing.assert_allclose(found.mean(axis=0), wanted.mean(axis=0), atol=5e-3)
    np.testing.assert_allclose(found, wanted, atol=0.05)


def test_glass_bsdf_and_paint(blender, part, floor, stage):
    """A Glass BSDF of a colour; and a veil whose alpha is a colour attribute's, from corner to corner."""
    clear, _ = floor_transport(blender, part, floor)
    ob = card(stage, stage.diffuse("Glass"))
    whole, _ = floor_transport(blender, part, floor)
    tree = ob.data.materials[0].node_tree
    glass = tree.nodes.new("ShaderNodeBsdfGlass")
    glass.inputs["Color"].default_value = (0.6, 0.6, 0.6, 1.0)
    tree.links.new(glass.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
    found, _ = floor_transport(blender, part, floor)
    np.testing.assert_allclose(found.mean(axis=0), (0.4 * whole + 0.6 * clear).mean(axis=0), atol=5e-3)

    paint = ob.data.color_attributes.new("Paint", "FLOAT_COLOR", "POINT")
    paint.data.foreach_set("color", np.array([(1.0, 1.0, 1.0, v.co.x > 0.0) for v in ob.data.vertices]).ravel())
    ob.data.materials[0] = principled(blender, stage)
    tree = ob.data.materials[0].node_tree
    node = tree.nodes.new("ShaderNodeVertexColor")
    node.layer_name = "Paint"
    tree.links.new(node.outputs["Alpha"], tree.nodes["Principled BSDF"].inputs["Alpha"])
    _, plan = floor_transport(blender, part, floor)
    opacity = plan.problem.islands[0].occluders.opacity
    middle = np.full(1, 1.0 / 3.0, dtype=np.float32)
    shares = [opacity.at(triangle, middle, middle)[0, 0] for triangle in np.flatnonzero(opacity.is_open)[:, None]]
    assert sorted(shares) == pytest.approx([1.0 / 3.0, 2.0 / 3.0])


def test_what_stops_all_light_costs_nothing(blender, part, floor, stage):
    """Nothing is looked up, nothing drawn, and old bakes keep their fingerprints."""
    card(stage, principled(blender, stage))
    _, plan = floor_transport(blender, part, floor)
    assert plan.problem.islands[0].occluders.opacity is None


def test_another_stencil_makes_bakes_stale(blender, scene, part, floor, stage):
    """Of the card, and of what its shadow falls on."""
    ob = card(stage, by_alpha(blender, stage))
    scene.prt.mode, scene.prt.samples = "SHADOWED", 64
    blender.ops.prt.bake()
    states = part("freshness").freshness(blender.context, [floor, ob])
    assert [one.state for one in states] == ["FRESH", "FRESH"]
    image = blender.data.images["Stencil"]
    image.pixels.foreach_set(np.ones(SIDE * SIDE * 4, dtype=np.float32))
    states = part("freshness").freshness(blender.context, [floor, ob])
    assert ["OTHERS" in states[0].causes, "GEOMETRY" in states[1].causes] == [True, True]


def test_a_lost_picture_is_said(blender, part, floor, stage):
    """The face is then opaque."""
    ob = card(stage, by_alpha(blender, stage))
    image = blender.data.images["Stencil"]
    image.unpack(method="REMOVE")
    image.source, image.filepath = "FILE", "//nowhere.png"
    whole, plan = floor_transport(blender, part, floor)
    (notice,) = [one for one in plan.notices if one.name == "Leaf" and "opaque" in one.sentence]
    assert "nowhere.png" in notice.sentence
    ob.data.materials[0] = principled(blender, stage)
    np.testing.assert_array_equal(whole, floor_transport(blender, part, floor)[0])


def test_without_cycles_what_nodes_make_is_opaque(blender, part, floor, stage):
    """Which is said; what is read needs no Cycles."""
    card(stage, by_threshold(blender, stage))
    blender.ops.preferences.addon_disable(module="cycles")
    try:
        whole, plan = floor_transport(blender, part, floor)
    finally:
        blender.ops.preferences.addon_enable(module="cycles")
    (notice,) = [one for one in plan.notices if one.name == "Leaf"]
    assert "Cycles is off" in notice.sentence
    found, plan = floor_transport(blender, part, floor)
    assert np.abs(found - whole).max() > 0.1 and not any(one.name == "Leaf" for one in plan.notices)
