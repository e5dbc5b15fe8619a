# SPDX-License-Identifier: GPL-3.0-or-later
"""`bpy.ops.prt.check` reports, panels draw and scripts catch what is stale, in words that name the cause."""

import pytest

from tests.operators.check.changes import GEOMETRY, MOVED, OTHERS, select, shift


def test_settings_that_matter_to_the_mode(blender, scene, part, three, bake):
    """Said with both values; what the mode does not use is not compared."""
    floor, _, _ = three
    glance = part("freshness").glance

    def said():
        [found] = part("freshness").freshness(blender.context, [floor])
        assert glance(blender.context, floor) == found
        return found.text

    bake("SHADOWED", floor)
    scene.prt.bounces, scene.prt.tolerance = 9, 0.5
    assert said() == "fresh"
    scene.prt.samples, scene.prt.seed = 512, 7
    assert said() == "stale: baked with other settings (8 samples, now 512; seed 0, now 7)"
    scene.prt.mode = "UNSHADOWED"
    assert said() == "stale: baked with other settings (shadowed, now unshadowed)"
    bake("UNSHADOWED", floor)
    scene.prt.samples = 99
    assert said() == "fresh"
    bake("INTERREFLECTED", floor)
    scene.prt.bounces = 1
    assert said() == "fresh"
    scene.prt.tolerance = 0.25
    assert said() == "stale: baked with other settings (tolerance 0.5, now 0.25)"
    scene.prt.tolerance = 0.0
    assert said() == "stale: baked with other settings (9 bounces, now 1; tolerance 0.5, now 0)"


def test_never_baked_removed_and_older_versions(blender, scene, part, three, bake):
    """What cannot be checked says so."""
    floor, ball, cube = three
    bake("SHADOWED", floor, ball)
    record = ball.data["prt_bake"].to_dict()
    del record["fingerprint"], record["elements"]
    ball.data["prt_bake"] = cube.data["prt_bake"] = record | {"version": 1}  # the cube has no layers
    found = part("freshness").freshness(blender.context, three)
    assert [one.state for one in found] == ["FRESH", "UNKNOWN", "NEVER"]
    assert found[1].text == "of unknown origin: bake again to be able to check"


def test_the_drawn_state_follows_at_once_or_with_the_next_check(blender, scene, part, stage, three, bake):
    """Moves and counts are seen without a check; deeper causes as the last check or bake of the session found them."""
    floor, ball, cube = three
    module = part("freshness")

    def drawn(ob):
        blender.context.view_layer.update()
        found = module.glance(blender.context, ob)
        return found.state, set(found.causes)

    assert drawn(floor) == ("NEVER", set())
    bake("SHADOWED")
    assert drawn(floor) == ("FRESH", set())
    part("session").session.checked.clear()  # as in the next session
    assert drawn(floor) == ("UNCHECKED", set())
    assert blender.ops.prt.check() == {"FINISHED"}
    assert drawn(floor) == ("FRESH", set())
    shift(cube)
    assert drawn(cube) == ("STALE", MOVED) and drawn(floor) == ("FRESH", set())
    blender.ops.prt.check()
    assert drawn(floor) == ("STALE", OTHERS)
    cube.location.x -= 0.1
    assert drawn(cube) == ("FRESH", set()) and drawn(floor) == ("STALE", OTHERS)
    shift(cube)
    bake("SHADOWED")
    assert drawn(floor) == ("FRESH", set())
    ball.data.vertices.add(1)
    assert drawn(ball) == ("STALE", GEOMETRY)


def test_reports(blender, part, three, bake, capfd):
    """A line per object and a summary."""
    floor, ball, _ = three
    bake("SHADOWED", floor, ball)
    shift(ball)
    capfd.readouterr()
    assert blender.ops.prt.check() == {"FINISHED"}
    said = capfd.readouterr().out
    assert "'Floor': stale: other objects changed or moved." in said
    assert "'Ball': stale: it was moved." in said
    assert "'Cube': never baked." in said
    assert "3 object(s): 2 stale, 1 never baked." in said
    select(blender, floor)
    blender.ops.prt.check(samples=3)
    assert "(8 samples, now 3).\nInfo: 1 object(s): 1 stale." in capfd.readouterr().out


def test_a_script_may_ask_for_an_error(blender, three, bake):
    """That names what is stale, and nothing else."""
    floor, ball, _ = three
    bake("SHADOWED", floor, ball)
    assert blender.ops.prt.check(fail_if_stale=True) == {"FINISHED"}
    shift(ball)
    blender.context.view_layer.update()
    with pytest.raises(RuntimeError, match="Stale: 'Ball', 'Floor'"):
        blender.ops.prt.check(fail_if_stale=True)
    assert blender.ops.prt.check() == {"FINISHED"}
