# SPDX-License-Identifier: GPL-3.0-or-later
"""`prt.bake_shard` and `prt.merge_shards`: the result of one bake bit for bit, and a word on whatever does not fit."""

import itertools
import tempfile
from pathlib import Path

import numpy as np
import pytest

OPTIONS = {"samples": 48, "bounces": 2, "seed": 4}


@pytest.fixture
def stage(stage_under_sky):
    """A floor, two balls of one mesh's shape, and a cube that is baked for itself."""
    stage = stage_under_sky
    grey, red = stage.diffuse("Grey", (0.7, 0.7, 0.7)), stage.diffuse("Red", (0.9, 0.1, 0.1))
    stage.object_of("Floor", stage.grid(16, 2.0), grey)
    stage.object_of("Ball", stage.icosphere(3, 0.6), red, (0, 0, 0.7))
    stage.object_of("Other ball", stage.icosphere(3, 0.6), grey, (1.3, 0, 0.7))
    stage.object_of("Moving", stage.cube(), red, (-1.3, 0, 1.5)).prt.space = "OBJECT"
    return stage


def bake_shards(bpy, folder, count, indices=None, **options):
    for index in range(count) if indices is None else indices:
        answer = bpy.ops.prt.bake_shard(index=index, count=count, directory=str(folder), **{**OPTIONS, **options})
        assert answer == {"FINISHED"}


def merge(bpy, folder, **options):
    return bpy.ops.prt.merge_shards(directory=str(folder), **{**OPTIONS, **options})


@pytest.fixture
def forget(part):
    """Traces kept in memory would make it easy."""
    part("job").end_engine()
    return part("job").end_engine


def double(folder):
    """Make what rays found in a folder twice as bright: what is then baked shows whether it was taken from there."""
    for path in folder.glob("*.npz"):
        with np.load(path) as stored:
            arrays = {name: stored[name] for name in stored.files}
        np.savez(path, **arrays | {"direct": 2 * arrays["direct"]})


def test_what_lies_in_the_folder_needs_no_rays(blender, part, scene, stage, tmp_path, forget):
    """Of shards and of checkpoints; other samples cast theirs."""

    def floor():
        return part("layers").read(scene.objects["Floor"].data)

    blender.ops.prt.bake(mode="SHADOWED", **OPTIONS)
    plain = floor()
    shards, checkpoints = tmp_path / "shards", tmp_path / "checkpoints"
    bake_shards(blender, shards, 2, mode="SHADOWED")
    double(shards)
    assert merge(blender, shards, mode="SHADOWED") == {"FINISHED"}
    assert np.array_equal(floor(), 2 * plain)
    for _ in range(2):
        blender.ops.prt.bake(mode="SHADOWED", checkpoint_dir=str(checkpoints), **OPTIONS)
        double(checkpoints)
    assert np.array_equal(floor(), 2 * plain)
    blender.ops.prt.bake(mode="SHADOWED", checkpoint_dir=str(checkpoints), **{**OPTIONS, "samples": 49})
    assert floor() == pytest.approx(plain, abs=0.1)


@pytest.mark.parametrize("mode", ["SHADOWED", "INTERREFLECTED"])
def test_shards_merge_to_the_plain_bake(blender, scene, stage, tmp_path, mode, forget):
    """Layers, record and light, byte by byte; until then the file has nothing of it."""
    before = stage.baked_bytes(scene)
    bake_shards(blender, tmp_path, 3, [2, 0, 1], mode=mode)
    assert stage.baked_bytes(scene) == before
    assert not any(material.node_tree.nodes.get("PRT Output") for material in blender.data.materials)
    forget()
    assert merge(blender, tmp_path, mode=mode) == {"FINISHED"}
    merged = stage.baked_bytes(scene)
    forget()
    blender.ops.prt.bake(mode=mode, **OPTIONS)
    assert stage.baked_bytes(scene) == merged
    assert [len(layers) for layers, _ in merged[0].values()] == [12, 9, 9, 9]  # one is a sheet, with backs


def test_whatever_order_objects_are_selected_in(blender, scene, stage, tmp_path, forget):
    """Each shard and the merge find the same objects selected in another order, and another one active."""
    chosen = [scene.objects[name] for name in ("Ball", "Floor", "Moving")]
    orders = itertools.permutations(chosen)

    def select_again():
        for ob in chosen:
            ob.select_set(False)
        for ob in next(orders):
            ob.select_set(True)
            blender.context.view_layer.objects.active = ob

    for index in range(3):
        select_again()
        bake_shards(blender, tmp_path, 3, [index], mode="INTERREFLECTED")
    select_again()
    forget()
    merge(blender, tmp_path, mode="INTERREFLECTED")
    merged = stage.baked_bytes(scene)
    select_again()
    forget()
    blender.ops.prt.bake(mode="INTERREFLECTED", **OPTIONS)
    assert stage.baked_bytes(scene) == merged
    assert [bool(layers) for layers, _ in merged[0].values()] == [True, True, False, True]


def test_colours_may_change_until_the_merge(blender, scene, stage, tmp_path, forget):
    """Rays do not depend on them."""
    bake_shards(blender, tmp_path, 2, mode="INTERREFLECTED")
    blender.data.materials["Red"].node_tree.nodes["Diffuse BSDF"].inputs["Color"].default_value = (0.1, 0.9, 0.1, 1)
    forget()
    merge(blender, tmp_path, mode="INTERREFLECTED")
    merged = stage.baked_bytes(scene)
    forget()
    blender.ops.prt.bake(mode="INTERREFLECTED", **OPTIONS)
    assert stage.baked_bytes(scene) == merged


def moved(bpy):
    bpy.data.objects["Ball"].location.x += 0.1


def edited(bpy):
    bpy.data.objects["Ball"].data.vertices[0].co.z += 0.1
    bpy.data.objects["Ball"].data.update()


def sharpened(bpy):
    bpy.data.objects["Ball"].data.polygons[0].use_smooth = False


def chosen(bpy):
    bpy.data.objects["Ball"].select_set(True)


def freed(bpy):
    bpy.data.objects["Ball"].prt.space = "OBJECT"


@pytest.mark.parametrize("change", [moved, edited, sharpened, chosen, freed])
def test_shards_of_another_scene_are_refused(blender, scene, stage, tmp_path, change):
    """Whatever rays depend on; nothing is written."""
    bake_shards(blender, tmp_path, 2, mode="SHADOWED")
    change(blender)
    blender.context.view_layer.update()
    before = stage.baked_bytes(scene)
    with pytest.raises(RuntimeError, match="does not belong to this bake"):
        merge(blender, tmp_path, mode="SHADOWED")
    assert stage.baked_bytes(scene) == before


def test_other_settings_and_missing_shards_are_refused(blender, scene, stage, tmp_path):
    before = stage.baked_bytes(scene)
    bake_shards(blender, tmp_path, 3, [0, 2], mode="SHADOWED")
    with pytest.raises(RuntimeError, match="missing or unfinished: 1"):
        merge(blender, tmp_path, mode="SHADOWED")
    bake_shards(blender, tmp_path, 3, [1], mode="SHADOWED", seed=5)
    with pytest.raises(RuntimeError, match="seed 5 instead of 4"):
        merge(blender, tmp_path, mode="SHADOWED")
    assert stage.baked_bytes(scene) == before


def test_what_cannot_be_shared_is_refused(blender, scene, stage, tmp_path):
    for answer in (bake_shards, merge):
        with pytest.raises(RuntimeError, match="Unshadowed transport"):
            answer(blender, tmp_path, *([1] if answer is bake_shards else []), mode="UNSHADOWED")
    with pytest.raises(RuntimeError, match="shard 3 of 3"):
        bake_shards(blender, tmp_path, 3, [3], mode="SHADOWED")
    with pytest.raises(RuntimeError, match="no folder"):
        blender.ops.prt.bake_shard(index=0, count=1)
    with pytest.raises(RuntimeError, match="never saved"):
        blender.ops.prt.bake_shard(index=0, count=1, directory="//shards")
    with pytest.raises(RuntimeError, match="never saved"):
        blender.ops.prt.bake(mode="SHADOWED", checkpoint_dir="//checkpoints")
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(RuntimeError, match="cannot be used"):
        bake_shards(blender, tmp_path / "file", 1, mode="SHADOWED")


def test_checkpoints_come_from_the_setting(blender, scene, stage, tmp_path, forget):
    """A bake that was done is done again with the same bits, by another session too."""
    folder = tmp_path / "new" / "folder"
    scene.prt.checkpoint_dir = str(folder)
    blender.ops.prt.bake(mode="INTERREFLECTED", **OPTIONS)
    plain = stage.baked_bytes(scene)
    assert len(list(folder.iterdir())) == 2  # one for the scene, one for the cube
    forget()
    blender.ops.prt.remove()
    blender.ops.prt.bake(mode="INTERREFLECTED", **OPTIONS)
    assert stage.baked_bytes(scene) == plain
    blender.ops.prt.bake(mode="SHADOWED", checkpoint_dir="", **OPTIONS)
    assert len(list(folder.iterdir())) == 2


def test_memory_is_a_setting_that_changes_no_bits(blender, part, scene, stage, forget):
    """With none at all, every hit lies in a file that the engine keeps open."""

    def mapped():
        engine = part("session").session.engine.process
        maps = Path(f"/proc/{engine}/maps").read_text().splitlines()
        return sum(tempfile.gettempdir() in line and "deleted" in line for line in maps)

    blender.ops.prt.bake(mode="INTERREFLECTED", **OPTIONS)
    plain = stage.baked_bytes(scene)
    assert not mapped()
    forget()
    scene.prt.memory = 0
    blender.ops.prt.bake(mode="INTERREFLECTED", **OPTIONS)
    assert stage.baked_bytes(scene) == plain
    assert mapped() >= 1
