# SPDX-License-Identifier: GPL-3.0-or-later
"""Reading the scene as it renders sees what renders see, and leaves everything as it was."""

import numpy as np
import pytest


@pytest.fixture
def look(blender, part):
    """What a function finds in the scene as it renders."""
    return lambda read: part("rendered").as_rendered(blender.context, read)


@pytest.fixture
def cube(scene, stage):
    return stage.object_of("Cube", stage.cube())


def mode(depsgraph):
    return depsgraph.mode


def test_it_is_the_state_of_renders(blender, scene, cube, look):
    modifier = cube.modifiers.new("Subdivision", "SUBSURF")
    modifier.levels, modifier.render_levels = 1, 2

    def read(depsgraph):
        [shown] = [instance.object for instance in depsgraph.object_instances]
        return depsgraph.mode, shown.original == cube, len(shown.to_mesh().vertices)

    assert look(read) == ("RENDER", True, 98)


def test_nothing_stays_behind(blender, scene, cube, look):
    """Settings, camera, handlers, images and data-blocks; with handlers of the user's that would notice."""
    heard = []
    scene.render.use_border, scene.render.resolution_x, scene.view_layers[0].use = True, 321, False
    handlers = [blender.app.handlers.render_pre, blender.app.handlers.frame_change_post]
    for one in handlers:
        one.append(lambda *_: heard.append("handler"))
    before = [list(one) for one in handlers]

    def state():
        render = scene.render
        return (
            [render.engine, render.resolution_x, render.resolution_y, render.use_border, render.use_compositing],
            scene.camera,
            scene.view_layers[0].use,
            len(blender.data.objects),
            len(blender.data.cameras),
            len(blender.data.images),
            [list(one) for one in handlers],
            [name for name in dir(blender.types) if name == "PRT_READER"],
        )

    was = state()
    assert look(mode) == "RENDER"
    assert state() == was and not heard
    with pytest.raises(ZeroDivisionError):
        look(lambda _: 1 / 0)
    assert state() == was and [list(one) for one in handlers] == before
    for one in handlers:
        one.pop()


def test_the_last_picture_stays(blender, scene, cube, look, stage, tmp_path):
    """A render that the user has made is still there to be saved."""
    stage.top_camera(resolution=16)
    before = stage.render(tmp_path / "before.exr")
    result = blender.data.images["Render Result"]
    active = result.render_slots.active_index
    look(mode)
    assert result.render_slots.active_index == active
    result.save_render(str(tmp_path / "after.exr"))
    np.testing.assert_array_equal(stage.read_exr(tmp_path / "after.exr"), before)
    slots = len(result.render_slots)
    look(mode)
    assert len(result.render_slots) == slots


@pytest.mark.parametrize("path", ["location", "rotation_euler", "hide_render", '["mine"]'])
def test_values_that_nobody_has_keyed_yet_stay(blender, scene, cube, look, path):
    """Animated, and then changed by hand: read as the viewport shows it, and still so afterwards."""
    cube["mine"] = 1.0

    def get():
        value = cube.path_resolve(path)
        return value if isinstance(value, (bool, float)) else tuple(value)

    def put(value):
        if path == '["mine"]':
            cube["mine"] = value
        else:
            setattr(cube, path, value)

    change = {"hide_render": True, '["mine"]': 5.0}.get(path, (5.0, 0.0, 0.0))
    cube.keyframe_insert(path, frame=1)
    put(change)
    blender.context.view_layer.update()
    before = np.array(cube.matrix_world)

    def read(depsgraph):
        return [np.array(instance.object.matrix_world) for instance in depsgraph.object_instances]

    np.testing.assert_array_equal(look(read), [before] * (path != "hide_render"))
    assert get() == change
    np.testing.assert_array_equal(np.array(cube.matrix_world), before)
    curves = cube.animation_data.action.layers[0].strips[0].channelbag(cube.animation_data.action_slot).fcurves
    assert not any(curve.mute for curve in curves)
    scene.frame_set(1)
    assert get() != change


def test_poses_stay(blender, scene, stage, look):
    """The same of a bone, and of what it moves."""
    rig = stage.rig()
    bone = rig.pose.bones["Bone"]
    bone.keyframe_insert("location", frame=1)
    bone.location.x = 2.0
    look(mode)
    assert bone.location.x == 2.0
    scene.frame_set(1)
    assert bone.location.x == 0.0
