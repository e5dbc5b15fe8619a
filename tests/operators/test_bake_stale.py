# SPDX-License-Identifier: GPL-3.0-or-later
"""`bpy.ops.prt.bake_stale`: what it bakes again, what it leaves, and the list that panels draw."""

import pytest


@pytest.fixture
def baked(blender, scene, stage):
    """Three shadowed balls in a row and one that was never baked, none selected."""
    stage.environment(stage.picture("Sky", stage.six_coloured_sky(16)))
    balls = [stage.object_of(name, stage.icosphere(1), None, (9.0 * i, 0, 0)) for i, name in enumerate("ABC")]
    scene.prt.mode, scene.prt.samples = "UNSHADOWED", 8
    blender.ops.prt.bake()
    stage.object_of("Never", stage.icosphere(1), None, (0, 9.0, 0))
    return balls


@pytest.fixture
def listed(scene, part):
    """The names in the list of stale bakes."""
    return lambda: [one.name for one in part("freshness").listed_stale(scene)]


def test_bakes_what_is_stale_alone(blender, scene, stage, part, baked, listed):
    """Selected or not; the others keep every byte, and nothing that was never baked is."""
    before = stage.baked_bytes(scene)[0]
    baked[1].rotation_euler.x = 1.0
    blender.context.view_layer.update()
    baked[0].select_set(True)
    assert blender.ops.prt.bake_stale() == {"FINISHED"}
    after = stage.baked_bytes(scene)[0]
    assert {name for name in before if before[name] != after[name]} == {"B"} and not after["Never"][0]
    assert listed() == []
    for ob in scene.objects:
        ob.select_set(ob is baked[1])
    blender.ops.prt.bake()
    assert stage.baked_bytes(scene)[0] == after, "the same bits as the button's"


def test_nothing_to_do_is_no_error(blender, scene, stage, baked):
    """Nothing is written, and no bake begins."""
    before = stage.baked_bytes(scene)
    assert blender.ops.prt.bake_stale() == {"CANCELLED"}
    assert stage.baked_bytes(scene) == before


def test_other_settings_are_a_reason(blender, part, baked, scene):
    """The scene's, or those that a script gives."""
    assert blender.ops.prt.bake_stale(mode="SHADOWED", samples=4) == {"FINISHED"}
    records = [part("record").read_record(ob.data) for ob in baked]
    assert {(one.settings.mode, one.settings.samples) for one in records} == {("SHADOWED", 4)}
    assert blender.ops.prt.bake_stale() == {"FINISHED"}  # back to the scene's


def test_what_does_not_render_is_left(blender, scene, stage, baked, listed):
    """It stays in the list: it is stale, and nothing was done about it."""
    before = stage.baked_bytes(scene)[0]
    baked[2].hide_render = True
    baked[1].rotation_euler.x = 1.0
    blender.context.view_layer.update()
    assert blender.ops.prt.bake_stale() == {"FINISHED"}
    assert stage.baked_bytes(scene)[0]["C"] == before["C"] and listed() == ["C"]
    blender.data.objects.remove(baked[2])
    assert blender.ops.prt.bake_stale() == {"CANCELLED"} and listed() == []


def test_the_list_is_what_checks_found(blender, scene, baked, listed):
    """A check of one object leaves what is known of the others."""
    for ob in baked[:2]:
        ob.rotation_euler.x = 1.0
    blender.context.view_layer.update()
    assert listed() == []
    blender.ops.prt.check()
    assert listed() == ["A", "B"]
    baked[0].rotation_euler.x = 0.0
    blender.context.view_layer.update()
    baked[0].select_set(True)
    blender.ops.prt.check()
    assert listed() == ["B"]
    baked[0].select_set(False)
    baked[1].select_set(True)
    blender.ops.prt.bake()
    assert listed() == []
