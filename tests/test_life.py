# SPDX-License-Identifier: GPL-3.0-or-later
"""What people do to baked objects, worlds and scenes, and to the session, raises nothing and leaves nothing behind."""

import os
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest


@pytest.fixture(autouse=True)
def no_tracebacks(blender, capfd):
    """Nor threads that outlive a test; handlers print their errors, they do not raise them."""
    capfd.readouterr()
    yield
    said = capfd.readouterr()
    assert "Traceback" not in said.out + said.err and "Error: Python" not in said.out + said.err
    assert not [thread.name for thread in threading.enumerate() if thread is not threading.main_thread()]


@pytest.fixture
def stage(stage_under_sky):
    """Under a sky of six colours in all tests here."""
    return stage_under_sky


@pytest.fixture
def ball(blender, stage):
    """Baked, active and selected."""
    ob = stage.object_of("Ball", stage.icosphere(2), stage.diffuse())
    select(blender, ob)
    blender.context.scene.prt.mode = "SHADOWED"
    blender.context.scene.prt.samples = 8
    blender.ops.prt.bake()
    return ob


@pytest.fixture
def states(blender, part):
    """State of every mesh object by name, as a check finds it."""

    def look():
        blender.context.view_layer.update()
        assert blender.ops.prt.check() == {"FINISHED"}
        meshes = [ob for ob in blender.context.scene.objects if ob.type == "MESH"]
        return {ob.name: part("freshness").glance(blender.context, ob).state for ob in meshes}

    return look


def select(blender, *objects):
    for ob in blender.context.view_layer.objects:
        ob.select_set(ob in objects)
    blender.context.view_layer.objects.active = objects[0]


def test_a_session_leaves_nothing_behind():
    """Enable, disable, reload scripts, load files during bakes: handlers, classes, threads, menus are counted."""
    tests = Path(__file__).parent
    answer = subprocess.run(
        [sys.executable, tests / "session.py"],
        capture_output=True,
        text=True,
        timeout=300,
        env=os.environ | {"PYTHONPATH": str(tests.parent / "tools")},
    )
    said = answer.stdout + answer.stderr
    assert answer.returncode == 0 and "nothing was left behind" in said, said
    assert "Traceback" not in said and "Warning: preset path" not in said, said


def test_duplicates(blender, ball, states):
    """A full copy brings its bake and is another; a linked one is refused until it may have a mesh of its own."""
    blender.ops.object.duplicate()
    copy = blender.context.object
    assert copy != ball and "_PRT_0" in copy.data.attributes
    copy.location.x = 3.0
    select(blender, ball, copy)
    assert states() == {"Ball": "STALE", copy.name: "STALE"}
    assert blender.ops.prt.bake() == {"FINISHED"}
    assert states() == {"Ball": "FRESH", copy.name: "FRESH"}
    select(blender, copy)
    blender.ops.prt.remove()
    assert states()[copy.name] == "NEVER" and "_PRT_0" in ball.data.attributes
    assert len(ball.data.materials[0].node_tree.nodes) > 2, "the ball still needs the shading of their material"

    select(blender, ball)
    blender.ops.object.duplicate(linked=True)
    twin = blender.context.object
    twin.location.x = -3.0
    assert states()[twin.name] == "STALE"
    select(blender, ball, twin)
    assert blender.ops.prt.bake() == {"FINISHED"}
    assert twin.data == ball.data and states() == {"Ball": "FRESH", copy.name: "NEVER", twin.name: "FRESH"}


def test_linked_duplicates_share_their_removal(blender, ball):
    """They share the mesh, so both lose it, and their material is restored."""
    blender.ops.object.duplicate(linked=True)
    blender.ops.prt.remove()
    assert not ball.data.color_attributes and len(ball.data.materials[0].node_tree.nodes) == 2
    assert "prt_light_0" not in blender.context.scene.world


def test_renaming(blender, part, scene, ball, states):
    """Objects, meshes, materials, images and worlds: no name matters."""
    ball.name, ball.data.name, ball.data.materials[0].name = "One", "Two", "Three"
    scene.world.name, blender.data.images[0].name, blender.data.node_groups[0].name = "Four", "Five", "Six"
    groups = len(blender.data.node_groups)
    assert states() == {"One": "FRESH"}
    assert part("light").followed(scene.world).rotation
    assert blender.ops.prt.bake() == {"FINISHED"}
    assert states() == {"One": "FRESH"} and len(blender.data.node_groups) == groups
    blender.ops.prt.remove()
    assert states() == {"One": "NEVER"}


def test_deleting(blender, scene, part, stage, ball):
    """The last baked object takes nothing with it; what is left can be cleared, or is refused in one sentence."""
    other = stage.object_of("Other", stage.cube(), None, (3, 0, 0))
    blender.ops.object.delete()
    assert [ob.name for ob in blender.data.objects] == ["Other"]
    assert part("freshness").glance(blender.context, other).state == "NEVER"
    select(blender, other)
    assert blender.ops.prt.remove() == {"FINISHED"}
    assert not part("light").has_light(scene.world), "nothing that is shown is baked any more"
    blender.ops.object.delete()
    for call in (blender.ops.prt.bake, blender.ops.prt.check, blender.ops.prt.add_shading):
        with pytest.raises(RuntimeError, match="no mesh to bake"):
            call()
    blender.ops.prt.project_light()
    assert blender.ops.prt.remove() == {"FINISHED"} and not part("light").has_light(scene.world)


def test_joining(blender, stage, ball, states):
    """Baked and unbaked, on vertices and on corners: one object, known to be stale, that bakes again."""
    flat = stage.object_of("Flat", stage.cube(), stage.diffuse("Paint"), (3, 0, 0))
    plain = stage.object_of("Plain", stage.cube(), None, (-3, 0, 0))
    select(blender, flat)
    blender.ops.prt.bake()
    assert {ob.data.attributes["_PRT_0"].domain for ob in (ball, flat)} == {"POINT", "CORNER"}
    select(blender, ball, flat, plain)
    blender.ops.object.join()
    assert states() == {"Ball": "STALE"}
    assert blender.ops.prt.bake() == {"FINISHED"}
    assert states() == {"Ball": "FRESH"} and len(ball.data.color_attributes) == 9
    blender.ops.prt.remove()
    assert not ball.data.color_attributes and not blender.data.node_groups


def test_separating(blender, stage, ball, states):
    """Both halves are known to be stale, and bake again."""
    with_island = stage.object_of("Island", stage.cube(), None, (4, 0, 0))
    select(blender, ball, with_island)
    blender.ops.object.join()
    blender.ops.prt.bake()
    blender.ops.object.mode_set(mode="EDIT")
    blender.ops.mesh.select_all(action="SELECT")
    blender.ops.mesh.separate(type="LOOSE")
    blender.ops.object.mode_set(mode="OBJECT")
    assert list(states().values()) == ["STALE", "STALE"]
    assert blender.ops.prt.bake() == {"FINISHED"}
    assert list(states().values()) == ["FRESH", "FRESH"]
    blender.ops.prt.remove()
    assert list(states().values()) == ["NEVER", "NEVER"]


def test_swapping_and_copying_worlds(blender, part, scene, stage, ball):
    """Another world has no light until it is projected; a copy follows its own nodes."""
    light = part("light")
    scene.prt.auto_light = False
    first = scene.world
    second, mapping = stage.environment(stage.picture("Other", stage.six_coloured_sky(16) * 2.0))
    assert not light.has_light(second)
    with pytest.raises(RuntimeError, match="carries no SH light"):
        blender.ops.prt.export_games202(directory=blender.app.tempdir)
    blender.ops.prt.project_light()
    np.testing.assert_allclose(light.read_light(second), 2.0 * light.read_light(first), rtol=1e-4, atol=1e-4)
    copy = scene.world = second.copy()
    followed = light.followed(copy).rotation.node
    followed.inputs["Rotation"].default_value[2] = 1.0
    blender.context.view_layer.update()
    assert not np.allclose(light.read_turn(copy), np.eye(3))
    np.testing.assert_allclose(light.read_turn(second), np.eye(3))
    assert mapping.inputs["Rotation"].default_value[2] == 0.0
    blender.ops.prt.remove()
    assert not any(light.has_light(world) for world in (first, second, copy))


def test_two_scenes_with_worlds_of_their_own(blender, part, scene, stage, ball, tmp_path):
    """One baked object in both: each scene shows it under its own world's light."""
    light = part("light")
    stage.top_camera(scale=0.05, resolution=8)
    frames = {}
    for name, strength in (("first", 1.0), ("second", 3.0)):
        if name == "second":
            blender.ops.scene.new(type="LINK_COPY")
            blender.context.scene.world = scene.world.copy()
            background = light.followed(blender.context.scene.world).strength.node
            background.inputs["Strength"].default_value = strength
        frames[name] = stage.render(tmp_path / f"{name}.exr")[..., :3]
    assert blender.context.scene != scene and ball.name in blender.context.scene.objects
    np.testing.assert_allclose(frames["second"], 3.0 * frames["first"], rtol=2e-3)
    assert frames["first"].min() > 0.0


def test_the_window_shows_another_scene_when_a_bake_ends(blender, part, scene, stage, ball):
    """What was read is written where it was read: objects, light and all."""
    inputs, whole_bake = part("problem"), part("whole_bake")
    settings = inputs.BakeSettings(mode="UNSHADOWED")
    ball.modifiers.new("Finer", "SUBSURF")
    whole = whole_bake.WholeBake(blender.context, settings, part("projection").LightSettings(), True)
    results = part("bake").bake(whole.plan.problem)
    blender.ops.scene.new(type="NEW")
    other = blender.context.scene
    other.world = blender.data.worlds.new("Other")
    assert other != scene
    whole.write(blender.context, results)
    assert blender.context.scene == other and not part("light").has_light(other.world)
    assert part("light").has_light(scene.world) and part("carrier").carrier_of(ball)
    assert len(part("carrier").transport_mesh(ball).vertices) == len(results.transport[0])


def test_what_moved_while_a_bake_ran_is_not_called_fresh(blender, part, scene, ball):
    """A vertex ends it, as its result is of what was read; an object that was moved is for a check to find."""
    settings = part("problem").BakeSettings(mode="SHADOWED", samples=16)

    def bake(change):
        whole = part("whole_bake").WholeBake(blender.context, settings)
        result = part("bake").bake(whole.plan.problem)
        change()
        blender.context.view_layer.update()
        whole.write(blender.context, result)
        return part("freshness").glance(blender.context, ball, settings).state

    assert bake(lambda: None) == "FRESH"

    def pull_a_vertex():
        ball.data.vertices[0].co.z += 0.3
        ball.data.update()

    with pytest.raises(part("errors").MeshError, match="'Ball' was edited during the bake"):
        bake(pull_a_vertex)
    assert bake(lambda: None) == "FRESH"

    def put_it_aside():
        ball.location.z += 0.3

    assert bake(put_it_aside) in {"UNCHECKED", "STALE"}
    blender.ops.prt.check()
    assert part("freshness").glance(blender.context, ball, settings).state == "STALE"


def test_loading_another_file(blender, part, scene, ball, tmp_path):
    """After a bake, and back again: what was baked is there, and what the session knew of it does no harm."""
    path = str(tmp_path / "baked.blend")
    blender.ops.wm.save_as_mainfile(filepath=path)
    blender.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    with pytest.raises(RuntimeError, match="no mesh to bake"):
        blender.ops.prt.check()
    blender.ops.wm.open_mainfile(filepath=path)
    ob = blender.data.objects["Ball"]
    assert part("freshness").glance(blender.context, ob).state == "UNCHECKED"
    blender.ops.prt.check()
    assert part("freshness").glance(blender.context, ob).state == "FRESH"


def test_disabling_forgets_all(blender, part, ball):
    """What the session has looked up is cleared in one place, and is not there when the extension is enabled again."""
    import headless

    session = part("session").session
    blender.ops.prt.check()
    ball.location.x = 1.0
    blender.context.view_layer.update()
    assert session.engine and session.notices and session.checked and session.shapes_changed
    with headless.extension_disabled():
        assert vars(session) == vars(type(session)())


def test_handlers_leave_other_versions_and_libraries_alone(blender, ball, tmp_path):
    """Editing and playing a file whose materials hold a newer group, whatever its sockets are called."""
    (group,) = (tree for tree in blender.data.node_groups if "prt_version" in tree)
    group["prt_version"] = 99
    next(item for item in group.interface.items_tree if item.name == "Base Color").name = "Albedo"
    shader = ball.data.materials[0].node_tree.nodes["Diffuse BSDF"]
    shader.inputs["Color"].default_value = (0.1, 0.2, 0.3, 1.0)
    shader.inputs["Color"].keyframe_insert("default_value", frame=1)
    blender.context.view_layer.update()
    blender.context.scene.frame_set(5)
    (part,) = (node for node in ball.data.materials[0].node_tree.nodes if "prt_copy_of" in node)
    np.testing.assert_allclose(part.inputs["Color"].default_value[:3], (0.8, 0.5, 0.2), rtol=1e-6)
