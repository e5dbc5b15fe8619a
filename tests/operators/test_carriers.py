# SPDX-License-Identifier: GPL-3.0-or-later
"""Carriers hold the transport that a mesh cannot: of modifiers that add vertices, of objects that share a mesh. Nothing is applied."""

import headless
import numpy as np
import pytest

BAKE = {"mode": "SHADOWED", "samples": 64}


@pytest.fixture
def stage(stage_under_sky):
    return stage_under_sky


@pytest.fixture
def carrier(part):
    return part("carrier")


def twins(stage):
    mesh = stage.icosphere(2)
    return [stage.object_of(name, mesh, location=(3.0 * i, 0, 0)) for i, name in enumerate(("One", "Three", "Two"))]


def rounded(stage, name="Round"):
    """A smooth cube with another level of subdivision in renders than in the viewport."""
    ob = stage.object_of(name, stage.cube(), stage.diffuse(name))
    ob.data.shade_smooth()
    modifier = ob.modifiers.new("Subdivision", "SUBSURF")
    modifier.levels = modifier.render_levels = 2
    return ob


def bevelled(stage):
    """Half a cube, hard edged, that modifiers complete."""
    ob = stage.object_of("Bevelled", stage.cube(1.0), stage.diffuse("Bevelled"), location=(1.0, 0, 0))
    for vertex in ob.data.vertices:
        vertex.co.x += 0.5
    ob.modifiers.new("Mirror", "MIRROR")
    ob.modifiers.new("Bevel", "BEVEL").segments = 2
    return ob


def array(stage):
    ob = stage.object_of("Array", stage.icosphere(2), stage.diffuse("Array"))
    ob.modifiers.new("Array", "ARRAY").count = 3
    return ob


def armature(stage):
    """A mesh that a bone moves, subdivided after."""
    import bpy

    ob = rounded(stage, "Bent")
    rig = bpy.data.objects.new("Rig", bpy.data.armatures.new("Rig"))
    bpy.context.scene.collection.objects.link(rig)
    ob.vertex_groups.new(name="Bone").add(range(8), 1.0, "REPLACE")
    modifier = ob.modifiers.new("Armature", "ARMATURE")
    modifier.object = rig
    ob.modifiers.move(1, 0)
    return ob


def shown(bpy, ob, name="_PRT_3"):
    """(elements, 4) of a layer as the viewport evaluates it, and its domain; None if it is not there."""
    evaluated = ob.evaluated_get(bpy.context.evaluated_depsgraph_get())
    layer = evaluated.to_mesh().attributes.get(name)
    if layer is None:
        return None
    values = np.empty(len(layer.data) * 4, dtype=np.float32)
    layer.data.foreach_get("color", values)
    return values.reshape(-1, 4), layer.domain


def stored(carrier, ob, name="_PRT_3"):
    """The same of what was baked."""
    layer = carrier.transport_mesh(ob).attributes[name]
    values = np.empty(len(layer.data) * 4, dtype=np.float32)
    layer.data.foreach_get("color", values)
    return values.reshape(-1, 4), layer.domain


def same(one, other):
    return one is not None and one[1] == other[1] and np.array_equal(one[0], other[0])


def datablocks(bpy):
    return [
        (collection.identifier, sorted(each.name for each in getattr(bpy.data, collection.identifier)))
        for collection in bpy.data.bl_rna.properties
        if collection.type == "COLLECTION" and collection.identifier != "window_managers"
    ]


@pytest.mark.parametrize("build", [rounded, bevelled, array, armature])
def test_modifiers_stay_live(blender, scene, stage, carrier, build):
    """What is shown is, bit for bit, what was baked on the geometry that renders; the stack and the mesh stay."""
    ob = build(stage)
    names, vertices, mesh = [modifier.name for modifier in ob.modifiers], len(ob.data.vertices), ob.data
    assert blender.ops.prt.bake(**BAKE) == {"FINISHED"}
    assert [modifier.name for modifier in ob.modifiers] == [*names, carrier.MODIFIER]
    assert ob.data == mesh and len(mesh.vertices) == vertices and "_PRT_0" not in mesh.attributes
    assert same(shown(blender, ob), stored(carrier, ob))
    assert np.ptp(stored(carrier, ob)[0][:, 0]) > 0.1


def test_values_are_those_of_the_applied_mesh(blender, part, scene, stage, carrier):
    """The same receivers, the same rays."""
    ob = rounded(stage)
    blender.ops.prt.bake(**BAKE)
    live = part("layers").read(carrier.transport_mesh(ob))
    blender.ops.prt.remove()
    with blender.context.temp_override(object=ob, active_object=ob):
        blender.ops.object.modifier_apply(modifier="Subdivision")
    blender.ops.prt.bake(**BAKE)
    assert carrier.carrier_of(ob) is None
    np.testing.assert_array_equal(part("layers").read(ob.data), live)


def test_another_level_in_the_viewport(blender, scene, stage, carrier):
    """The viewport shows the nearest of what renders show: within 1 % where both have vertices."""
    ob = rounded(stage)
    ob.modifiers["Subdivision"].render_levels = 3
    blender.ops.prt.bake(**BAKE)
    here, there = shown(blender, ob), stored(carrier, ob)
    assert len(here[0]) < len(there[0])
    ob.modifiers["Subdivision"].levels = 3
    blender.context.view_layer.update()
    assert same(shown(blender, ob), there)


def test_hard_edges_at_another_level(blender, scene, stage, carrier):
    """On a hard edge every corner takes the light of its own face, not of the one around the corner."""
    ob = stage.object_of("Box", stage.cube(), stage.diffuse("Box"))
    modifier = ob.modifiers.new("Subdivision", "SUBSURF")
    modifier.subdivision_type, modifier.levels, modifier.render_levels = "SIMPLE", 1, 2
    blender.ops.prt.bake(mode="UNSHADOWED")
    evaluated = ob.evaluated_get(blender.context.evaluated_depsgraph_get()).to_mesh()
    normals = np.array([list(corner.vector) for corner in evaluated.corner_normals])
    z = shown(blender, ob, "_PRT_2")[0][:, 0]
    for axis in (-1.0, 0.0, 1.0):
        facing = np.isclose(normals[:, 2], axis)
        np.testing.assert_allclose(z[facing], axis * 2 / 3 * np.sqrt(3 / (4 * np.pi)), atol=2e-3)


def test_shared_meshes_have_light_each(blender, part, scene, stage, carrier):
    """Linked duplicates go on sharing their mesh; the one that is not baked shows nothing of the others."""
    one, three, two = twins(stage)
    mesh = one.data
    one.select_set(True)
    two.select_set(True)
    assert blender.ops.prt.bake(**BAKE) == {"FINISHED"}
    assert one.data == two.data == three.data == mesh and "_PRT_0" not in mesh.attributes
    assert shown(blender, three) is None
    layers = [shown(blender, ob) for ob in (one, two)]
    assert all(same(layer, stored(carrier, ob)) for layer, ob in zip(layers, (one, two), strict=True))
    assert not np.array_equal(layers[0][0], layers[1][0]), "each stands in the shadow of others"
    assert [found.state for found in part("freshness").freshness(blender.context, [one, three, two])][1] == "NEVER"


def test_plain_meshes_hold_it_themselves(blender, scene, stage, carrier):
    """One user, modifiers that keep its vertices: no carrier; a plain bake after a carried one takes that away."""
    ob = stage.object_of("Grid", stage.grid())
    ob.modifiers.new("Wave", "DISPLACE")
    blender.ops.prt.bake(**BAKE)
    assert carrier.carrier_of(ob) is None and "_PRT_0" in ob.data.attributes
    ob.modifiers.new("Subdivision", "SUBSURF")
    blender.ops.prt.bake(**BAKE)
    assert carrier.carrier_of(ob) and "_PRT_0" not in ob.data.attributes
    ob.modifiers.remove(ob.modifiers["Subdivision"])
    blender.ops.prt.bake(**BAKE)
    assert carrier.carrier_of(ob) is None and "_PRT_0" in ob.data.attributes
    assert len(blender.data.objects) == 1 and len(blender.data.meshes) == 1


def test_eevee_shows_it(blender, scene, stage, carrier, tmp_path):
    """The same picture as of the applied mesh, pixel for pixel."""
    ob = rounded(stage)
    stage.top_camera()
    blender.ops.prt.bake(**BAKE)
    live = stage.render(tmp_path / "live.exr")
    blender.ops.prt.remove()
    with blender.context.temp_override(object=ob, active_object=ob):
        blender.ops.object.modifier_apply(modifier="Subdivision")
    blender.ops.prt.bake(**BAKE)
    applied = stage.render(tmp_path / "applied.exr")
    assert applied[..., :3].max() > 0.3
    np.testing.assert_array_equal(live, applied)


def test_it_survives_saving(blender, scene, stage, carrier, tmp_path):
    """Opened again, without a fake user, and in a file that is appended to: nothing more is seen than before."""
    ob = rounded(stage)
    blender.ops.prt.bake(**BAKE)
    before = stored(carrier, ob)
    blender.ops.wm.save_as_mainfile(filepath=str(tmp_path / "saved.blend"), copy=True)
    blender.ops.wm.open_mainfile(filepath=str(tmp_path / "saved.blend"))
    assert same(shown(blender, blender.data.objects["Round"]), before)

    blender.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    blender.ops.wm.append(
        directory=f"{tmp_path / 'saved.blend'}/Object/", filename="Round", autoselect=True, link=False
    )
    appended = blender.data.objects["Round"]
    assert same(shown(blender, appended), before)
    assert [ob.name for ob in blender.context.view_layer.objects] == ["Round"], "the carrier stays out of sight"
    assert not any(carrier.carrier_of(appended).matrix_world.to_scale()), "also where no extension puts it away"


def test_duplicates(blender, part, scene, stage, carrier):
    """A copy of an object shows its light until it gets its own; each bake leaves the other's alone."""
    ob = rounded(stage)
    blender.ops.prt.bake(**BAKE)
    twin = ob.copy()
    twin.data = ob.data.copy()
    scene.collection.objects.link(twin)
    twin.location.x = 3.0
    blender.context.view_layer.update()
    before = stored(carrier, ob)
    assert same(shown(blender, twin), before)
    scene.prt.mode, scene.prt.samples = "SHADOWED", 64
    states = {found.name: found for found in part("freshness").freshness(blender.context, [ob, twin])}
    assert "MOVED" in states[twin.name].causes
    twin.select_set(True)
    blender.ops.prt.bake(**BAKE)
    assert carrier.carrier_of(ob) != carrier.carrier_of(twin)
    assert same(shown(blender, ob), before) and not same(shown(blender, twin), before)


def test_no_orphan_stays(blender, scene, stage, carrier):
    """Baked again, removed, or the object deleted and another baked: what nothing shows is gone."""
    ob, other = rounded(stage), rounded(stage, "Other")
    before = datablocks(blender)
    for _ in range(2):
        blender.ops.prt.bake(**BAKE)
        assert len(blender.data.objects) == 4
    assert blender.ops.prt.remove() == {"FINISHED"}
    assert datablocks(blender) == before and len(ob.modifiers) == len(other.modifiers) == 1
    blender.ops.prt.bake(**BAKE)
    blender.data.objects.remove(other)
    blender.ops.prt.bake(**BAKE)
    assert sorted(one.name for one in blender.data.objects) == ["Round", "Round PRT"]


def test_removing_one_of_two(blender, scene, stage, carrier):
    ob, other = rounded(stage), rounded(stage, "Other")
    blender.ops.prt.bake(**BAKE)
    ob.select_set(True)
    blender.ops.prt.remove()
    assert shown(blender, ob) is None and shown(blender, other) is not None


def test_the_person_applies_all_modifiers(blender, part, scene, stage, carrier):
    """The layers are on the mesh then, and it can be baked again as any other."""
    ob = rounded(stage)
    blender.ops.prt.bake(**BAKE)
    before = stored(carrier, ob)
    ob.select_set(True)
    blender.context.view_layer.objects.active = ob
    blender.ops.object.convert(target="MESH")
    assert not ob.modifiers and same(shown(blender, ob), before) and part("layers").is_baked(ob.data)
    blender.ops.prt.bake(**BAKE)
    assert carrier.carrier_of(ob) is None
    assert not any(carrier.is_carrier(one) for one in blender.data.objects)


def test_joined(blender, scene, stage, carrier):
    """Joining drops the other's modifiers, as Blender does; what is left can be baked."""
    ob, other = rounded(stage), rounded(stage, "Other")
    other.location.x = 3.0
    blender.ops.prt.bake(**BAKE)
    for one in (ob, other):
        one.select_set(True)
    blender.context.view_layer.objects.active = ob
    blender.ops.object.join()
    assert blender.ops.prt.bake(**BAKE) == {"FINISHED"}
    assert same(shown(blender, ob), stored(carrier, ob)) and len(blender.data.objects) == 2


def test_more_modifiers_after_it(blender, scene, stage, carrier):
    """The next bake puts ours last again."""
    ob = rounded(stage)
    blender.ops.prt.bake(**BAKE)
    ob.modifiers.new("Later", "SUBSURF").render_levels = 1
    blender.ops.prt.bake(**BAKE)
    assert [modifier.name for modifier in ob.modifiers] == ["Subdivision", "Later", carrier.MODIFIER]
    assert same(shown(blender, ob), stored(carrier, ob))


def test_objects_that_move(blender, part, scene, stage, carrier):
    """Baked for their own axes, on carriers: shown the same wherever they turn."""
    ob = rounded(stage)
    ob.prt.space = "OBJECT"
    ob.rotation_euler.z = 1.0
    blender.ops.prt.bake(**BAKE)
    assert part("layers").space_of(carrier.transport_mesh(ob)) == "OBJECT"
    alpha = shown(blender, ob, "_PRT_0")[0][:, 3]
    assert (alpha < -1.5).all()


def test_failure_leaves_the_file_as_it_was(blender, part, scene, stage, monkeypatch):
    """The bake breaks off, or the mesh was edited meanwhile: no carrier stays."""
    ob = rounded(stage)
    twins(stage)
    before = datablocks(blender)
    jobs, errors = part("job"), part("errors")

    def cancelled(*_):
        raise errors.Cancelled("Cancelled; nothing was changed.")

    with monkeypatch.context() as patch:
        patch.setattr(jobs.Job, "result", cancelled)
        assert blender.ops.prt.bake(**BAKE) == {"CANCELLED"}
    assert datablocks(blender) == before

    result = jobs.Job.result

    def edited_meanwhile(job):
        ob.data.vertices.add(1)
        return result(job)

    monkeypatch.setattr(jobs.Job, "result", edited_meanwhile)
    with pytest.raises(RuntimeError, match="'Round' was edited during the bake"):
        blender.ops.prt.bake(**BAKE)
    assert datablocks(blender) == before


def test_fresh_and_stale(blender, part, scene, stage):
    """Carried bakes are checked as others are: a change of a modifier is one of geometry."""
    one, _, two = twins(stage)
    round_one = rounded(stage)
    blender.ops.prt.bake(**BAKE)
    scene.prt.mode, scene.prt.samples = "SHADOWED", 64
    freshness = part("freshness").freshness
    found = freshness(blender.context, [one, two, round_one])
    assert [each.state for each in found] == ["FRESH"] * 3, [each.text for each in found]
    round_one.modifiers["Subdivision"].render_levels = 1
    found = freshness(blender.context, [round_one])
    assert "GEOMETRY" in found[0].causes


def test_export_and_report(blender, part, scene, stage, carrier, tmp_path):
    """The course's files hold what renders; the report measures it."""
    ob = rounded(stage)
    blender.ops.prt.bake(**BAKE)
    blender.context.view_layer.objects.active = ob
    assert blender.ops.prt.export_games202(directory=str(tmp_path)) == {"FINISHED"}
    rows = (tmp_path / "transport.txt").read_text().splitlines()
    triangles = 2 * 6 * 16
    assert len(rows) >= triangles * 3
    assert blender.ops.prt.report(parts={"SAMPLING"}, points=64, paths=64, filepath=str(tmp_path / "report.json")) == {
        "FINISHED"
    }


def test_without_the_extension(blender, scene, stage, carrier, tmp_path):
    """The file alone shows it: nodes and meshes of Blender's own."""
    ob = rounded(stage)
    blender.ops.prt.bake(**BAKE)
    before = stored(carrier, ob)
    with headless.extension_disabled():
        ob.location.z = 1.0
        blender.context.view_layer.update()
        assert same(shown(blender, ob), before)
