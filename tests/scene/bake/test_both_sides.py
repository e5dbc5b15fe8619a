# SPDX-License-Identifier: GPL-3.0-or-later
"""Backs of faces receive light and return it, as in Cycles: a sheet is shown as well as the same thing with two walls.

The sky holds nothing beyond order 2. What is left to differ is shown by a sheet of some thickness, whose walls show fronts alone.
"""

from math import radians

import numpy as np
import pytest

RESOLUTION = 64
SIZE = 2.0
BOUNCES = 5


def look(blender, stage, location, rotation, scale):
    """A square view along the camera's own -z."""
    stage.top_camera(scale, RESOLUTION)
    camera = blender.context.scene.camera
    camera.location, camera.rotation_euler = location, [radians(angle) for angle in rotation]


def card(blender, stage):
    """A card over a white floor, seen from below and aside."""
    look(blender, stage, (0.0, -6.0, 2.4), (75.0, 0.0, 0.0), 3.6)
    stage.object_of("Floor", stage.grid(40, 4.0), stage.diffuse("White", (0.8, 0.8, 0.8)))
    sheet = stage.object_of("Sheet", stage.grid(40, 1.0), stage.diffuse("Green", (0.2, 0.7, 0.1)), (0.0, 0.0, 1.2))
    sheet.rotation_euler = (radians(-50.0), 0.0, radians(15.0))
    return sheet


def leaf(blender, stage):
    """A bent leaf over a white floor, seen from below and aside."""
    sheet = card(blender, stage)
    for vertex in sheet.data.vertices:
        vertex.co.z += 0.5 * (1.0 - vertex.co.x**2)
    return sheet


def room(blender, stage):
    """A room of single walls whose fronts are outside, seen through its open side; a red floor and a ball in it."""

    def build(bm):
        import bmesh

        bmesh.ops.create_cube(bm, size=SIZE)
        bmesh.ops.delete(bm, geom=[face for face in bm.faces if face.normal.y < -0.5], context="FACES")
        bmesh.ops.subdivide_edges(bm, edges=bm.edges[:], cuts=23, use_grid_fill=True)

    look(blender, stage, (0.0, -5.0, 0.3), (86.0, 0.0, 0.0), 2.2)
    stage.object_of("Ball", stage.icosphere(4, 0.4), stage.diffuse("Red", (0.8, 0.1, 0.1)), (0.3, 0.2, -0.55))
    return stage.object_of(
        "Sheet", stage.from_bmesh("Room", build, smooth=False), stage.diffuse("White", (0.8, 0.8, 0.8))
    )


def curtain(blender, stage):
    """The same room, its walls thick, and a curtain before its window, seen from inside."""
    walls = room(blender, stage)
    thicken(walls)
    look(blender, stage, (0.0, 0.9, 0.0), (90.0, 0.0, 180.0), 1.9)
    sheet = stage.object_of("Curtain", stage.grid(40, 0.9), stage.diffuse("Blue", (0.3, 0.4, 0.8)), (0.25, -0.7, 0.0))
    sheet.rotation_euler, sheet.scale.x = (radians(90.0), 0.0, 0.0), 0.7
    return sheet


def thicken(sheet):
    solid = sheet.modifiers.new("Thickness", "SOLIDIFY")
    solid.thickness, solid.offset = SIZE / 50.0, 0.0


def error(blender, stage, tmp_path, least=0.2):
    """Relative RMS of EEVEE's picture of a bake against Cycles'."""
    scene = blender.context.scene
    cycles = scene.cycles
    cycles.max_bounces = cycles.diffuse_bounces = BOUNCES
    cycles.pixel_filter_type, cycles.filter_width = "GAUSSIAN", 0.01  # the middle of each pixel
    assert blender.ops.prt.bake(mode="INTERREFLECTED", bounces=BOUNCES, samples=256) == {"FINISHED"}
    truth = stage.render(tmp_path / "truth.exr", "CYCLES", 512)
    shown = stage.render(tmp_path / "shown.exr")
    there = np.minimum(truth[..., 3], shown[..., 3]) > 0.99
    assert there.mean() > least
    truth, shown = truth[there][:, :3], shown[there][:, :3]
    return np.sqrt(((shown - truth) ** 2).mean() / (truth**2).mean())


@pytest.mark.parametrize("scenery", [card, leaf, room, curtain])
def test_a_sheet_is_as_right_as_two_walls(blender, scene, stage, tmp_path, scenery):
    world, _ = stage.environment(stage.picture("Six", stage.six_coloured_sky()), 0.5)
    world.cycles.sampling_method = "NONE"  # so soft a sky is found by the cosine alone: ten times as fast
    sheet = scenery(blender, stage)
    thin = error(blender, stage, tmp_path)
    sheet.prt.sides = "FRONTS"
    fronts = error(blender, stage, tmp_path)
    sheet.prt.sides = "AUTO"
    thicken(sheet)
    thick = error(blender, stage, tmp_path)
    assert thin < 1.3 * thick
    assert fronts > 2.0 * thin


def below(blender, stage, name="Sheet", location=(0.0, 0.0, 0.0), material=None):
    """A sheet that faces up, seen from below."""
    look(blender, stage, (0.0, 0.0, -5.0), (180.0, 0.0, 0.0), 4.0)
    return stage.object_of(name, stage.grid(10, 0.8), material or stage.diffuse("White", (1.0, 1.0, 1.0)), location)


def shown_below(stage, tmp_path):
    """The mean colour of what a picture shows."""
    pixels = stage.render(tmp_path / "below.exr")
    return pixels[pixels[..., 3] > 0.99][:, :3].mean(axis=0)


def layers_of(ob):
    return {name for name in ob.data.attributes.keys() if name.startswith("_PRT_B")}  # noqa: SIM118 - a collection of bpy


def test_sides_say_what_has_backs(blender, part, scene, stage):
    """A sheet has, a ball has not; a setting overrules, and makes the bake stale; with culled backs there is nothing to see."""
    stage.environment(stage.picture("Six", stage.six_coloured_sky()))
    sheet, ball = below(blender, stage), stage.object_of("Ball", stage.icosphere(2), stage.diffuse(), (5.0, 0.0, 0.0))
    bake = {"mode": "SHADOWED", "samples": 16}
    blender.ops.prt.bake(**bake)
    assert len(layers_of(sheet)) == 3 and not layers_of(ball)

    def states():
        return [found.state for found in part("freshness").freshness(blender.context, [sheet, ball])]

    scene.prt.mode, scene.prt.samples = "SHADOWED", 16
    assert states() == ["FRESH", "FRESH"]
    sheet.prt.sides, ball.prt.sides = "FRONTS", "BOTH"
    assert states() == ["STALE", "STALE"]
    blender.ops.prt.bake(**bake)
    assert len(layers_of(ball)) == 3 and not layers_of(sheet)
    sheet.prt.sides, sheet.data.materials[0].use_backface_culling = "BOTH", True
    blender.ops.prt.bake(**bake)
    assert not layers_of(sheet)
    blender.ops.prt.remove()
    assert not layers_of(ball)


def test_backs_face_the_other_way(blender, part, scene, stage, tmp_path):
    """From below a white sheet shows what one that is turned over shows, also behind modifiers and after a turn of its own axes."""
    stage.environment(stage.picture("Six", stage.six_coloured_sky()))
    sheet = below(blender, stage)
    sheet.prt.sides = "FRONTS"
    sheet.rotation_euler.x = radians(180.0)
    blender.ops.prt.bake(mode="SHADOWED", samples=64)
    wanted = shown_below(stage, tmp_path)
    sheet.prt.sides, sheet.rotation_euler.x = "AUTO", 0.0
    blender.ops.prt.bake(mode="SHADOWED", samples=64)
    np.testing.assert_allclose(shown_below(stage, tmp_path), wanted, rtol=5e-3)
    sheet.modifiers.new("Finer", "SUBSURF").levels = 1
    blender.ops.prt.bake(mode="SHADOWED", samples=64)
    assert part("carrier").carrier_of(sheet) and not layers_of(sheet)
    np.testing.assert_allclose(shown_below(stage, tmp_path), wanted, rtol=5e-3)
    sheet.prt.space, sheet.rotation_euler.x = "OBJECT", radians(30.0)
    blender.ops.prt.bake(mode="SHADOWED", samples=64)
    sheet.rotation_euler.x = 0.0
    np.testing.assert_allclose(shown_below(stage, tmp_path), wanted, rtol=5e-3)


def test_a_shared_material_shows_each_mesh_its_own(blender, scene, stage, tmp_path):
    """Beside a sheet with backs, one without shows the light of its fronts there."""
    stage.environment(stage.picture("Six", stage.six_coloured_sky()))
    one = below(blender, stage, location=(-0.9, 0.0, 0.0))
    other = below(blender, stage, "Other", (0.9, 0.0, 0.0), one.data.materials[0])
    other.prt.sides = "FRONTS"
    blender.ops.prt.bake(mode="UNSHADOWED")
    pixels = stage.render(tmp_path / "below.exr")[..., :3]
    half = RESOLUTION // 4
    shown = {side: pixels[2 * half, k] for side, k in (("left", half), ("right", 3 * half))}
    up, down = stage.six_colours(np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]))
    assert np.linalg.norm(shown["left"] - shown["right"]) > 0.2 * np.linalg.norm(up - down)
    one.prt.sides = "FRONTS"
    blender.ops.prt.bake(mode="UNSHADOWED")
    pixels = stage.render(tmp_path / "below.exr")[..., :3]
    np.testing.assert_allclose(pixels[2 * half, half], pixels[2 * half, 3 * half], rtol=1e-4)


@pytest.mark.parametrize(("maps", "fits"), [(2, True), (3, False)])
def test_backs_give_way_to_textures(blender, part, scene, stage, tmp_path, maps, fits):
    """EEVEE takes 14 attributes: beside transport and backs a material may read two. Its sheet is never pink."""
    stage.environment(stage.picture("Six", stage.six_coloured_sky()))
    sheet = below(blender, stage)
    tree = sheet.data.materials[0].node_tree
    shader, before = tree.nodes["Diffuse BSDF"], None
    for number in range(maps):
        sheet.data.uv_layers.new(name=f"Map {number}")
        node, add = tree.nodes.new("ShaderNodeUVMap"), tree.nodes.new("ShaderNodeVectorMath")
        node.uv_map = f"Map {number}"
        tree.links.new(node.outputs[0], add.inputs[0])
        if before:
            tree.links.new(before.outputs[0], add.inputs[1])
        before = add
    tree.links.new(before.outputs[0], shader.inputs["Color"])
    blender.ops.prt.bake(mode="UNSHADOWED", update_shading=False)
    notices = [notice.sentence for notice in part("shading").add_shading([sheet])]
    assert any("no room for the three of backs" in sentence for sentence in notices) != fits
    red, green, blue = shown_below(stage, tmp_path)
    assert blue < 0.05 < min(red, green)  # UV maps have no third number; pink has


def test_suns_reach_backs(blender, scene, stage, tmp_path):
    """A sun below the horizon, taken out of the sky as a lamp, lights the backs of a card and leaves their soft light."""
    pixels = stage.sunny_sky()
    stage.environment(stage.picture("Sunny", pixels[::-1].copy()), 0.3)
    sheet = leaf(blender, stage)
    blender.data.objects.remove(blender.data.objects["Floor"])
    found = error(blender, stage, tmp_path, least=0.1)
    sheet.prt.sides = "FRONTS"
    fronts = error(blender, stage, tmp_path, least=0.1)
    assert found < 0.06 and fronts > 3.0 * found
