# SPDX-License-Identifier: GPL-3.0-or-later
"""From a bake to EEVEE's pixels, the light is that of NumPy and of Cycles."""

from math import pi

import numpy as np
import pytest

from tests import bare_blender

ROTATIONS = [(0.0, 0.0, 0.0), (0.0, 0.0, 1.1), (0.7, 0.0, 0.0), (0.4, -0.9, 2.3), (pi, 0.2, -1.0)]


def expected_pixels(part, bpy, stage, base_colour, rotation, strength=1.0):
    """`base * max(T . M(R^-1) L, 0)` at every pixel that sees a face, from what is stored, and which pixels do.

    The lookup turns by R, so the sky turns by R^-1.
    """
    from mathutils import Euler

    light, layers = part("light"), part("layers")
    rotation_matrix = part("rotation").rotation_matrix
    turn = np.array(Euler(rotation).to_matrix())
    turned = rotation_matrix(turn.T) @ light.read_light(bpy.context.scene.world)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    points = stage.pixel_points()
    value, seen = np.zeros((*points.shape[:2], 3)), np.zeros(points.shape[:2], dtype=bool)
    transports = {ob.name: layers.read(ob.data) for ob in bpy.data.objects if ob.type == "MESH"}
    for index in np.ndindex(seen.shape):
        hit, location, _, face, ob, _ = bpy.context.scene.ray_cast(depsgraph, (*points[index], 5.0), (0, 0, -1))
        if not hit:
            continue
        polygon = ob.data.polygons[face]
        corners = np.array([ob.matrix_world @ ob.data.vertices[v].co for v in polygon.vertices])
        assert len(corners) == 3, "the stage is made of triangles"
        weights = np.linalg.lstsq(np.vstack([corners.T, np.ones(3)]), [*location, 1.0], rcond=None)[0]
        elements = ob.data.attributes[layers.LAYERS[0]].domain
        rows = polygon.vertices if elements == "POINT" else polygon.loop_indices
        transport = np.einsum("k,kic->ic", weights, transports[ob.name][list(rows)])
        value[index] = base_colour * stage.without_negatives((transport * turned).sum(axis=0)) * strength
        seen[index] = weights.min() > 0.02  # a pixel on an edge may see either face
    return value, seen


def self_shadowing_stage(stage, blender):
    """A small sphere close above a large one: shadows, curvature, and nothing but triangles."""
    clay = stage.diffuse()
    stage.object_of("Big", stage.icosphere(4), clay)
    stage.object_of("Small", stage.icosphere(2, 0.3), clay, (0.5, 0.3, 1.15))
    stage.top_camera()


def test_eevee_equals_numpy(blender, part, scene, stage, tmp_path):
    """Every pixel, at rotations about every axis: the graph in the shader is the formula."""
    self_shadowing_stage(stage, blender)
    _, mapping = stage.environment(stage.picture("Six", stage.six_coloured_sky()), strength=0.7)
    blender.ops.prt.bake(mode="SHADOWED", samples=64)
    base = np.array([0.8, 0.5, 0.2])
    for rotation in ROTATIONS:
        mapping.inputs["Rotation"].default_value = rotation
        frame = stage.render(tmp_path / "frame.exr")[..., :3]
        wanted, seen = expected_pixels(part, blender, stage, base, rotation, strength=0.7)
        assert seen.sum() > 800
        error = np.abs(frame - wanted)[seen] / wanted[seen].max()
        assert error.max() < 3e-3, f"rotation {rotation}: {error.max():.1e}"


@pytest.mark.slow
def test_flat_faces_equal_numpy(blender, part, scene, stage, tmp_path):
    """A flat-shaded mesh keeps its facets: transport on face corners."""
    stage.object_of("Facets", stage.icosphere(1, smooth=False), stage.diffuse())
    stage.top_camera()
    stage.environment(stage.picture("Six", stage.six_coloured_sky()))
    blender.ops.prt.bake(mode="UNSHADOWED")
    mesh = blender.data.objects["Facets"].data
    assert mesh.attributes["_PRT_0"].domain == "CORNER"
    frame = stage.render(tmp_path / "frame.exr")[..., :3]
    wanted, seen = expected_pixels(part, blender, stage, np.array([0.8, 0.5, 0.2]), (0, 0, 0))
    assert np.abs(frame - wanted)[seen].max() / wanted[seen].max() < 3e-3


def test_direction_agrees_with_cycles(blender, scene, stage, tmp_path):
    """An open sphere under a sky of six colours, shaded by us and path-traced under the world itself."""
    stage.object_of("Ball", stage.icosphere(5), stage.diffuse())
    stage.top_camera()
    _, mapping = stage.environment(stage.picture("Six", stage.six_coloured_sky()))
    for rotation in (ROTATIONS[0], ROTATIONS[1], ROTATIONS[3]):
        mapping.inputs["Rotation"].default_value = rotation
        blender.ops.prt.bake(mode="UNSHADOWED")
        ours = stage.render(tmp_path / "ours.exr")
        truth = stage.render(tmp_path / "truth.exr", "CYCLES", samples=64)
        inside = np.linalg.norm(stage.pixel_points(), axis=-1) < 0.95
        error = (ours - truth)[inside][:, :3]
        noise = 0.03  # 64 samples per pixel
        assert np.sqrt((error**2).mean() / (truth[inside][:, :3] ** 2).mean()) < noise
        assert np.abs(error.mean(axis=0) / truth[inside][:, :3].mean(axis=0)).max() < 5e-3


@pytest.mark.slow
def test_constant_sky_shows_its_radiance(blender, scene, stage, tmp_path):
    """White plane, open, radiance c: it shows c."""
    stage.object_of("Ground", stage.grid(), stage.diffuse(colour=(1.0, 1.0, 1.0)))
    stage.top_camera(scale=1.0)
    stage.environment(stage.picture("Constant", np.full((8, 16, 3), (0.25, 0.5, 2.0))), mapping=False)
    blender.ops.prt.bake(mode="SHADOWED", samples=16)
    frame = stage.render(tmp_path / "frame.exr")[..., :3]
    np.testing.assert_allclose(frame, np.broadcast_to((0.25, 0.5, 2.0), frame.shape), rtol=1e-3)


def test_base_colour_keeps_its_texture_and_unbaked_meshes_their_shader(blender, part, scene, stage, tmp_path):
    """One material: a baked mesh shows texture times light and its own glow, an unbaked mesh what it showed before."""
    material = stage.diffuse()
    tree = material.node_tree
    texture = tree.nodes.new("ShaderNodeTexImage")
    texels = np.array([[(1, 0, 0), (0, 1, 0)], [(0, 0, 1), (0.5, 0.5, 0.5)]], dtype=float)
    texture.image, texture.interpolation = stage.picture("Texels", texels), "Closest"
    shader = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeBsdfDiffuse")
    tree.links.new(texture.outputs["Color"], shader.inputs["Color"])
    baked = stage.object_of("Baked", stage.grid(2, 0.4), material, (-0.5, 0, 0))
    baked.data.uv_layers.new().data.foreach_set(
        "uv",
        np.array(
            [
                (v.co.x / 0.8 + 0.5, v.co.y / 0.8 + 0.5)
                for v in (baked.data.vertices[loop.vertex_index] for loop in baked.data.loops)
            ]
        ).ravel(),
    )
    emission = tree.nodes.new("ShaderNodeEmission")  # what the unbaked one shows as well: as a constant
    emission.inputs["Color"].default_value = (0.1, 0.2, 0.3, 1.0)
    both = tree.nodes.new("ShaderNodeAddShader")
    output = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeOutputMaterial")
    tree.links.new(shader.outputs[0], both.inputs[0])
    tree.links.new(emission.outputs[0], both.inputs[1])
    tree.links.new(both.outputs[0], output.inputs["Surface"])
    stage.object_of("Unbaked", stage.grid(2, 0.4), material, (0.5, 0, 0))
    stage.top_camera(scale=2.0)
    stage.environment(stage.picture("Constant", np.ones((8, 16, 3))))
    baked.select_set(True)
    blender.ops.prt.bake(mode="UNSHADOWED")
    frame = stage.render(tmp_path / "frame.exr")[..., :3]
    points = stage.pixel_points(scale=2.0)
    glow = np.array((0.1, 0.2, 0.3))
    for (row, column), colour in zip(np.ndindex(2, 2), texels.reshape(-1, 3) + glow, strict=True):
        centre = np.array([-0.5 + (column - 0.5) * 0.4, (row - 0.5) * 0.4])
        quadrant = np.abs(points - centre).max(axis=-1) < 0.15
        np.testing.assert_allclose(frame[quadrant], np.broadcast_to(colour, frame[quadrant].shape), atol=2e-3)
    other = np.abs(points - (0.5, 0.0)).max(axis=-1) < 0.35
    shown = frame[other]  # without a UV map the texture is red there
    np.testing.assert_allclose(shown[:, 1:], np.broadcast_to((0.2, 0.3), shown[:, 1:].shape), atol=1e-3)
    np.testing.assert_allclose(shown[:, 0], 1.1, atol=0.05)


def test_saved_file_turns_without_the_extension(blender, part, scene, stage, tmp_path):
    """Save, open in a Blender that lacks us, step through keyframes of rotation and strength: the same pixels."""
    self_shadowing_stage(stage, blender)
    world, mapping = stage.environment(stage.picture("Six", stage.six_coloured_sky()))
    blender.ops.prt.bake(mode="SHADOWED", samples=32)
    strength = next(n for n in world.node_tree.nodes if n.bl_idname == "ShaderNodeBackground").inputs["Strength"]
    keys = {1: ((0.0, 0.0, 0.5), 1.0), 2: ((0.9, -0.4, 2.0), 0.5)}
    for number, (rotation, value) in keys.items():
        mapping.inputs["Rotation"].default_value, strength.default_value = rotation, value
        mapping.inputs["Rotation"].keyframe_insert("default_value", frame=number)
        strength.keyframe_insert("default_value", frame=number)
    ours = {}
    for number in keys:
        scene.frame_set(number)
        ours[number] = stage.render(tmp_path / f"ours{number}.exr")
    frames = bare_blender.rendered(blender, stage, tmp_path, len(keys))
    for theirs, (number, (rotation, value)) in zip(frames, keys.items(), strict=True):
        np.testing.assert_allclose(theirs, ours[number], rtol=1e-3, atol=1e-4)
        wanted, seen = expected_pixels(part, blender, stage, np.array([0.8, 0.5, 0.2]), rotation, value)
        assert np.abs(theirs[..., :3] - wanted)[seen].max() / wanted[seen].max() < 3e-3


def test_keyframed_sky_without_the_extension(blender, part, scene, stage, tmp_path):
    """A Sky Texture whose sun goes round while its strength grows: once keyframed, the frames are those of its own skies."""
    stage.object_of("Ball", stage.icosphere(3), stage.diffuse())
    stage.top_camera(resolution=16)
    world, _ = stage.environment(None)
    tree = world.node_tree
    sky = tree.nodes.new("ShaderNodeTexSky")
    background = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeBackground")
    tree.links.new(sky.outputs["Color"], background.inputs["Color"])
    for frame, turn, strength in ((1, 0.3, 0.1), (2, 2.5, 0.4)):
        sky.sun_rotation, background.inputs["Strength"].default_value = turn, strength
        sky.keyframe_insert("sun_rotation", frame=frame)
        background.inputs["Strength"].keyframe_insert("default_value", frame=frame)
    blender.ops.prt.bake(mode="UNSHADOWED")
    ours = []
    for frame in (1, 2):
        scene.frame_set(frame)  # and thereby projected
        assert not part("light_state").light_state(world).stale
        ours.append(stage.render(tmp_path / "ours.exr"))
    assert blender.ops.prt.keyframe_light(frame_start=1, frame_end=2) == {"FINISHED"}
    for theirs, wanted in zip(bare_blender.rendered(blender, stage, tmp_path, 2), ours, strict=True):
        np.testing.assert_allclose(theirs, wanted, rtol=5e-3, atol=5e-4 * wanted.max())
    brightness = [frame[..., :3].mean() for frame in ours]
    assert brightness[1] > 3 * brightness[0]
    assert not np.allclose(ours[0] / brightness[0], ours[1] / brightness[1], rtol=0.1)  # the sun has moved


def test_negative_channels_keep_their_hue(blender, part, scene, stage, tmp_path):
    """Beside a saturated sun: no blotches where one channel runs out before the others; black where all do."""
    pixels = np.full((32, 64, 3), (0.02, 0.05, 0.1))
    pixels[20:23, 30:33] = (200.0, 60.0, 5.0)
    pixels[10:13, 60:63] = (2.0, 10.0, 60.0)
    stage.environment(stage.picture("Suns", pixels))
    stage.object_of("Ball", stage.icosphere(4), stage.diffuse("White", (1.0, 1.0, 1.0)))
    stage.top_camera()
    shown, mixed = [], 0
    for turn in ((0.0, 0.0, 0.0), (1.7, 0.4, 0.0)):
        scene.world.node_tree.nodes["Mapping"].inputs["Rotation"].default_value = turn
        blender.ops.prt.bake(mode="UNSHADOWED", lamps="NONE")
        shown.append(stage.render(tmp_path / "ball.exr")[..., :3])
        light = part("light").shown_light(scene.world)
        line = stage.pixel_points()
        inside = (line**2).sum(axis=-1) < 0.9
        normals = np.concatenate([line[inside], np.sqrt(1 - (line[inside] ** 2).sum(axis=-1))[:, None]], axis=-1)
        factors = part("sh").per_coefficient(part("sh").cosine_lobe()) / np.pi
        plain = part("sh").basis(normals) @ (factors[:, None] * light)
        expected = stage.without_negatives(plain)
        mixed += np.count_nonzero((plain.min(axis=1) < 0.0) & (plain.mean(axis=1) > 0.0))
        assert np.abs(shown[-1][inside] - expected).max() < 0.02 * expected.max()
    assert mixed > 50
