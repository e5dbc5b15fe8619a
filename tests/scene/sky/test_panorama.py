# SPDX-License-Identifier: GPL-3.0-or-later
"""Any world becomes an SH light, which integrals over Blender's own rendering of it confirm."""

import numpy as np
import pytest

ROTATIONS = [(0.0, 0.0, 0.0), (0.0, 0.0, 1.1), (0.7, 0.0, 0.0), (0.4, -0.9, 2.3), (3.1, 0.2, -1.0)]

SAMPLES = 64  # per pixel of the rendered spheres, where one sun in a pixel is most of the noise; a power of 4 is evenly spread


@pytest.fixture
def sphere_camera(scene, stage, tmp_path):
    """Renders the world all around: (N, 3) radiance. What a pixel sees, and of how much, Blender renders, too."""
    import bpy

    camera = bpy.data.objects.new("Sphere", bpy.data.cameras.new("Sphere"))
    scene.collection.objects.link(camera)
    camera.rotation_euler = (1.2, 0.3, 0.5)  # any will do
    camera.data.type = "PANO"
    owner = camera.data if hasattr(camera.data, "panorama_type") else camera.data.cycles
    owner.panorama_type = "EQUIRECTANGULAR"
    scene.camera = camera
    scene.render.resolution_x, scene.render.resolution_y = 256, 128
    scene.cycles.pixel_filter_type = "BOX"
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False

    def render(samples, filter_width=1.0):
        scene.cycles.filter_width = filter_width
        scene.world.cycles.sampling_method = "NONE"
        return stage.render(tmp_path / "sphere.exr", "CYCLES", samples)[..., :3].reshape(-1, 3).astype(np.float64)

    return render


@pytest.fixture
def brute_force(scene, stage, sphere_camera, part):
    """The SH light (9, 3) of whatever world the scene has, by directions that were themselves rendered."""
    import bpy

    world = bpy.data.worlds.new("Directions")
    stage.use_nodes(world)
    tree = world.node_tree
    background = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeBackground")
    tree.links.new(tree.nodes.new("ShaderNodeTexCoord").outputs["Generated"], background.inputs["Color"])
    scene.world = world
    directions = sphere_camera(1, 0.01)
    assert np.allclose(np.linalg.norm(directions, axis=1), 1.0, atol=1e-3)
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    height = scene.render.resolution_y
    row = (np.arange(height) + 0.5) / height * np.pi
    weights = np.repeat(np.sin(row), len(directions) // height)
    harmonics = part("sh").basis(directions) * (4 * np.pi * weights / weights.sum())[:, None]
    return lambda samples: harmonics.T @ sphere_camera(samples)


def lamps(sign, width=128):
    """Three skies in one picture, one a channel: black, but for one hot spot on an axis, 17 degrees wide.

    The rendered spheres see smaller ones too noisily. About a pole it is twice as wide: half a texel of each pole bleeds
    to the other in Cycles, though not in EEVEE; what we project does not.
    """
    height = width // 2
    pixels = np.zeros((height, width, 3))
    for channel, (x, y, z) in enumerate(np.eye(3) * sign):
        if z:
            rows, columns = slice(-12, None) if z > 0 else slice(12), np.arange(width)
        else:
            centre = int((0.5 - np.arctan2(y, x) / (2 * np.pi)) * width)
            rows, columns = slice(height // 2 - 3, height // 2 + 3), np.arange(centre - 3, centre + 3) % width
        pixels[rows, columns, channel] = 10.0
    return pixels


def through_nodes(world):
    """The same picture by a detour: a Mix with black by nothing, which makes it a graph that only Blender can evaluate."""
    tree = world.node_tree
    background = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeBackground")
    mix = tree.nodes.new("ShaderNodeMix")
    mix.data_type = "RGBA"
    colours = {entry.identifier: entry for entry in mix.inputs}
    colours["Factor_Float"].default_value = 0.0
    tree.links.new(background.inputs["Color"].links[0].from_socket, colours["A_Color"])
    result = next(output for output in mix.outputs if output.identifier == "Result_Color")
    tree.links.new(result, background.inputs["Color"])


def relative(light, truth):
    """(3,) error of each channel."""
    return np.linalg.norm(light - truth, axis=0) / np.linalg.norm(truth, axis=0)


@pytest.mark.parametrize(
    "sky", ["+", pytest.param("-", marks=pytest.mark.slow), pytest.param("forest", marks=pytest.mark.slow)]
)
def test_light_is_what_blender_renders(blender, part, scene, stage, brute_force, sky):
    """Of seven skies, as picture and as a graph, at five rotations: within a thousandth of Blender's own world."""
    import headless

    light = part("light")
    if sky in "+-":
        image = stage.picture("Lamps", lamps(1 if sky == "+" else -1))
    else:
        pixels = part("images").linear_pixels(blender.data.images.load(str(headless.studio_hdri(sky))))
        image = stage.picture(
            "Forest", pixels.reshape(64, 8, 128, 8, 3).mean(axis=(1, 3))
        )  # no finer than the integrals
    world, mapping = stage.environment(image)
    truths = []
    for rotation in ROTATIONS:
        mapping.inputs["Rotation"].default_value = rotation
        truths.append(brute_force(SAMPLES))
    for detour in (False, True):
        if detour:
            through_nodes(world)
        blender.ops.prt.project_light()
        for rotation, truth in zip(ROTATIONS, truths, strict=True):
            mapping.inputs["Rotation"].default_value = rotation
            error = relative(light.shown_light(world), truth)
            assert error.max() < 1e-3


def test_mirror_ball_is_what_blender_renders(blender, part, scene, stage, brute_force):
    """A smooth ball: within a thousandth, so that neither a mirrored axis nor a wrong solid angle can hide."""
    height, width = 200, 160
    x, z = np.meshgrid(2 * (np.arange(width) + 0.5) / width - 1, 2 * (np.arange(height) + 0.5) / height - 1)
    depth = np.sqrt(np.maximum(1 - x**2 - z**2, 0))
    seen = np.stack([2 * x * depth, 1 - 2 * depth**2, 2 * z * depth], axis=-1)
    pixels = 1.5 + np.where((depth > 0)[..., None], seen, (0, 1, 0)) + np.sin(2 * x)[..., None]
    world, mapping = stage.environment(stage.picture("Ball", pixels))
    texture = next(node for node in world.node_tree.nodes if node.bl_idname == "ShaderNodeTexEnvironment")
    texture.projection = "MIRROR_BALL"
    blender.ops.prt.project_light()
    mapping.inputs["Rotation"].default_value = ROTATIONS[3]
    error = relative(part("light").shown_light(world), brute_force(16))
    assert error.max() < 1e-3


def world_of(kind):
    """A world with one node that looks along the view, on its Background."""
    import bpy
    from headless import use_nodes

    world = bpy.data.worlds.new("Graph")
    bpy.context.scene.world = world
    use_nodes(world)
    tree = world.node_tree
    background = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeBackground")
    node = tree.nodes.new(kind)
    tree.links.new(node.outputs["Color"], background.inputs["Color"])
    return world, node, background


def test_gradient_turns_through_an_inserted_mapping(blender, part, scene, stage, brute_force):
    """A texture that looks along the view gets a Mapping node to be turned by; the light follows it and the strength."""
    world, _, background = world_of("ShaderNodeTexGradient")
    blender.ops.prt.project_light()
    mapping = next(node for node in world.node_tree.nodes if node.bl_idname == "ShaderNodeMapping")
    mapping.inputs["Rotation"].default_value = ROTATIONS[3]
    background.inputs["Strength"].default_value = 2.5
    assert relative(part("light").shown_light(world), brute_force(16)).max() < 1e-3


def test_small_sun_is_found(part, scene):
    """A disc of half a degree, hundred thousand times as bright as its sky, made of nodes: within 1e-3 of closed form."""
    import bpy
    from headless import use_nodes

    radius, towards = np.radians(0.2725), np.array([0.36, -0.48, 0.8])
    world = bpy.data.worlds.new("Sun")
    use_nodes(world)
    scene.world = world
    tree = world.node_tree
    background = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeBackground")
    across = tree.nodes.new("ShaderNodeVectorMath")  # the sine of the angle: a cosine would lose it in float32
    across.operation = "CROSS_PRODUCT"
    tree.links.new(tree.nodes.new("ShaderNodeTexCoord").outputs["Generated"], across.inputs[0])
    across.inputs[1].default_value = towards
    value = across.outputs["Vector"]
    for kind, operation, number in (
        ("Vector", "LENGTH", None),
        ("", "LESS_THAN", np.sin(radius)),
        ("", "MULTIPLY", 1e5),
    ):
        node = tree.nodes.new(f"ShaderNode{kind}Math")
        node.operation = operation
        tree.links.new(value, node.inputs[0])
        if number:
            node.inputs[1].default_value = number
        value = node.outputs["Value"]
    tree.links.new(value, background.inputs["Color"])  # a disc, and another behind
    sky, projection, sh = part("sky"), part("projection"), part("sh")
    light = projection.project(sky.read_sky(scene), projection.LightSettings()).light
    height = 1 - np.cos(radius)
    cap = 2 * np.pi * height * np.array([1, 0, (1 - height) * (2 - height) / 2])
    wanted = 1e5 * 2 * sh.basis(towards) * sh.per_coefficient(cap)  # both: odd bands cancel
    assert np.linalg.norm(light - wanted[:, None]) / np.linalg.norm(wanted) / np.sqrt(3) < 1e-3
