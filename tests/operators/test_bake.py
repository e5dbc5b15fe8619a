# SPDX-License-Identifier: GPL-3.0-or-later
"""`bpy.ops.prt.bake` as scripts call it: what it bakes, what it leaves alone, and what of it is kept."""

import numpy as np
import pytest


@pytest.fixture
def stage(stage_under_sky):
    return stage_under_sky


def transport(part, ob):
    return part("layers").read(ob.data)


def test_nothing_selected_bakes_all_that_renders(blender, part, scene, stage):
    """And only that."""
    seen = stage.object_of("Seen", stage.cube())
    hidden = stage.object_of("Hidden", stage.cube(), location=(5, 0, 0))
    hidden.hide_render = True
    assert blender.ops.prt.bake(mode="SHADOWED", samples=16) == {"FINISHED"}
    is_baked = part("layers").is_baked
    assert is_baked(seen.data) and not is_baked(hidden.data)


def test_settings_come_from_the_scene_unless_given(blender, scene, stage):
    """The record says which were used."""
    ob = stage.object_of("Cube", stage.cube())
    scene.prt.mode, scene.prt.samples = "SHADOWED", 8
    blender.ops.prt.bake()
    assert (ob.data["prt_bake"]["mode"], ob.data["prt_bake"]["samples"]) == ("SHADOWED", 8)
    blender.ops.prt.bake(mode="UNSHADOWED")
    assert (ob.data["prt_bake"]["mode"], scene.prt.mode) == ("UNSHADOWED", "SHADOWED")


def test_selection_order_and_company_do_not_matter(blender, part, scene, stage):
    """The same bits alone and together: noise belongs to the object."""
    one = stage.object_of("One", stage.icosphere(3))
    two = stage.object_of("Two", stage.icosphere(3), location=(1.5, 0, 0))
    blender.ops.prt.bake(mode="SHADOWED", samples=32, update_shading=False)
    together = transport(part, two)
    two.select_set(True)
    blender.ops.prt.bake(mode="SHADOWED", samples=32, update_shading=False)
    assert np.array_equal(transport(part, two), together)
    assert one is not None


@pytest.mark.parametrize("mode", ["UNSHADOWED", "SHADOWED", "INTERREFLECTED"])
def test_meshes_without_vertices_take_no_part(blender, part, scene, stage, mode):
    """They stand about in scenes, and Blender gives them not even a layer of positions."""
    cube = stage.object_of("Cube", stage.cube())
    scene.collection.objects.link(blender.data.objects.new("Empty", blender.data.meshes.new("Empty")))
    cube.select_set(True)
    assert blender.ops.prt.bake(mode=mode, samples=4) == {"FINISHED"}
    assert part("layers").is_baked(cube.data) and blender.ops.prt.check() == {"FINISHED"}
    cube.select_set(False)
    assert blender.ops.prt.bake(mode=mode, samples=4) == {"FINISHED"}  # of all that renders show
    scene.objects["Empty"].select_set(True)
    with pytest.raises(RuntimeError, match="'Empty' has no faces"):
        blender.ops.prt.bake(mode=mode, samples=4)


def test_keyframed_light_stays(blender, part, scene, stage):
    """Another bake of a mesh says nothing of the sky; to project the world does."""
    stage.object_of("Cube", stage.cube())
    blender.ops.prt.keyframe_light(frame_start=1, frame_end=2)
    light = part("light")
    for operator, stays in ((blender.ops.prt.bake, True), (blender.ops.prt.project_light, False)):
        operator(**({"mode": "UNSHADOWED"} if stays else {}))
        assert light.has_light(scene.world) and light.is_keyframed(scene.world) == stays
        assert bool(part("animation").channels(scene.world)) == stays


def test_imported_light_stays(blender, part, scene, stage, tmp_path):
    """A bake keeps a light that was read from a file; to project the world replaces it."""
    blender.context.view_layer.objects.active = stage.object_of("Cube", stage.cube())
    blender.ops.prt.bake(mode="UNSHADOWED")
    blender.ops.prt.export_games202(directory=str(tmp_path))
    (tmp_path / "light.txt").write_text("\n".join(["0.25 0.5 0.75"] * 9))
    blender.ops.prt.import_games202(directory=str(tmp_path))
    light = part("light")
    imported = light.read_light(scene.world)
    blender.ops.prt.bake(mode="UNSHADOWED")
    np.testing.assert_array_equal(light.read_light(scene.world), imported)
    blender.ops.prt.project_light()
    assert light.is_projected(scene.world) and not np.allclose(light.read_light(scene.world), imported)


def test_a_world_that_was_swapped_during_the_bake_gives_its_own_light(blender, part, scene, stage):
    """What is written is the light of the world that the scene then has."""
    stage.environment(stage.picture("Sky", stage.six_coloured_sky(16)))
    stage.object_of("Cube", stage.cube())
    settings, whole = part("problem").BakeSettings("UNSHADOWED"), part("whole_bake").WholeBake
    bake = whole(blender.context, settings, part("projection").LightSettings())
    former, scene.world = scene.world, blender.data.worlds.new("Other")
    stage.environment(stage.picture("Other", stage.six_coloured_sky(16)[::-1]))
    bake.write(blender.context, part("bake").bake(bake.plan.problem))
    light, state = part("light"), part("light_state")
    assert not light.has_light(former) and state.light_state(scene.world).text == "Light is fresh"
    baked = light.read_light(scene.world)
    blender.ops.prt.project_light()
    np.testing.assert_array_equal(light.read_light(scene.world), baked)


def test_warnings_are_not_lost_behind_the_last_word(blender, scene, stage, capfd):
    """The status bar shows that one alone, so it counts them, and each kind once however many objects it is about."""
    stage.object_of("Cube", stage.cube()).select_set(True)
    for said in (
        "",
        " 1 warning: see the Info editor.",
        " 2 warnings: see the Info editor.",
        " 2 warnings: see the Info editor.",
    ):
        capfd.readouterr()
        blender.ops.prt.bake(mode="SHADOWED", samples=4)
        [line] = [one for one in capfd.readouterr().out.splitlines() if "Baked" in one]
        assert line.endswith(f"rays.{said}")
        ob = stage.object_of("Hidden", stage.cube(), None, (9, 0, 0))
        ob.hide_render = not said
        ob.scale = (float(not said),) * 3
        ob.select_set(True)


def test_own_layers_survive(blender, part, scene, stage):
    """The user's colour layers, and which of them is active, are left alone."""
    ob = stage.object_of("Cube", stage.cube())
    layer = ob.data.color_attributes.new("Mine", "BYTE_COLOR", "CORNER")
    layer.data.foreach_set("color", np.tile([0.25, 0.5, 0.75, 1.0], len(layer.data)))
    before = np.empty(len(layer.data) * 4, dtype=np.float32)
    layer.data.foreach_get("color", before)
    blender.ops.prt.bake(mode="UNSHADOWED")
    assert ob.data.color_attributes.active_color_name == "Mine"
    assert ob.data.color_attributes.default_color_name == "Mine"
    after = np.empty_like(before)
    ob.data.attributes["Mine"].data.foreach_get("color", after)
    assert np.array_equal(before, after)
    blender.ops.prt.remove()
    assert [a.name for a in ob.data.color_attributes] == ["Mine"]
    assert "prt_bake" not in ob.data


def test_edit_mode_is_kept(blender, part, scene, stage):
    """The mode is the user's."""
    ob = stage.object_of("Cube", stage.cube())
    blender.context.view_layer.objects.active = ob
    ob.select_set(True)
    blender.ops.object.mode_set(mode="EDIT")
    blender.ops.prt.bake(mode="UNSHADOWED")
    assert ob.mode == "EDIT"
    blender.ops.object.mode_set(mode="OBJECT")
    assert part("layers").is_baked(ob.data)


def test_missing_ray_caster_is_said_and_unshadowed_still_works(blender, part, scene, stage, monkeypatch):
    """Never a traceback."""
    ob = stage.object_of("Cube", stage.cube())
    monkeypatch.setattr(part("raycast"), "EmbreeScene", None)
    with pytest.raises(RuntimeError, match="embreex"):
        blender.ops.prt.bake(mode="SHADOWED")
    assert blender.ops.prt.bake(mode="UNSHADOWED") == {"FINISHED"}
    assert part("layers").is_baked(ob.data)


def test_cancel_changes_nothing_and_a_second_bake_is_refused_meanwhile(blender, part, scene, stage):
    """A running job blocks another; cancelled, it raises and leaves no state behind."""
    ob = stage.object_of("Ball", stage.icosphere(5))
    settings, jobs = part("problem").BakeSettings(samples=1 << 14), part("job")
    job = jobs.bake_job(part("read").read_bake(blender.context, [ob], settings).problem)
    job.start()
    assert not blender.ops.prt.bake.poll()
    assert blender.ops.prt.cancel() == {"FINISHED"}
    job.wait(5.0)
    assert not job.running and job.done.rays < job.work.rays
    with pytest.raises(part("errors").Cancelled):
        job.result()
    assert jobs.running_job() is None and blender.ops.prt.bake.poll()
    assert "_PRT_0" not in ob.data.attributes


def test_another_colour_is_baked_from_what_the_engine_keeps(blender, part, scene, stage):
    """Edit a colour or the bounces, bake again in the same process, and get the bits of a full bake in a new one.

    That no ray is cast is shown in `core/bake/test_cache.py`.
    """
    material = stage.diffuse(colour=(0.8, 0.2, 0.2))
    ob = stage.object_of("Ball", stage.icosphere(3), material)
    stage.object_of("Floor", stage.grid(10, 2.0), material, (0, 0, -1))
    blender.ops.prt.bake(mode="INTERREFLECTED", samples=64)
    red = transport(part, ob)
    material.node_tree.nodes["Diffuse BSDF"].inputs["Color"].default_value = (0.2, 0.9, 0.2, 1.0)

    engine = part("session").session.engine.process
    blender.ops.prt.bake(mode="INTERREFLECTED", samples=64, bounces=5)
    assert part("session").session.engine.process == engine
    green = transport(part, ob)
    part("job").end_engine()
    blender.ops.prt.bake(mode="INTERREFLECTED", samples=64, bounces=5)
    assert np.array_equal(transport(part, ob), green)
    assert not np.array_equal(red, green)


def test_a_bake_is_written_whole_or_not_at_all(blender, part, scene, stage, monkeypatch):
    """Whatever breaks while it is written: earlier bakes are there again, bit for bit, on meshes and carriers."""
    stage.environment(stage.picture("Sky", stage.six_coloured_sky(16)))
    plain = stage.object_of("A plain one", stage.icosphere(2), stage.diffuse("A"))
    carried = stage.object_of("B carried", stage.cube(), stage.diffuse("B"), (3, 0, 0))
    carried.modifiers.new("Subdivision", "SUBSURF")
    last = stage.object_of("C last", stage.cube(), stage.diffuse("C"), (6, 0, 0))
    plain.select_set(True)
    carried.select_set(True)
    blender.ops.prt.bake(mode="SHADOWED", samples=16)
    last.select_set(True)
    layers, carrier = part("layers"), part("carrier")

    def state():
        return [
            (
                ob.name,
                carrier.transport_mesh(ob).name,
                repr((record := carrier.transport_mesh(ob).get("prt_bake")) and record.to_dict()),
                layers.is_baked(carrier.transport_mesh(ob)) and layers.read(carrier.transport_mesh(ob)).tobytes(),
                [modifier.name for modifier in ob.modifiers],
            )
            for ob in (plain, carried, last)
        ]

    before, write = state(), layers.write

    def breaks_at_last(mesh, *rest):
        if mesh == last.data:
            mesh.attributes.new("_PRT_0", "FLOAT_COLOR", "POINT")
            raise RuntimeError("broken")
        write(mesh, *rest)

    monkeypatch.setattr(layers, "write", breaks_at_last)
    with pytest.raises(RuntimeError, match="broken"):
        blender.ops.prt.bake(mode="SHADOWED", samples=32)
    assert state() == before and "_PRT_0" not in last.data.attributes
    monkeypatch.undo()
    assert blender.ops.prt.bake(mode="SHADOWED", samples=32) == {"FINISHED"}
    assert all(one != other for one, other in zip(state(), before, strict=True))
    assert len(blender.data.objects) == 4


def test_names_that_are_taken(blender, scene, stage, capfd):
    """A vertex group called like a layer would push it aside: the object is left out, and named."""
    stage.object_of("Good", stage.cube())
    bad = stage.object_of("Bad", stage.cube(), location=(3, 0, 0))
    bad.vertex_groups.new(name="_PRT_2")
    assert blender.ops.prt.bake(mode="SHADOWED", samples=16) == {"FINISHED"}
    assert "'Bad' has a vertex group or UV map '_PRT_2'" in capfd.readouterr().out
    assert not any(name.startswith("_PRT") for name in bad.data.attributes.keys() if name != "_PRT_2")  # noqa: SIM118


def test_a_group_whose_sockets_are_gone_is_built_anew(blender, part, scene, stage):
    """People may edit the node group; the next bake makes it whole, for all materials."""
    stage.environment(stage.picture("Sky", stage.six_coloured_sky(16)))
    stage.object_of("Ball", stage.icosphere(1), stage.diffuse())
    blender.ops.prt.bake(mode="UNSHADOWED")
    whole = {
        "Base Color",
        "Unbaked",
        "Lamps",
        "Surface",
        "Shading",
        "Relit",
        "Sky Seen",
        "Detail X",
        "Detail Y",
        "Detail Z",
    }
    for name in ("Base Color", "Shading"):
        [group] = [tree for tree in blender.data.node_groups if "prt_version" in tree]
        item = next(item for item in group.interface.items_tree if item.name == name)
        group.interface.remove(item)
        assert blender.ops.prt.bake(mode="UNSHADOWED") == {"FINISHED"}
        [group] = [tree for tree in blender.data.node_groups if "prt_version" in tree]
        assert {item.name for item in group.interface.items_tree} == whole
        assert group.users == 1
