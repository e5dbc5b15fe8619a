# SPDX-License-Identifier: GPL-3.0-or-later
"""A material is read once: what EEVEE shows relit and what light takes on where it bounces are one colour."""

import numpy as np
import pytest

RED, GREEN, BLUE = (1.0, 0.0, 0.0, 1.0), (0.0, 1.0, 0.0, 1.0), (0.0, 0.0, 1.0, 1.0)


@pytest.fixture
def both(blender, part, scene, stage, tmp_path):
    """The colour of a material as EEVEE shows it relit under a constant sky, and as it bounces."""

    def look(material, resolution=8):
        ob = stage.object_of("Floor", stage.grid(2, 2.0), material)
        ob.data.uv_layers.new()
        stage.top_camera(scale=2.0, resolution=resolution)
        stage.environment(stage.picture("Constant", np.ones((8, 16, 3))))
        blender.ops.prt.bake(mode="UNSHADOWED")
        shown = stage.render(tmp_path / "frame.exr")[resolution // 2, resolution // 2, :3]
        blender.ops.prt.remove()
        settings = part("problem").BakeSettings("INTERREFLECTED")
        albedo = part("read").read_bake(blender.context, [ob], settings).scene.occluders.albedo
        middle = albedo.at(np.array([0]), *np.full((2, 1), 1 / 3, dtype=np.float32))[0]
        return shown, middle

    return look


def material_of(blender, build):
    """A material whose surface is the shader that `build(nodes, link)` returns."""
    from headless import use_nodes

    material = blender.data.materials.new("Made")
    use_nodes(material)
    tree = material.node_tree
    tree.nodes.clear()
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    shader = build(tree.nodes, tree.links.new)
    if shader:
        tree.links.new(shader, output.inputs["Surface"])
    return material


def bsdf(nodes, colour, kind="Diffuse"):
    node = nodes.new(f"ShaderNodeBsdf{kind}")
    entry = node.inputs.get("Base Color") or node.inputs["Color"]
    entry.default_value = colour
    if kind == "Principled":
        node.inputs["Specular IOR Level"].default_value = 0.0
    return node.outputs[0]


def mix(nodes, link, first, second, factor=0.5):
    node = nodes.new("ShaderNodeMixShader")
    node.inputs[0].default_value = factor
    link(first, node.inputs[1])
    link(second, node.inputs[2])
    return node.outputs[0]


def add(nodes, link, first, second):
    node = nodes.new("ShaderNodeAddShader")
    link(first, node.inputs[0])
    link(second, node.inputs[1])
    return node.outputs[0]


def fed(nodes, link, colour):
    """A Diffuse BSDF fed by a node that is no constant, though its value is one."""
    node = nodes.new("ShaderNodeCombineColor")
    for entry, value in zip(node.inputs, colour, strict=False):
        entry.default_value = value
    shader = nodes.new("ShaderNodeBsdfDiffuse")
    link(node.outputs[0], shader.inputs["Color"])
    return shader.outputs[0]


def grouped(blender, build):
    """An output of a new group node in the tree of `nodes`, which holds the shader that `build` makes."""

    def make(nodes, link):
        tree = blender.data.node_groups.new("Group", "ShaderNodeTree")
        tree.interface.new_socket("Shader", in_out="OUTPUT", socket_type="NodeSocketShader")
        output = tree.nodes.new("NodeGroupOutput")
        tree.links.new(build(tree.nodes, tree.links.new), output.inputs[0])
        node = nodes.new("ShaderNodeGroup")
        node.node_tree = tree
        return node.outputs[0]

    return make


CASES = {
    "mix of two": (lambda n, k: mix(n, k, bsdf(n, RED), bsdf(n, BLUE)), (0.5, 0, 0.5)),
    "uneven mix": (lambda n, k: mix(n, k, bsdf(n, RED), bsdf(n, BLUE, "Principled"), 0.25), (0.75, 0, 0.25)),
    "mix of one": (lambda n, k: mix(n, k, bsdf(n, RED), bsdf(n, BLUE), 1.0), (0, 0, 1)),
    "sum": (lambda n, k: add(n, k, bsdf(n, RED), bsdf(n, (0, 0.25, 0, 1))), (1, 0.25, 0)),
    "translucent": (lambda n, k: bsdf(n, GREEN, "Translucent"), (0, 1, 0)),
    "fed and constant": (lambda n, k: mix(n, k, fed(n, k, (0.2, 0.4, 0.8)), bsdf(n, RED)), (0.6, 0.2, 0.4)),
    "sum of fed": (lambda n, k: add(n, k, fed(n, k, (0.2, 0.4, 0.8)), bsdf(n, (0.1, 0.1, 0.1, 1))), (0.3, 0.5, 0.9)),
}


@pytest.mark.parametrize("case", CASES)
def test_surface_and_bounce_agree(blender, both, case):
    build, colour = CASES[case]
    shown, bounced = both(material_of(blender, build))
    np.testing.assert_allclose(shown, colour, atol=5e-3)
    np.testing.assert_allclose(bounced, colour, atol=5e-3)


def test_transparent_shows_what_is_behind(blender, both):
    """Light bounces off what is opaque as if all were."""
    material = material_of(blender, lambda n, k: mix(n, k, bsdf(n, GREEN), bsdf(n, (1, 0, 0, 1), "Transparent"), 0.7))
    material.surface_render_method = "BLENDED"
    shown, bounced = both(material)
    np.testing.assert_allclose(shown, (0, 0.3, 0), atol=1e-2)  # the film is transparent
    np.testing.assert_allclose(bounced, (0, 1, 0), atol=5e-3)


@pytest.mark.parametrize("inner", ["constant", "fed", "nested", "through the group"])
def test_shaders_in_groups(blender, both, inner):
    """Constants are read, nodes inside are handed out, inputs of the group are followed to the outside."""
    colour = (0.2, 0.6, 0.1)
    if inner == "constant":
        build = grouped(blender, lambda n, k: bsdf(n, (*colour, 1)))
    elif inner == "fed":
        build = grouped(blender, lambda n, k: fed(n, k, colour))
    elif inner == "nested":
        build = grouped(blender, grouped(blender, lambda n, k: fed(n, k, colour)))
    else:
        build = through_the_group(blender, colour)
    material = material_of(blender, build)
    shown, bounced = both(material)
    np.testing.assert_allclose(shown, colour, atol=5e-3)
    np.testing.assert_allclose(bounced, colour, atol=5e-3)
    assert not [group.name for group in blender.data.node_groups if group.get("prt_part")], "copies stay behind"


def through_the_group(blender, colour):
    def build(nodes, link):
        tree = blender.data.node_groups.new("Group", "ShaderNodeTree")
        tree.interface.new_socket("Tint", in_out="INPUT", socket_type="NodeSocketColor")
        tree.interface.new_socket("Shader", in_out="OUTPUT", socket_type="NodeSocketShader")
        entry, output = tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")
        shader = tree.nodes.new("ShaderNodeBsdfDiffuse")
        tree.links.new(entry.outputs["Tint"], shader.inputs["Color"])
        tree.links.new(shader.outputs[0], output.inputs[0])
        node = nodes.new("ShaderNodeGroup")
        node.node_tree = tree
        node.inputs["Tint"].default_value = (*colour, 1)
        return node.outputs[0]

    return build


def test_an_edited_group_is_followed(blender, part, scene, stage):
    """What lies inside a group is shown through a copy: an edit makes another, and Remove leaves none."""
    material = material_of(blender, grouped(blender, lambda n, k: fed(n, k, (0.2, 0.6, 0.1))))
    [group] = blender.data.node_groups
    ob = stage.object_of("Cube", stage.cube(), material)
    part("shading").add_shading([ob])
    copies = [copy for copy in blender.data.node_groups if copy.get("prt_part") == group.name]
    assert len(copies) == 1
    node = next(node for node in group.nodes if node.bl_idname == "ShaderNodeCombineColor")
    node.inputs[0].default_value = 0.9
    group.update_tag()
    blender.context.view_layer.update()
    [copy] = [copy for copy in blender.data.node_groups if copy.get("prt_part") == group.name]
    assert copy.nodes[node.name].inputs[0].default_value == pytest.approx(0.9)
    part("shading").remove_shading([ob])
    assert not [copy for copy in blender.data.node_groups if copy.get("prt_part")]


def test_each_engine_has_its_own_output(blender, part, both):
    """Green for EEVEE, red for Cycles: relit in green, while and after it is followed; light bounces off red."""
    material = material_of(blender, lambda n, k: bsdf(n, RED))
    tree = material.node_tree
    [output] = [node for node in tree.nodes if node.bl_idname == "ShaderNodeOutputMaterial"]
    output.target = "CYCLES"
    for_eevee = tree.nodes.new("ShaderNodeOutputMaterial")
    for_eevee.target = "EEVEE"
    tree.links.new(bsdf(tree.nodes, GREEN), for_eevee.inputs["Surface"])
    shown, bounced = both(material)
    np.testing.assert_allclose(shown, GREEN[:3], atol=5e-3)
    np.testing.assert_allclose(bounced, RED[:3], atol=5e-3)


def test_the_active_output_is_the_one_that_counts(blender, both):
    """Of two for all engines: also once ours is active in its place."""
    material = material_of(blender, lambda n, k: bsdf(n, RED))
    tree = material.node_tree
    second = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(bsdf(tree.nodes, BLUE), second.inputs["Surface"])
    second.is_active_output = True
    shown, bounced = both(material)
    np.testing.assert_allclose(shown, BLUE[:3], atol=5e-3)
    np.testing.assert_allclose(bounced, BLUE[:3], atol=5e-3)


def test_muted_links_and_nodes(blender, both):
    """A muted link feeds nothing; a muted node hands on what it is given."""
    material = material_of(blender, lambda n, k: fed(n, k, (0.2, 0.4, 0.8)))
    tree = material.node_tree
    shader = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeBsdfDiffuse")
    shader.inputs["Color"].default_value = GREEN
    source = shader.inputs["Color"].links[0].from_socket
    invert = tree.nodes.new("ShaderNodeInvert")
    tree.links.new(source, invert.inputs["Color"])
    tree.links.new(invert.outputs[0], shader.inputs["Color"])
    invert.mute = True
    for colour in ((0.2, 0.4, 0.8), GREEN[:3]):
        shown, bounced = both(material)
        np.testing.assert_allclose(shown, colour, atol=5e-3)
        np.testing.assert_allclose(bounced, colour, atol=5e-3)
        shader.inputs["Color"].links[0].is_muted = True


def test_what_reflects_nothing_is_left_alone(blender, part, scene, stage):
    """A lamp of a mesh goes on glowing, and is named."""

    def lamp(nodes, link):
        return nodes.new("ShaderNodeEmission").outputs[0]

    ob = stage.object_of("Lamp", stage.cube(), material_of(blender, lamp))
    glow, notice = part("shading").add_shading([ob])
    assert "'Made' emits light" in glow.sentence
    assert "'Made' reflects no light" in notice.sentence
    assert not list(part("our_nodes").our_nodes(ob.data.materials[0].node_tree))


def loop(tree, entry, count=2):
    """Reroutes that feed each other, and an input."""
    reroutes = [tree.nodes.new("NodeReroute") for _ in range(count)]
    for one, other in zip(reroutes, reroutes[1:] + reroutes[:1], strict=True):
        tree.links.new(one.outputs[0], other.inputs[0])
    tree.links.new(reroutes[0].outputs[0], entry)


@pytest.mark.parametrize("count", [1, 2, 5])
def test_loops_freeze_nothing(blender, part, scene, stage, count):
    """In a colour, in a surface, in the world: of reroutes, and of shaders. Handlers walk them at each edit."""
    ob = stage.object_of("Ball", stage.icosphere(1), stage.diffuse(colour=(0.1, 0.2, 0.3)))
    world, _ = stage.environment(stage.picture("Sky", stage.six_coloured_sky(16)))
    blender.ops.prt.bake(mode="UNSHADOWED")
    tree = ob.data.materials[0].node_tree
    loop(tree, tree.nodes["Diffuse BSDF"].inputs["Color"], count)
    background = next(node for node in world.node_tree.nodes if node.bl_idname == "ShaderNodeBackground")
    loop(world.node_tree, background.inputs["Strength"], count)
    blender.context.view_layer.update()
    loop(world.node_tree, background.inputs["Color"], count)
    blender.context.view_layer.update()
    mixes = [tree.nodes.new("ShaderNodeMixShader") for _ in range(2)]
    for one, other in (mixes, mixes[::-1]):
        tree.links.new(one.outputs[0], other.inputs[1])
        tree.links.new(tree.nodes["Diffuse BSDF"].outputs[0], one.inputs[2])
    own = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeOutputMaterial" and node.target == "ALL")
    tree.links.new(mixes[0].outputs[0], own.inputs["Surface"])
    blender.context.view_layer.update()
    assert part("light_state").light_state(world).stale
    assert blender.ops.prt.bake(mode="INTERREFLECTED", samples=4, update_light=False) == {"FINISHED"}
    blender.ops.prt.check()


def test_long_chains_are_walked(blender, part, scene, stage):
    """Of reroutes, and of shaders that are added to themselves, which doubles the paths at each step."""
    material = stage.diffuse(colour=(0.1, 0.2, 0.3))
    tree = material.node_tree
    entry = tree.nodes["Diffuse BSDF"].inputs["Color"]
    for _ in range(300):
        reroute = tree.nodes.new("NodeReroute")
        tree.links.new(reroute.outputs[0], entry)
        entry = reroute.inputs[0]
    tree.links.new(tree.nodes.new("ShaderNodeRGB").outputs[0], entry)
    reading = part("material_reading").read_material(material, "EEVEE")
    assert reading.colour.socket.node.bl_idname == "ShaderNodeRGB"
    mixing = stage.diffuse("Mixing")
    tree = mixing.node_tree
    shader = tree.nodes["Diffuse BSDF"].outputs[0]
    for _ in range(150):
        node = tree.nodes.new("ShaderNodeAddShader")
        tree.links.new(shader, node.inputs[0])
        tree.links.new(shader, node.inputs[1])
        shader = node.outputs[0]
    own = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeOutputMaterial")
    tree.links.new(shader, own.inputs["Surface"])
    assert "more than 100 deep" in part("material_reading").read_material(mixing, "EEVEE").why_not


def plain_colour(nodes, link, colour=(0.2, 0.4, 0.8, 1.0)):
    """A colour, to stand in a shader's place."""
    output = nodes.new("ShaderNodeRGB").outputs[0]
    output.default_value = colour
    return output


def given_colour(blender):
    """A group that puts a colour it is given in a shader's place."""

    def build(nodes, link):
        tree = blender.data.node_groups.new("Shown", "ShaderNodeTree")
        tree.interface.new_socket("Tint", in_out="INPUT", socket_type="NodeSocketColor")
        tree.interface.new_socket("Shader", in_out="OUTPUT", socket_type="NodeSocketShader")
        entry, output = tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")
        tree.links.new(entry.outputs["Tint"], output.inputs[0])
        node = nodes.new("ShaderNodeGroup")
        node.node_tree = tree
        node.inputs["Tint"].default_value = (0.2, 0.4, 0.8, 1.0)
        return node.outputs[0]

    return build


COLOURS = {
    "alone": (lambda blender: plain_colour, (0.2, 0.4, 0.8), (0, 0, 0)),
    "of a group": (given_colour, (0.2, 0.4, 0.8), (0, 0, 0)),
    "mixed": (lambda blender: lambda n, k: mix(n, k, bsdf(n, RED), plain_colour(n, k)), (0.6, 0.2, 0.4), (0.5, 0, 0)),
    "mixed in a group": (
        lambda blender: lambda n, k: mix(n, k, bsdf(n, RED), given_colour(blender)(n, k)),
        (0.6, 0.2, 0.4),
        (0.5, 0, 0),
    ),
}


@pytest.mark.parametrize("case", COLOURS)
def test_a_colour_in_a_shaders_place_is_light(blender, both, part, case):
    """It shines as Blender shows it, reflects nothing, and is said to light nothing around it."""
    build, colour, albedo = COLOURS[case]
    material = material_of(blender, build(blender))
    assert part("material_reading").read_material(material, "EEVEE").emits
    shown, bounced = both(material)
    np.testing.assert_allclose(shown, colour, atol=5e-3)
    np.testing.assert_allclose(bounced, albedo, atol=5e-3)


def test_a_colour_beside_transparency_lets_its_share_through(blender, part):
    """Black does not shine."""

    def cut_out(colour):
        return lambda n, k: mix(n, k, bsdf(n, (1, 1, 1, 1), "Transparent"), plain_colour(n, k, colour), 0.25)

    reading = part("material_reading").read_material(material_of(blender, cut_out((0.2, 0.4, 0.8, 1.0))), "CYCLES")
    assert reading.colour is None and not reading.why_not and reading.emits
    assert reading.through.rgb == pytest.approx((0.75,) * 3)
    black = material_of(blender, grouped(blender, lambda n, k: mix(n, k, bsdf(n, RED), bsdf(n, BLUE))))
    assert not part("material_reading").read_material(black, "CYCLES").emits


def toon(nodes, link, through="ShaderNodeValToRGB"):
    """A Diffuse BSDF in EEVEE's own light, as a colour of three steps."""
    light, steps = nodes.new("ShaderNodeShaderToRGB"), nodes.new("ShaderNodeValToRGB")
    link(bsdf(nodes, (0.8, 0.8, 0.8, 1.0)), light.inputs[0])
    link(light.outputs[0], steps.inputs[0])
    steps.color_ramp.interpolation = "CONSTANT"
    steps.color_ramp.elements[0].color = (0.1, 0.2, 0.5, 1.0)
    steps.color_ramp.elements[1].position, steps.color_ramp.elements[1].color = 0.4, (0.9, 0.8, 0.3, 1.0)
    if through == "ShaderNodeValToRGB":
        return steps.outputs[0]
    emission = nodes.new(through)
    link(steps.outputs[0], emission.inputs[0])
    return emission.outputs[0]


@pytest.mark.parametrize("build", [toon, lambda n, k: toon(n, k, "ShaderNodeEmission")], ids=["colour", "emission"])
def test_the_toon_look_stays(blender, part, scene, stage, tmp_path, build):
    """As EEVEE shows it, pixel by pixel; no light bounces off it, as Cycles has it black; and one sentence says so."""
    material = material_of(blender, build)
    ball = stage.object_of("Ball", stage.icosphere(3), material)
    stage.environment(stage.picture("Six", stage.six_coloured_sky(64)), 0.05)
    lamp = blender.data.objects.new("Sun", blender.data.lights.new("Sun", "SUN"))
    lamp.data.energy, lamp.rotation_euler = 3.0, (0.8, 0.0, 0.0)
    scene.collection.objects.link(lamp)
    stage.top_camera(2.5, 24)
    before = stage.render(tmp_path / "before.exr")
    assert len(np.unique(before[before[..., 3] > 0.99][:, 0].round(2))) == 2, "two steps are in sight"
    assert blender.ops.prt.bake(mode="INTERREFLECTED", samples=4) == {"FINISHED"}
    np.testing.assert_array_equal(stage.render(tmp_path / "after.exr"), before)
    [notice] = part("shading").add_shading([ball])
    assert "makes colours of EEVEE's own light (Shader to RGB)" in notice.sentence
    settings = part("problem").BakeSettings("INTERREFLECTED")
    albedo = part("read").read_bake(blender.context, [ball], settings).scene.occluders.albedo
    assert not albedo.at(np.array([0]), *np.full((2, 1), 1 / 3, dtype=np.float32)).any()


def test_the_toon_look_beside_a_relit_surface(blender, part, scene, stage):
    """What is mixed with it is relit; said once, and not as what emits."""
    material = material_of(blender, lambda n, k: mix(n, k, bsdf(n, RED), toon(n, k)))
    [notice] = part("shading").add_shading([stage.object_of("Ball", stage.icosphere(1), material)])
    assert "Shader to RGB" in notice.sentence
    assert "PRT Diffuse" in blender.data.node_groups
