# SPDX-License-Identifier: GPL-3.0-or-later
"""Baked objects that are appended, linked or overridden show the other file's light, and nothing piles up."""

import numpy as np
import pytest

from tests import bare_blender

BRING = """
other, baked, frame = sys.argv[1:]
bpy.ops.wm.open_mainfile(filepath=other)
for name, link in (("Ball", False), ("Twin", True)):
    with bpy.data.libraries.load(baked, link=link) as (_, target):
        target.objects = [name]
    bpy.context.scene.collection.objects.link(target.objects[0])
bpy.context.scene.render.filepath = frame
bpy.ops.render.render(write_still=True)
"""


@pytest.fixture
def ball(blender, scene, stage):
    """A ball, baked and relit under a sky of its own."""
    stage.environment(stage.picture("Six", stage.six_coloured_sky(16)))
    ob = stage.object_of("Ball", stage.icosphere(3), stage.diffuse())
    blender.ops.prt.bake(mode="SHADOWED", samples=16)
    return ob


@pytest.fixture
def library(blender, ball, tmp_path):
    """The file of it; what is open then is empty."""
    path = tmp_path / "baked.blend"
    blender.ops.wm.save_as_mainfile(filepath=str(path))
    blender.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    return path


def bring(blender, library, link, name="Ball"):
    """The ball of the library, appended or linked, in this scene."""
    with blender.data.libraries.load(str(library), link=link) as (_, target):
        target.objects = [name]
    blender.context.scene.collection.objects.link(target.objects[0])
    blender.context.view_layer.update()
    return target.objects[0]


def test_appended_and_linked_objects_show_the_light_of_the_file_they_are_in(
    blender, part, scene, stage, ball, tmp_path
):
    """The same pixels as where they were baked, under the same sky, with the extension and without."""
    twin = ball.copy()
    twin.name, twin.location, ball.location = "Twin", (0.7, 0, 0), (-0.7, 0, 0)
    ball.scale = twin.scale = (0.6, 0.6, 0.6)
    scene.collection.objects.link(twin)
    baked, other = tmp_path / "baked.blend", tmp_path / "other.blend"
    blender.ops.wm.save_as_mainfile(filepath=str(baked))
    _, mapping = stage.environment(stage.picture("Other", stage.six_coloured_sky(16)[..., ::-1] * 0.5))
    mapping.inputs["Rotation"].default_value = (0.4, -0.9, 2.3)
    blender.ops.prt.project_light()
    stage.top_camera()
    wanted = stage.render(tmp_path / "wanted.exr")
    blender.data.batch_remove([ball, twin])
    blender.ops.outliner.orphans_purge(do_recursive=True)
    assert not blender.data.node_groups
    blender.ops.wm.save_as_mainfile(filepath=str(other))

    bring(blender, baked, False)
    bring(blender, baked, True, "Twin")
    assert len(blender.data.worlds) == 1
    np.testing.assert_allclose(stage.render(tmp_path / "with.exr"), wanted, rtol=1e-3, atol=1e-4)
    frame = tmp_path / "without.exr"
    bare_blender.run(tmp_path, BRING, other, baked, frame)
    np.testing.assert_allclose(stage.read_exr(frame), wanted, rtol=1e-3, atol=1e-4)


def test_groups_do_not_pile_up(blender, part, stage, library):
    """Appending twice brings copies of the node group; the next use makes one of them, and undoes no material."""
    first, second = bring(blender, library, False), bring(blender, library, False)
    names = sorted(tree.name for tree in blender.data.node_groups)
    part("shading").add_shading([second])
    assert sorted(tree.name for tree in blender.data.node_groups) == [name for name in names if "." not in name]
    (group,) = (tree for tree in blender.data.node_groups if "prt_version" in tree)
    assert group.name == "PRT Relight" and group.users == 2
    for ob in (first, second):
        nodes = ob.data.materials[0].node_tree.nodes
        (node,) = (node for node in nodes if node.bl_idname == "ShaderNodeGroup" and node.node_tree == group)
        assert node.outputs["Shading"].is_linked


def test_appended_object_is_as_good_as_ones_own(blender, part, stage, library):
    """It is known to be baked, bakes again, and its material comes back as it was."""
    ob = bring(blender, library, False)
    assert part("freshness").glance(blender.context, ob).state != "NEVER"
    stage.environment(stage.picture("Six", stage.six_coloured_sky(16)))
    assert blender.ops.prt.bake(mode="UNSHADOWED") == {"FINISHED"}
    assert blender.ops.prt.remove() == {"FINISHED"}
    assert "prt_bake" not in ob.data and not ob.data.color_attributes
    assert not any(part("our_nodes").our_nodes(ob.data.materials[0].node_tree))


def test_keyframed_base_colour_is_followed_in_a_linked_material(blender, ball, tmp_path):
    """Playing a file with linked objects: the handlers keep pace, and do not stumble."""
    colour = ball.data.materials[0].node_tree.nodes["Diffuse BSDF"].inputs["Color"]
    for frame, value in ((1, 0.2), (11, 0.6)):
        colour.default_value = (value, value, value, 1.0)
        colour.keyframe_insert("default_value", frame=frame)
    blender.ops.wm.save_as_mainfile(filepath=str(tmp_path / "keyed.blend"))
    blender.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    tree = bring(blender, tmp_path / "keyed.blend", True).data.materials[0].node_tree
    (part,) = (node for node in tree.nodes if "prt_copy_of" in node)
    for frame, value in ((1, 0.2), (11, 0.6), (6, 0.4)):
        blender.context.scene.frame_set(frame)
        np.testing.assert_allclose(part.inputs["Color"].default_value[:3], value, rtol=1e-3)


def linked(blender, library):
    return bring(blender, library, True)


def overridden(blender, library):
    """The usual override: of the object; what it shows stays linked."""
    return bring(blender, library, True).override_create(remap_local_usages=True)


def overridden_to_the_last(blender, library):
    """An override of the mesh, too, which would lose what is written to it when the file is saved."""
    ob = overridden(blender, library)
    ob.data = ob.data.override_create(remap_local_usages=True)
    return ob


@pytest.mark.parametrize("come", [linked, overridden, overridden_to_the_last])
def test_what_is_not_ours_is_refused_by_name(blender, part, stage, library, come):
    """By all that would write to it; looking is allowed, and making it local helps."""
    ob = come(blender, library)
    stage.environment(stage.picture("Six", stage.six_coloured_sky(16)))
    with pytest.raises(RuntimeError, match=r"Mesh 'Sphere' of 'Ball' is (linked|a library override).*: make it local"):
        blender.ops.prt.remove()
    for call in (blender.ops.prt.bake, blender.ops.prt.add_shading):
        with pytest.raises(RuntimeError, match=r"'Ball' is linked from a library, or overrides it: make it .* local"):
            call()
    with pytest.raises(RuntimeError, match="Material 'Clay' of 'Ball' is linked from a library: make it local"):
        blender.ops.prt.remove_shading()
    assert blender.ops.prt.check() == {"FINISHED"}
    assert "prt_light_0" not in blender.context.scene.world
    ob.select_set(True)
    blender.ops.object.make_local(type="ALL")
    (ob,) = blender.context.scene.collection.objects
    assert blender.ops.prt.bake(mode="UNSHADOWED") == {"FINISHED"}
    assert part("layers").is_baked(ob.data)


def test_linked_objects_do_not_hinder_baking_and_removing_others(blender, part, stage, library):
    """Those that are not chosen stay what they are."""
    theirs = bring(blender, library, True)
    own = stage.object_of("Own", stage.cube(), stage.diffuse("Own"), (3, 0, 0))
    stage.environment(stage.picture("Six", stage.six_coloured_sky(16)))
    own.select_set(True)
    blender.ops.prt.bake(mode="SHADOWED", samples=8)
    assert part("layers").is_baked(own.data)
    blender.ops.prt.remove()
    assert not part("layers").is_baked(own.data)
    assert part("layers").is_baked(theirs.data)
    assert "prt_light_0" in blender.context.scene.world, "the linked ball still needs it"


def test_linked_material_and_bare_linked_mesh_cannot_be_relit(blender, scene, stage, capfd, tmp_path):
    """They are named, and what can be done is done."""
    stage.object_of("Bare", stage.cube())
    path = tmp_path / "bare.blend"
    blender.data.libraries.write(str(path), set(blender.data.objects) | {stage.diffuse("Theirs")})
    blender.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    with blender.data.libraries.load(str(path), link=True) as (_, target):
        target.objects, target.materials = ["Bare"], ["Theirs"]
    own = stage.object_of("Own", stage.cube(), target.materials[0])
    stage.environment(stage.picture("Six", stage.six_coloured_sky(16)))
    for material in (target.materials[0], target.materials[0].override_create()):
        own.data.materials[0] = material
        capfd.readouterr()
        assert blender.ops.prt.bake(mode="UNSHADOWED") == {"FINISHED"}
        assert "Warning: Material 'Theirs' is linked from a library, or overrides it" in capfd.readouterr().out
        assert own.data.color_attributes
        with pytest.raises(RuntimeError, match="'Theirs' is linked from a library"):
            blender.ops.prt.add_shading()
    blender.data.objects.remove(own)
    blender.context.scene.collection.objects.link(target.objects[0])
    with pytest.raises(RuntimeError, match="'Bare' is linked from a library"):
        blender.ops.prt.add_shading()


def test_linked_world_cannot_be_projected(blender, part, scene, stage, capfd, library):
    """Nor overridden; its light, if it brings one, still shines."""
    with blender.data.libraries.load(str(library), link=True) as (_, target):
        target.worlds = ["Sky"]
    blender.context.scene.world = target.worlds[0]
    assert not part("light_state").light_state(target.worlds[0]).stale
    own = stage.object_of("Own", stage.cube(), stage.diffuse())
    with pytest.raises(RuntimeError, match="World 'Sky' is linked from a library: make it local"):
        blender.ops.prt.project_light()
    assert blender.ops.prt.bake(mode="UNSHADOWED") == {"FINISHED"}
    assert "World 'Sky' is linked from a library: make it local" in capfd.readouterr().out
    assert own.data.color_attributes
