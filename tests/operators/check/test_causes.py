# SPDX-License-Identifier: GPL-3.0-or-later
"""`freshness` finds which changes make which bakes stale, and passes over those that do not matter."""

import numpy as np
import pytest

from tests.operators.check.changes import (
    COLOURS,
    EVERYONE,
    GEOMETRY,
    MOVED,
    NOTHING,
    OTHERS,
    bend_normals,
    paint,
    push_vertex,
    select,
    sharpen,
    shift,
    turn,
)

MODES = ("UNSHADOWED", "SHADOWED", "INTERREFLECTED")
CHANGES = [
    # what is done to the ball, and what it does to the ball and to the others, by mode
    (shift, (NOTHING, NOTHING), (MOVED, OTHERS), (MOVED, OTHERS)),
    (turn, (MOVED, NOTHING), (MOVED, OTHERS), (MOVED, OTHERS)),
    (push_vertex, (GEOMETRY, NOTHING), (GEOMETRY, OTHERS), (GEOMETRY, OTHERS)),
    (sharpen, (GEOMETRY, NOTHING), (GEOMETRY, NOTHING), (GEOMETRY, OTHERS)),
    (bend_normals, (GEOMETRY, NOTHING), (GEOMETRY, NOTHING), (GEOMETRY, OTHERS)),
    (paint, (NOTHING, NOTHING), (NOTHING, NOTHING), (COLOURS, COLOURS)),
]


@pytest.mark.parametrize("mode", MODES)
def test_each_cause_is_told_of_those_it_concerns(three, bake, stale, mode):
    """And no other; baking again makes all fresh."""
    for change, *by_mode in CHANGES:
        bake(mode)
        assert stale() == {}
        change(three[1])
        its_own, of_others = by_mode[MODES.index(mode)]
        expected = {"Floor": of_others, "Ball": its_own, "Cube": of_others}
        assert stale() == {name: causes for name, causes in expected.items() if causes}, change.__name__


def test_what_does_not_matter(blender, scene, stage, three, bake, stale):
    """Names, selection, cameras, lights, the sky, materials' names, colour layers that nothing reads."""
    floor, ball, cube = three
    bake("INTERREFLECTED")
    ball.name, ball.data.name, ball.data.materials[0].name = "Aaa", "Bbb", "Ccc"
    select(blender, cube)
    blender.context.view_layer.objects.active = floor
    stage.top_camera().location = (3, 4, 5)
    lamp = blender.data.objects.new("Lamp", blender.data.lights.new("Lamp", "POINT"))
    scene.collection.objects.link(lamp)
    stage.environment(stage.picture("Other sky", np.ones((2, 4, 3))))
    cube.data.color_attributes.new("Unused", "FLOAT_COLOR", "POINT")
    assert stale() == {}


@pytest.mark.parametrize("mode", ["SHADOWED", "INTERREFLECTED"])
def test_newcomers_and_leavers_are_noticed(blender, stage, three, bake, stale, mode):
    """Whatever shades, be it a curve or an instance; what renders do not show does not."""
    bake(mode)
    curve = blender.data.curves.new("Text", "FONT")
    curve.body, curve.extrude = "A", 0.1
    text = stage.object_of("Text", curve)
    assert stale() == dict.fromkeys(EVERYONE, OTHERS)
    text.hide_render = True
    assert stale() == {}
    collection = blender.data.collections.new("Balls")
    collection.objects.link(three[1])
    empty = stage.object_of("Empty", None, location=(0, 3, 0))
    empty.instance_type, empty.instance_collection = "COLLECTION", collection
    assert stale() == dict.fromkeys(EVERYONE, OTHERS)
    blender.data.objects.remove(empty)
    assert stale() == {}
    three[2].hide_render = True
    assert stale() == {"Floor": OTHERS, "Ball": OTHERS, "Cube": {"HIDDEN"}}


def test_subsets_agree_with_the_whole(blender, part, three, bake, stale):
    """Which objects are baked or checked together makes no difference."""
    floor, ball, cube = three
    bake("INTERREFLECTED", cube)
    bake("INTERREFLECTED", ball, floor)
    assert stale() == {}
    shift(cube)
    blender.context.view_layer.update()
    freshness = part("freshness").freshness
    for company in ([ball], [ball, cube], [cube, floor, ball]):
        found = {one.name: set(one.causes) for one in freshness(blender.context, company)}
        assert found["Ball"] == OTHERS
    bake("INTERREFLECTED", ball)
    assert stale() == {"Floor": OTHERS, "Cube": MOVED}


def test_modes_side_by_side(blender, three, bake, stale):
    """Each bake is compared by its own mode, whatever the modes of its neighbours."""
    floor, ball, cube = three
    for mode, ob in (("UNSHADOWED", floor), ("SHADOWED", cube), ("INTERREFLECTED", ball)):
        bake(mode, ob)

    def causes():
        return {name: found - {"SETTINGS"} for name, found in stale().items() if found != {"SETTINGS"}}

    assert causes() == {}
    sharpen(floor)  # the cube sees its shape alone, the ball also what it bounces
    assert causes() == {"Floor": GEOMETRY, "Ball": OTHERS}
    sharpen(floor)
    paint(ball)
    assert causes() == {"Ball": COLOURS}
    shift(floor)
    assert causes() == {"Cube": OTHERS, "Ball": OTHERS}


def test_texels_and_swapped_colours(blender, stage, three, bake, stale):
    """One changed texel counts, and so do two objects that trade their materials, and nodes that Cycles evaluates."""
    _, ball, cube = three
    bake("INTERREFLECTED")
    image = blender.data.images["Texels"]
    pixels = np.array(image.pixels, dtype=np.float32)
    pixels[5] = 1.0 - pixels[5]
    image.pixels.foreach_set(pixels)
    assert stale() == dict.fromkeys(EVERYONE, COLOURS)
    cube.data.materials[0] = stage.diffuse("Green", (0, 1, 0))
    bake("INTERREFLECTED")
    cube.data.materials[0], ball.data.materials[0] = ball.data.materials[0], cube.data.materials[0]
    assert stale() == dict.fromkeys(EVERYONE, COLOURS)
    nodes, links = (getattr(ball.data.materials[0].node_tree, name) for name in ("nodes", "links"))
    noise = nodes.new("ShaderNodeTexNoise")
    links.new(noise.outputs["Color"], next(n for n in nodes if n.bl_idname == "ShaderNodeBsdfDiffuse").inputs["Color"])
    bake("INTERREFLECTED")
    assert stale() == {}
    noise.inputs["Scale"].default_value = 11.0
    assert stale() == dict.fromkeys(EVERYONE, COLOURS)


def test_duplicates_do_not_cancel(blender, stage, bake, stale):
    """Two objects of one shape in one place are two occluders; the second to come or go is noticed."""
    ball = stage.object_of("Ball", stage.icosphere(2))
    bake("SHADOWED")
    twins = [stage.object_of("Twin", stage.cube()) for _ in range(2)]
    bake("SHADOWED")
    assert stale() == {}
    for twin in twins:
        blender.data.objects.remove(twin)
    assert stale() == {ball.name: OTHERS}


@pytest.mark.parametrize("mode", ["SHADOWED", "INTERREFLECTED"])
def test_an_object_baked_for_itself_may_move(blender, three, bake, stale, mode):
    """Turned, mirrored, in other company, it stays fresh; its scale, its geometry and its own colours count."""
    floor, ball, _ = three
    floor.prt.space = "OBJECT"
    bake(mode)
    shift(floor)
    floor.rotation_euler = (1.0, 2.0, 3.0)
    floor.scale = (-1.0, 1.0, 1.0)
    shift(ball)
    assert stale() == {"Ball": MOVED | OTHERS, "Cube": OTHERS}
    floor.scale.y = 1.01
    assert stale()["Floor"] == MOVED
    floor.prt.space = "SCENE"
    assert stale()["Floor"] == MOVED | {"SETTINGS"}
