# SPDX-License-Identifier: GPL-3.0-or-later
"""`bpy.ops.prt.bake` of objects that cannot be baked: they are named, and the rest is baked."""

import pytest


@pytest.fixture
def stage(stage_under_sky):
    return stage_under_sky


def nan_mesh(stage):
    mesh = stage.cube()
    mesh.vertices[3].co.x = float("nan")
    return stage.object_of("Broken", mesh)


def faceless(stage):
    import bpy

    mesh = bpy.data.meshes.new("Points")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0)], [(0, 1)], [])
    return stage.object_of("Broken", mesh)


def nan_place(stage):
    ob = stage.object_of("Broken", stage.cube())
    ob.rotation_euler.x = float("nan")
    return ob


def scaled_to_nothing(stage):
    ob = stage.object_of("Broken", stage.cube())
    ob.scale = (0.0, 0.0, 0.0)
    return ob


def hidden(stage):
    ob = stage.object_of("Broken", stage.cube())
    ob.hide_render = True
    return ob


def sheared(stage):
    """An object that may move, turned inside a parent that is scaled unevenly."""
    parent = stage.object_of("Parent", None)
    parent.scale = (1.0, 3.0, 1.0)
    ob = stage.object_of("Broken", stage.cube())
    ob.parent, ob.rotation_euler.z, ob.prt.space = parent, 0.5, "OBJECT"
    return ob


def instancer(stage):
    ob = stage.object_of("Broken", stage.cube())
    ob.instance_type = "VERTS"
    ob.show_instancer_for_render = False
    return ob


@pytest.mark.parametrize(
    ("build", "said"),
    [
        (nan_mesh, "NaN"),
        (nan_place, "NaN"),
        (faceless, "no faces"),
        (scaled_to_nothing, "scaled to nothing"),
        (hidden, "does not render"),
        (sheared, "is sheared"),
        (instancer, "does not render"),
    ],
)
def test_what_cannot_be_baked_is_named_and_the_rest_is_baked(blender, scene, stage, capfd, build, said):
    """One sentence that names the object and says what to do; alone, it is an error and everything is as it was."""
    good = stage.object_of("A good one", stage.cube(), location=(9, 0, 0))
    ob = build(stage)
    for each in scene.objects:
        each.select_set(True)
    blender.context.view_layer.update()
    assert blender.ops.prt.bake(mode="SHADOWED", samples=16) == {"FINISHED"}
    [line] = [line for line in capfd.readouterr().out.splitlines() if "Broken" in line]
    assert said in line and "_PRT_0" in good.data.attributes and "_PRT_0" not in ob.data.attributes
    blender.ops.prt.remove()
    good.select_set(False)
    with pytest.raises(RuntimeError, match=f"Nothing can be baked: .*'Broken'.*{said}|{said}.*'Broken'"):
        blender.ops.prt.bake(mode="SHADOWED", samples=16)
    assert not ob.data.materials and not good.data.materials


def test_many_of_a_kind_are_one_sentence(blender, scene, stage, capfd):
    stage.object_of("Good", stage.cube(), location=(9, 0, 0))
    for _ in range(12):
        faceless(stage)
    for each in scene.objects:
        each.select_set(True)
    blender.ops.prt.bake(mode="SHADOWED", samples=16)
    [line] = [line for line in capfd.readouterr().out.splitlines() if "no faces" in line]
    assert line.startswith("Info: 12 objects have no faces") and line.endswith("and 7 more.")


def test_a_selected_lamp_is_no_mesh(blender, scene, stage):
    """The user meant something: not everything else."""
    stage.object_of("Cube", stage.cube())
    lamp = blender.data.objects.new("Lamp", blender.data.lights.new("Lamp", "POINT"))
    scene.collection.objects.link(lamp)
    lamp.select_set(True)
    with pytest.raises(RuntimeError, match="None of the selected objects is a mesh"):
        blender.ops.prt.bake(mode="SHADOWED", samples=16)
    lamp.select_set(False)
    assert blender.ops.prt.bake(mode="SHADOWED", samples=16) == {"FINISHED"}


def test_linked_mesh_is_left_out(blender, scene, stage, capfd, tmp_path):
    """Library data cannot hold the result; the rest is baked."""
    ob = stage.object_of("Linked", stage.cube())
    path = str(tmp_path / "library.blend")
    blender.data.libraries.write(path, {ob})
    blender.data.objects.remove(ob)
    with blender.data.libraries.load(path, link=True) as (_, target):
        target.objects = ["Linked"]
    scene.collection.objects.link(target.objects[0])
    with pytest.raises(RuntimeError, match=r"'Linked' is linked from a library.* local"):
        blender.ops.prt.bake(mode="UNSHADOWED")
    stage.object_of("Own", stage.cube())
    assert blender.ops.prt.bake(mode="UNSHADOWED") == {"FINISHED"}
    assert "'Linked' is linked from a library" in capfd.readouterr().out


def test_scene_without_meshes_is_refused(blender, scene, stage):
    """Nothing to bake is an error, not a success."""
    with pytest.raises(RuntimeError, match="no mesh to bake"):
        blender.ops.prt.bake()
