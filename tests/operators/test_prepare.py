# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes that are shared or made by modifiers: refused, or given a copy by an explicit setting, and nothing is lost."""

import numpy as np
import pytest


@pytest.fixture
def stage(scene):
    import stage

    stage.environment(stage.picture("Sky", stage.six_coloured_sky(16)))
    return stage


@pytest.fixture
def is_baked(part):
    return part("layers").is_baked


def twins(stage):
    mesh = stage.icosphere(2)
    return [stage.object_of(name, mesh, location=(3.0 * i, 0, 0)) for i, name in enumerate(("One", "Three", "Two"))]


def rounded(stage, name="Round"):
    """A cube with all that could get lost: two modifiers, UVs, a group, a shape key, a property, an object's own material."""
    ob = stage.object_of(name, stage.cube(), stage.diffuse("Meshes"))
    ob.material_slots[0].link = "OBJECT"
    ob.material_slots[0].material = stage.diffuse("Objects")
    ob.data.uv_layers.new(name="Map")
    ob.data["mine"] = 3
    ob.vertex_groups.new(name="Group").add([0], 1.0, "REPLACE")
    ob.shape_key_add(name="Basis")
    ob.modifiers.new("Subdivision", "SUBSURF").levels = 2
    ob.modifiers.new("Hidden", "MIRROR").show_viewport = False
    return ob


def datablocks(bpy):
    return [
        (collection.identifier, sorted(each.name for each in getattr(bpy.data, collection.identifier)))
        for collection in bpy.data.bl_rna.properties
        if collection.type == "COLLECTION" and collection.identifier != "window_managers"
    ]


def test_shared_meshes_become_copies(blender, part, scene, stage, is_baked):
    """The selected ones get their own; who is not baked keeps the unbaked original."""
    one, three, two = twins(stage)
    mesh = one.data
    one.select_set(True)
    two.select_set(True)
    assert blender.ops.prt.bake(mode="SHADOWED", samples=16, make_single_user=True) == {"FINISHED"}
    assert len({one.data, two.data, mesh}) == 3 and three.data == mesh
    assert is_baked(one.data) and is_baked(two.data) and not is_baked(mesh)


def test_the_last_of_shared_meshes_stays(blender, scene, stage, is_baked):
    """If all are baked, no orphan is left; a second bake copies nothing. The scene's setting works, too."""
    objects = twins(stage)
    mesh = objects[0].data
    scene.prt.make_single_user = True
    blender.ops.prt.bake(mode="SHADOWED", samples=16)
    assert [ob.data == mesh for ob in objects] == [False, False, True]
    assert len(blender.data.meshes) == 3 and all(is_baked(ob.data) for ob in objects)
    blender.ops.prt.bake(mode="SHADOWED", samples=16)
    assert len(blender.data.meshes) == 3


def test_modifiers_are_applied_on_a_copy(blender, part, scene, stage, is_baked):
    """The values are those of the subdivided cube, baked where it is seen; all layers and slots come along."""
    ob = rounded(stage)
    assert blender.ops.prt.bake(mode="SHADOWED", samples=64, apply_modifiers=True) == {"FINISHED"}
    assert is_baked(ob.data) and len(ob.data.vertices) == 98
    assert [modifier.name for modifier in ob.modifiers] == ["Hidden"]
    assert "Map" in ob.data.uv_layers and ob.data["mine"] == 3 and "Group" in ob.vertex_groups
    assert ob.data.vertices[0].groups[0].weight > 0
    assert ob.material_slots[0].link == "OBJECT" and ob.material_slots[0].material.name == "Objects"
    transport = part("layers").read(ob.data)
    assert len(transport) == len(ob.data.loops) and transport[:, 0].min() > 0.2, "convex: nothing is shadowed"


def test_applied_modifiers_can_be_had_back(blender, scene, stage, is_baked, tmp_path):
    """A copy of the object, which survives saving, keeps the mesh, its shape keys and the modifiers."""
    ob = rounded(stage)
    original = ob.data.name
    blender.ops.prt.bake(mode="SHADOWED", samples=16, apply_modifiers=True)
    blender.ops.wm.save_as_mainfile(filepath=str(tmp_path / "saved.blend"), copy=True)
    blender.ops.wm.open_mainfile(filepath=str(tmp_path / "saved.blend"))
    kept = blender.data.objects["Round (before PRT)"]
    assert not kept.users_collection and kept.data.name == original
    assert [modifier.name for modifier in kept.modifiers] == ["Subdivision", "Hidden"]
    assert kept.data.shape_keys and not is_baked(kept.data)
    blender.ops.prt.remove()
    assert "prt_light" not in blender.context.scene.world, "what is kept does not count as baked"


def test_shared_mesh_under_modifiers(blender, scene, stage, is_baked):
    """Applying gives a mesh of its own already; the other object's is not shared with what was kept."""
    one, three, two = twins(stage)
    blender.data.objects.remove(three)
    for ob in (one, two):
        ob.modifiers.new("Subdivision", "SUBSURF").levels = 1
    one.select_set(True)
    blender.ops.prt.bake(mode="SHADOWED", samples=16, apply_modifiers=True)
    two.modifiers.clear()
    one.select_set(False)
    two.select_set(True)
    blender.ops.prt.bake(mode="SHADOWED", samples=16)
    assert is_baked(one.data) and is_baked(two.data) and len(one.data.vertices) > len(two.data.vertices)


def test_what_suits_is_not_copied(blender, scene, stage, is_baked):
    """With both settings on, a mesh of one user under modifiers that keep its vertices stays itself."""
    ob = stage.object_of("Grid", stage.grid())
    ob.modifiers.new("Wave", "DISPLACE")
    mesh = ob.data
    blender.ops.prt.bake(mode="SHADOWED", samples=16, make_single_user=True, apply_modifiers=True)
    assert ob.data == mesh and is_baked(mesh) and len(ob.modifiers) == 1 and len(blender.data.meshes) == 1


@pytest.mark.parametrize(("build", "setting"), [(twins, "'Make Single User'"), (rounded, "'Apply Modifiers'")])
def test_refusals_name_the_setting(blender, scene, stage, build, setting):
    """What the person can do about it is one click away."""
    build(stage)
    with pytest.raises(RuntimeError, match=f"turn on {setting}"):
        blender.ops.prt.bake(mode="SHADOWED", samples=16)


def test_particles_are_not_scattered_anew(blender, scene, stage):
    """They live on the mesh that applying replaces: refused by name."""
    ob = rounded(stage)
    ob.modifiers.new("Particles", "PARTICLE_SYSTEM")
    with pytest.raises(RuntimeError, match="'Round' has particles"):
        blender.ops.prt.bake(mode="SHADOWED", samples=16, apply_modifiers=True)


def test_failure_leaves_the_file_as_it_was(blender, part, scene, stage, monkeypatch):
    """The bake breaks off, or the mesh was edited meanwhile: no copy stays, no modifier goes."""
    ob = rounded(stage)
    twins(stage)
    before = datablocks(blender), ob.data.name
    jobs, errors = part("job"), part("errors")

    def cancelled(*_):
        raise errors.Cancelled("Cancelled; nothing was changed.")

    with monkeypatch.context() as patch:
        patch.setattr(jobs.Job, "result", cancelled)
        settings = {"mode": "SHADOWED", "samples": 16, "make_single_user": True, "apply_modifiers": True}
        assert blender.ops.prt.bake(**settings) == {"CANCELLED"}
    assert (datablocks(blender), ob.data.name) == before

    result = jobs.Job.result

    def edited_meanwhile(job):
        ob.modifiers["Subdivision"].levels = 1
        return result(job)

    monkeypatch.setattr(jobs.Job, "result", edited_meanwhile)
    with pytest.raises(RuntimeError, match="'Round' was edited during the bake"):
        blender.ops.prt.bake(**settings)
    assert (datablocks(blender), ob.data.name) == before
    assert len(ob.modifiers) == 2 and np.isclose(len(ob.data.vertices), 8)


def test_prepared_meshes_are_fresh(blender, part, scene, stage):
    """What was read from the evaluated mesh is what the new one shows."""
    one, _, two = twins(stage)
    round_one = rounded(stage)
    blender.ops.prt.bake(mode="SHADOWED", samples=16, make_single_user=True, apply_modifiers=True)
    scene.prt.mode, scene.prt.samples = "SHADOWED", 16
    found = part("freshness").freshness(blender.context, [one, two, round_one])
    assert [each.state for each in found] == ["FRESH"] * 3, [each.text for each in found]
