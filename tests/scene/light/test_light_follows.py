# SPDX-License-Identifier: GPL-3.0-or-later
"""What the light follows by itself, what it is projected again for, and what is said where it is stale."""

import time

import numpy as np
import pytest

pytestmark = pytest.mark.usefixtures("coarse")


@pytest.fixture
def light(part):
    return part("light")


@pytest.fixture
def state(part, scene):
    """Whether the light of the scene's world is stale, and the phrase."""
    return lambda: part("light_state").light_state(scene.world)


def node_of(world, kind):
    return next(node for node in world.node_tree.nodes if node.bl_idname == kind)


def constant(stage, radiance, name="Constant"):
    """A picture of one radiance: its light shows which one was projected."""
    return stage.picture(name, np.full((4, 8, 3), radiance))


def radiance(light, world):
    """Of a constant sky, from its light; the mean over the channels."""
    return light.read_light(world)[0].mean() / np.sqrt(4 * np.pi)


def swap(stage, world, _mapping):
    node_of(world, "ShaderNodeTexEnvironment").image = constant(stage, 3.0, "Other")


def repaint(stage, world, _mapping):
    image = node_of(world, "ShaderNodeTexEnvironment").image
    image.pixels.foreach_set(np.full(4 * 8 * 4, 3.0, dtype=np.float32))
    image.update_tag()


def triple(stage, world, _mapping):
    """The graph: a node between texture and Background, which makes it more than a picture."""
    tree = world.node_tree
    node = tree.nodes.new("ShaderNodeVectorMath")
    node.operation = "SCALE"
    node.inputs["Scale"].default_value = 3.0
    tree.links.new(node_of(world, "ShaderNodeTexEnvironment").outputs["Color"], node.inputs[0])
    tree.links.new(node.outputs["Vector"], node_of(world, "ShaderNodeBackground").inputs["Color"])


def feed_strength(stage, world, _mapping):
    """By a node that no driver reads: three times as much is then part of the sky."""
    tree = world.node_tree
    node = tree.nodes.new("ShaderNodeMath")
    node.operation = "ADD"
    node.inputs[0].default_value, node.inputs[1].default_value = 1.0, 2.0
    tree.links.new(node.outputs[0], node_of(world, "ShaderNodeBackground").inputs["Strength"])


EDITS = {
    swap: "a picture is another",
    repaint: "was painted on",
    triple: "the nodes have changed",
    feed_strength: "another node sets its strength",
}


@pytest.mark.parametrize("auto", [True, False])
@pytest.mark.parametrize("edit", EDITS)
def test_edits_of_the_sky_are_followed_or_told(blender, scene, stage, light, state, edit, auto):
    """With Follow World, the light is the new sky's at the next update; without, it is stale until it is projected."""
    world, mapping = stage.environment(constant(stage, 1.0))
    blender.ops.prt.project_light()
    blender.context.view_layer.update()
    scene.prt.auto_light = auto
    assert not state().stale
    edit(stage, world, mapping)
    blender.context.view_layer.update()
    if not auto:
        assert np.isclose(radiance(light, world), 1.0)
        assert state().stale and EDITS[edit] in state().text
        blender.ops.prt.project_light()
    assert np.isclose(radiance(light, world), 3.0)
    assert not state().stale


def test_turn_and_strength_project_nothing(blender, part, scene, stage, light, state, monkeypatch):
    """They are followed by drivers: neither an edit nor a keyframe makes the light stale, or costs a projection."""
    world, mapping = stage.environment(stage.picture("Six", stage.six_coloured_sky(16)))
    blender.ops.prt.project_light()
    blender.context.view_layer.update()
    monkeypatch.setattr(part("handlers"), "project", lambda *_: pytest.fail("the sky was projected"))
    strength = node_of(world, "ShaderNodeBackground").inputs["Strength"]
    for frame, value in ((1, 0.5), (9, 2.0)):
        mapping.inputs["Rotation"].default_value, strength.default_value = (0.0, value, 0.0), value
        mapping.inputs["Rotation"].keyframe_insert("default_value", frame=frame)
        strength.keyframe_insert("default_value", frame=frame)
        blender.context.view_layer.update()
    for frame in (1, 4, 9):
        scene.frame_set(frame)
        assert not state().stale
    assert list(world["prt_strength"]) == [2.0, 2.0, 2.0, 1.0]


def test_one_look_per_change(blender, scene, stage, light, coarse):
    """Evaluating a world updates Blender's data, of which the handlers hear: they must not begin anew."""
    world = graph(stage, "flat")
    for count in (1, 2):
        blender.ops.prt.project_light()
        blender.context.view_layer.update()
        assert len(coarse) == count
    node_of(world, "ShaderNodeBackground").inputs["Color"].default_value = (1.0, 2.0, 3.0, 1.0)
    for _ in range(2):
        blender.context.view_layer.update()
    assert len(coarse) == 3 and np.isclose(radiance(light, world), 2.0)


def test_names_and_places_of_nodes_do_not_matter(blender, scene, stage, state):
    """Tidying up is no change; renaming what is followed is, as drivers go by name."""
    world, mapping = stage.environment(constant(stage, 1.0))
    blender.ops.prt.project_light()
    scene.prt.auto_light = False
    texture = node_of(world, "ShaderNodeTexEnvironment")
    texture.location, texture.name, texture.label = (-900, 30), "HDRI", "Sky"
    assert not state().stale
    mapping.name = "Turn"
    assert "another node turns it" in state().text


def test_strength_is_followed_through_a_value_node(blender, scene, stage, light):
    """One that feeds nothing else."""
    world, _ = stage.environment(constant(stage, 1.0))
    value = world.node_tree.nodes.new("ShaderNodeValue")
    world.node_tree.links.new(value.outputs[0], node_of(world, "ShaderNodeBackground").inputs["Strength"])
    value.outputs[0].default_value = 2.0
    blender.ops.prt.project_light()
    assert np.isclose(radiance(light, world), 1.0)
    value.outputs[0].default_value = 5.0
    blender.context.view_layer.update()
    assert list(world["prt_strength"]) == [5.0, 5.0, 5.0, 1.0]


def graph(stage, kind):
    """Worlds that Blender must evaluate; each with what is said of their rotation."""
    world, mapping = stage.environment(constant(stage, 1.0))
    tree = world.node_tree
    background = node_of(world, "ShaderNodeBackground")
    if kind == "two textures by two lookups":
        add = tree.nodes.new("ShaderNodeMix")
        add.data_type = "RGBA"
        tree.links.new(tree.nodes.new("ShaderNodeTexGradient").outputs["Color"], add.inputs["A"])
        tree.links.new(tree.nodes.new("ShaderNodeTexWave").outputs["Color"], add.inputs["B"])
        tree.links.new(next(o for o in add.outputs if o.identifier == "Result_Color"), background.inputs["Color"])
    elif kind == "sun disc":
        tree.links.new(tree.nodes.new("ShaderNodeTexSky").outputs["Color"], background.inputs["Color"])
    elif kind == "flat":
        tree.nodes.remove(node_of(world, "ShaderNodeTexEnvironment"))
    elif kind == "two textures by one Mapping":
        other = tree.nodes.new("ShaderNodeTexGradient")
        tree.links.new(mapping.outputs["Vector"], other.inputs["Vector"])
        mix = tree.nodes.new("ShaderNodeVectorMath")
        tree.links.new(node_of(world, "ShaderNodeTexEnvironment").outputs["Color"], mix.inputs[0])
        tree.links.new(other.outputs["Color"], mix.inputs[1])
        tree.links.new(mix.outputs["Vector"], background.inputs["Color"])
    elif kind == "two backgrounds":
        add = tree.nodes.new("ShaderNodeAddShader")
        other = tree.nodes.new("ShaderNodeBackground")
        tree.links.new(background.outputs[0], add.inputs[0])
        tree.links.new(other.outputs[0], add.inputs[1])
        tree.links.new(add.outputs[0], node_of(world, "ShaderNodeOutputWorld").inputs["Surface"])
    return world


SAID = {
    "two textures by two lookups": "insert Texture Coordinate > Generated and one Mapping node",
    "sun disc": "its rotation is followed through 'Sky Texture'",
    "flat": "the same in all directions",
    "two textures by one Mapping": "followed through 'Mapping'",
    "two backgrounds": "its strength cannot be followed",
}


@pytest.mark.parametrize("kind", SAID)
def test_it_is_said_what_is_followed(part, scene, stage, kind):
    """And what to do where it is not."""
    graph(stage, kind)
    sky = part("sky").read_sky(scene)
    assert sky.texture is None and SAID[kind] in sky.following


def test_what_the_camera_sees_does_not_count(blender, scene, stage, light):
    """A world that shows the camera something else lights the scene with what the others see; within groups, too."""
    world, _ = stage.environment(constant(stage, 1.0))
    tree = world.node_tree
    group = blender.data.node_groups.new("Rays", "ShaderNodeTree")
    group.interface.new_socket("Value", in_out="OUTPUT", socket_type="NodeSocketFloat")
    rays, end = group.nodes.new("ShaderNodeLightPath"), group.nodes.new("NodeGroupOutput")
    group.links.new(rays.outputs["Is Camera Ray"], end.inputs[0])
    node = tree.nodes.new("ShaderNodeGroup")
    node.node_tree = group
    mix, other = tree.nodes.new("ShaderNodeMixShader"), tree.nodes.new("ShaderNodeBackground")
    other.inputs["Color"].default_value = (9.0, 9.0, 9.0, 1.0)
    tree.links.new(node.outputs[0], mix.inputs["Fac" if "Fac" in mix.inputs else "Factor"])
    tree.links.new(node_of(world, "ShaderNodeBackground").outputs[0], mix.inputs[1])
    tree.links.new(other.outputs[0], mix.inputs[2])
    tree.links.new(mix.outputs[0], node_of(world, "ShaderNodeOutputWorld").inputs["Surface"])
    blender.ops.prt.project_light()
    assert np.isclose(radiance(light, world), 1.0, rtol=1e-4)


@pytest.mark.parametrize("fails", [False, True])
def test_evaluation_leaves_no_trace(blender, part, scene, stage, monkeypatch, fails):
    """All data-blocks, the active scene and its settings are what they were, also after a failure."""

    def everything():
        collections = (name for name in dir(blender.data) if isinstance(getattr(blender.data, name), collection_type))
        return {name: [(i.name_full, i.users) for i in getattr(blender.data, name)] for name in collections}, (
            blender.context.scene.name,
            scene.render.engine,
            scene.frame_current,
            blender.context.view_layer.objects.active,
        )

    collection_type = type(blender.data.objects)
    world = graph(stage, "two backgrounds")
    world.node_tree.nodes["Background"].inputs["Strength"].keyframe_insert("default_value", frame=1)
    stage.object_of("Cube", stage.cube())
    before = everything()
    if fails:
        monkeypatch.setattr(part("panorama"), "layer_array", lambda *_: 1 / 0)
    sky, projection = part("sky"), part("projection")
    try:
        projection.project(sky.read_sky(scene), projection.LightSettings())
    except ZeroDivisionError:
        assert fails
    assert everything() == before


@pytest.mark.parametrize("window", ["HANN", "LANCZOS", "AUTO"])
def test_windows(blender, part, scene, stage, light, window):
    """What is stored is windowed; the record says how, and what it did to negative light. A script's word goes first."""
    pixels = np.zeros((16, 32, 3))
    pixels[8, 12] = 100.0
    world, _ = stage.environment(stage.picture("Lamp", pixels))
    blender.ops.prt.project_light()
    plain = light.read_light(world)
    scene.prt.window = "HANN" if window != "HANN" else "NONE"
    blender.ops.prt.project_light(window=window, cutoff=4.0)
    record = world["prt_light"]
    before, after = record["negative"]
    core = part("windowing")
    factors = core.dering(plain).factors if window == "AUTO" else core.band_factors(window, 4.0)
    np.testing.assert_allclose(light.read_light(world), core.windowed(plain, factors), rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(record["factors"], factors)
    assert record["window"] == window and before > 0.1 and after < before
    assert after == 0.0 or window != "AUTO"


def test_a_sun_turns_the_light(blender, part, scene, stage, light, state):
    """A Sky Texture with its disc takes no Vector: its own Sun Rotation turns the light, live and keyframed."""
    world = graph(stage, "sun disc")
    sky = node_of(world, "ShaderNodeTexSky")
    sky.sun_size, sky.sun_elevation = np.radians(20), 0.6
    blender.ops.prt.project_light()
    assert light.followed(world).sun == sky and not light.followed(world).rotation
    stored = light.read_light(world)
    for turn in (0.7, 2.9):
        sky.sun_rotation = turn
        blender.context.view_layer.update()
        assert state().text == "Light is fresh"
        np.testing.assert_array_equal(light.read_light(world), stored)
        turned = light.shown_light(world)
        unfollowed = part("sky").read_sky(scene)
        object.__setattr__(unfollowed, "sun", None)  # Cycles renders the sky as it is turned
        truth = part("projection").project(unfollowed, part("projection").LightSettings()).light
        np.testing.assert_allclose(turned, truth, atol=5e-3 * np.abs(truth).max())
    sky.sun_rotation = 0.0
    sky.keyframe_insert("sun_rotation", frame=1)
    sky.sun_rotation = np.pi / 2
    sky.keyframe_insert("sun_rotation", frame=11)
    scene.frame_set(1)
    first = light.shown_light(world)[[3, 1]]
    scene.frame_set(11)
    assert abs((first * light.shown_light(world)[[3, 1]]).sum()) < 0.02 * (first**2).sum()
    scene.prt.auto_light = False
    sky.sun_elevation = 0.2
    assert "the nodes have changed" in state().text


@pytest.mark.slow
def test_animated_render_shows_each_frames_sky(blender, scene, stage, tmp_path):
    """A background render with the extension and Follow World: the sky of each frame is projected before it is drawn."""
    import headless

    stage.object_of("Ball", stage.icosphere(2), stage.diffuse())
    stage.top_camera(resolution=8)
    world = graph(stage, "flat")
    colour = node_of(world, "ShaderNodeBackground").inputs["Color"]
    for frame, value in ((1, 0.25), (2, 1.0)):
        colour.default_value = (value, value, value, 1.0)
        colour.keyframe_insert("default_value", frame=frame)
    blender.ops.prt.bake(mode="UNSHADOWED")
    scene.render.engine = headless.eevee_engine()
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
    scene.frame_start, scene.frame_end, scene.render.filepath = 1, 2, str(tmp_path / "frame")
    blender.ops.render.render(animation=True)
    first, second = (stage.read_exr(tmp_path / f"frame000{frame}.exr")[4, 4, :3] for frame in (1, 2))
    np.testing.assert_allclose(first, 0.25 * np.array([0.8, 0.5, 0.2]), rtol=2e-3)
    np.testing.assert_allclose(second, 4 * first, rtol=2e-3)


def test_auto_inserts_no_nodes(blender, scene, stage, state):
    """Who links a new texture finds the graph as they left it; the button inserts what is needed to turn the sky."""
    world = graph(stage, "flat")
    blender.ops.prt.project_light()
    tree = world.node_tree
    texture = tree.nodes.new("ShaderNodeTexGradient")
    tree.links.new(texture.outputs["Color"], node_of(world, "ShaderNodeBackground").inputs["Color"])
    count = len(tree.nodes)
    blender.context.view_layer.update()
    assert len(tree.nodes) == count and not state().stale
    assert ["Project World" in sentence for sentence in state().not_followed] == [True]
    blender.ops.prt.project_light()
    assert len(tree.nodes) == count + 2 and not state().stale and not state().not_followed


def test_the_state_is_found_in_linear_time(blender, scene, stage, state):
    """Four times the nodes take about four times as long; sixteen, where each link is searched among all."""
    world, _ = stage.environment(stage.picture("Sky", stage.six_coloured_sky(16)))
    blender.ops.prt.project_light(window="NONE")

    def seconds(count):
        stage.lengthen(world, count)
        times = []
        for _ in range(5):
            began = time.thread_time()
            assert state().stale
            times.append(time.thread_time() - began)
        return min(times)

    few = seconds(60)
    assert seconds(240) < 8.0 * few
