# SPDX-License-Identifier: GPL-3.0-or-later
"""Previews of a bake leave no trace in what the end makes of the file, or all is there again if there is no end."""

import importlib
import random
import time
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from tests.recording import recording

SAMPLES = 1024
LONG = 1 << 16


@pytest.fixture
def stage(scene):
    from tests import stage

    return stage


def furnish(stage, mapping=False):
    """One object of each kind that is written in its own way, in a world that nothing turns."""
    import bpy

    stage.environment(stage.picture("Sky", stage.six_coloured_sky(16)), mapping=mapping)
    clay = stage.diffuse("Clay")
    plain = stage.object_of("Plain", stage.icosphere(3), clay)
    layer = plain.data.color_attributes.new("Mine", "BYTE_COLOR", "CORNER")
    plain.data.color_attributes.active_color_name = layer.name
    carried = stage.object_of("Carried", stage.cube(), clay, (3, 0, 0))
    carried.modifiers.new("Subdivision", "SUBSURF").levels = 1
    shared = stage.icosphere(2)
    for number in range(2):
        stage.object_of(f"Twin {number}", shared, location=(0, 3.0 + 3.0 * number, 0))
    stage.object_of("Bare", stage.grid(8, 2.0), location=(0, 0, -1.5))
    no_nodes = bpy.data.materials.new("No nodes")
    no_nodes.diffuse_color = (0.2, 0.6, 0.3, 1.0)
    stage.object_of("Own axes", stage.cube(1.0), no_nodes, (0, -3, 0)).prt.space = "OBJECT"
    return plain, carried


@pytest.fixture
def operators(blender) -> Any:
    """The module of operators that bake."""
    import headless

    return importlib.import_module(f"{headless.PACKAGE}.operators.bake")


@pytest.fixture
def modal(blender, part, operators: Any):
    """Makes what the button starts, driven event by event: without a window Blender sends none. Only reports go elsewhere."""

    class Desk(operators.WholeBakeOperator):
        properties = SimpleNamespace(is_property_set=lambda _name: False)
        update_light = update_shading = True

        def __init__(self, samples):
            self.reports = []
            blender.context.scene.prt.samples = samples

        def report(self, kind, sentence):
            self.reports.append((*kind, sentence))

        def _pieces(self, _context, _key):
            return None

        def _wants_previews(self, _problem):
            return True

        def event(self, kind="TIMER", value="NOTHING"):
            return self.modal(blender.context, SimpleNamespace(type=kind, value=value))

        def until(self, condition):
            while not condition() and self.event() == {"RUNNING_MODAL"}:
                time.sleep(0.005)

        def until_shown(self):
            """Until one of the engine's is shown."""
            self.until(lambda: self._is_shown and self._preview.settings.casts_rays)
            assert part("session").session.before
            return self

        def until_something_is_shown(self):
            self.until(lambda: part("session").session.before)
            return self

        def until_it_ends(self):
            while (state := self.event()) == {"RUNNING_MODAL"}:
                time.sleep(0.005)
            return state

    yield Desk
    part("job").end_engine()
    part("before").take_back()


@pytest.fixture
def shown(part, monkeypatch):
    """The rays per receiver of each preview that is shown; 0 without shadows."""
    whole = part("whole_bake").WholeBake
    seen: list[int] = []
    rays = recording(
        whole.show, seen, of=lambda *arguments: arguments[2].settings.samples * arguments[2].settings.casts_rays
    )
    monkeypatch.setattr(whole, "show", rays)
    return seen


@pytest.mark.parametrize("again", [False, True])
def test_the_end_is_that_of_a_bake_without_previews(blender, stage, modal, shown, again):
    """Bit for bit, names of data-blocks and all; whether something was baked before or not."""
    ends = []
    for samples in (None, SAMPLES):
        blender.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
        furnish(stage)
        blender.context.view_layer.update()
        if again:
            blender.ops.prt.bake(samples=4, seed=7)
        if samples:
            desk = modal(samples)
            assert desk.until_it_ends() == {"FINISHED"}, desk.reports
            assert shown and set(shown) <= {0, 16, 64} and (shown[0] == 0) != again
        else:
            blender.ops.prt.bake(samples=SAMPLES)
        ends.append(stage.file_snapshot())
    assert ends[0] == ends[1]


@pytest.mark.parametrize("again", [False, True])
def test_a_cancel_brings_everything_back(blender, part, stage, modal, again):
    """At twenty moments: before, between and after the previews."""
    plain, carried = furnish(stage)
    if again:
        blender.ops.prt.bake(samples=4, seed=7)
        carried.modifiers["PRT"].show_viewport = False
        carried.modifiers.move(1, 0)
        plain.data.materials.append(stage.diffuse("Another"))
    blender.context.view_layer.update()
    before, moments = stage.file_snapshot(), random.Random(3)
    for number in range(20):
        desk = modal(LONG)
        until = time.monotonic() + moments.uniform(0.0, 0.5)
        if number % 2:
            desk.until_something_is_shown()
        desk.until(lambda until=until: time.monotonic() > until)
        desk.event("ESC", "PRESS")
        assert desk.until_it_ends() == {"CANCELLED"}
        assert desk.reports[-1] == ("WARNING", "Cancelled; nothing was changed.")
        assert stage.file_snapshot() == before and part("session").session.before is None


def glances(blender, part):
    """What the panel says of each mesh."""
    objects = [ob for ob in blender.context.scene.objects if ob.type == "MESH"]
    return [part("freshness").glance(blender.context, ob).text for ob in objects]


def test_a_preview_says_what_it_is(blender, part, stage, modal, capfd, tmp_path):
    """In the status line, the panel and checks, also of a file that was saved meanwhile; then nothing does any more."""
    furnish(stage)
    blender.context.view_layer.update()
    desk = modal(LONG).until_shown()
    desk.until(lambda: desk._job.done.rays)
    text = f"preview, {desk._preview.settings.samples} of {LONG} rays"
    assert f"{text}, " in desk._job.text and desk._job.text.endswith(" left")
    said = f"stale: it is a {text}"
    assert all(text.startswith(said) for text in glances(blender, part))
    saved = str(tmp_path / "meanwhile.blend")
    blender.ops.wm.save_as_mainfile(filepath=saved, copy=True)
    desk.event("ESC", "PRESS")
    desk.until_it_ends()
    assert set(glances(blender, part)) == {"never baked"}

    blender.ops.wm.open_mainfile(filepath=saved)
    assert all(text.startswith(said) for text in glances(blender, part))
    with pytest.raises(RuntimeError, match=r"Stale: .*'Plain'"):
        blender.ops.prt.check(fail_if_stale=True)
    assert f"'Carried': {said}" in capfd.readouterr().out
    blender.ops.prt.bake_shard(directory=str(tmp_path), samples=16)
    assert "6 objects hold previews: bake them, or merge their shards, before they render" in capfd.readouterr().out
    blender.ops.prt.bake(samples=16)
    assert len([ob for ob in blender.data.objects if part("carrier").is_carrier(ob)]) == 3
    assert not any("preview" in text for text in glances(blender, part))


def test_what_takes_no_rays_is_shown_at_once(blender, part, stage, modal):
    """Light without shadows, from before the engine has answered; it can be kept, and says what it is."""
    plain, _ = furnish(stage)
    desk = modal(LONG)
    desk.event()
    desk._looked = -LONG  # a window so slow that all is written at once
    assert desk.event() == {"RUNNING_MODAL"} and desk._is_shown and not desk._preview.settings.casts_rays
    kept = part("layers").read(plain.data)
    assert set(glances(blender, part)) == {"stale: it is a preview, without shadows"}
    assert blender.ops.prt.keep_preview() == {"FINISHED"} and desk.until_it_ends() == {"FINISHED"}
    assert desk.reports[-1] == ("INFO", "Kept the preview of 6 object(s), 816 receivers, without shadows.")
    assert np.array_equal(part("layers").read(plain.data), kept)
    blender.ops.prt.bake(mode="UNSHADOWED")
    assert np.array_equal(part("layers").read(plain.data), kept)


def test_an_earlier_bake_shows_more_than_light_without_shadows(blender, part, stage, modal, shown):
    """It stays until there are rays, beside objects that have none."""
    plain, _ = furnish(stage)
    blender.ops.prt.bake(samples=4, seed=7)
    layers = part("layers").read(plain.data)
    stage.object_of("Another", stage.cube(), location=(6, 0, 0))
    desk = modal(LONG)
    desk.event()
    desk.event()
    assert np.array_equal(part("layers").read(plain.data), layers) and not shown
    desk.until_shown()
    assert shown and 0 not in shown


def test_a_preview_is_written_a_piece_at_a_time(blender, part, stage, operators, modal, monkeypatch):
    """The window redraws between them, however long they take; one that is slow by itself gets all of them at once."""
    stage.environment(stage.picture("Sky", stage.six_coloured_sky(16)))
    objects = [stage.object_of(f"Ball {k}", stage.icosphere(2), stage.diffuse(f"Clay {k}")) for k in range(12)]
    blender.context.view_layer.update()
    whole, is_baked, is_relit = part("whole_bake"), part("layers").is_baked, part("shading").is_relit
    pieces_of = whole.WholeBake._pieces_of
    now = 0.0  # the time that passes: machines differ in how much of this is done in one moment of theirs
    for module in (operators, whole):
        monkeypatch.setattr(module, "time", SimpleNamespace(monotonic=lambda: now))

    def written(redraw, piece):
        """How many objects and materials are after each turn, where redraws and pieces take so many seconds."""

        def taking_time(*arguments):
            nonlocal now
            for _ in pieces_of(*arguments):
                now += piece
                yield

        nonlocal now
        desk, counts = modal(LONG), []
        desk.event()
        with monkeypatch.context() as patch:
            patch.setattr(whole.WholeBake, "_pieces_of", taking_time)
            patch.setattr(desk._job, "step", lambda: None)  # what the engine shows meanwhile would be begun anew
            while not desk._is_shown:
                now += redraw
                assert desk.event() == {"RUNNING_MODAL"}, desk.reports
                counts.append(sum(is_baked(ob.data) + is_relit(ob.active_material) for ob in objects))
        desk.event("ESC", "PRESS")
        assert desk.until_it_ends() == {"CANCELLED"}
        return counts

    moment, quick, slow = operators._MOMENT, 0.5 * operators._LIVE, 2.0 * operators._LIVE
    one_by_one = [*range(25), 24]  # the first piece notes what was there, and after the last there is none
    assert written(quick, 100.0 * moment) == one_by_one
    assert written(quick, 0.4 * moment) == [*one_by_one[2:24:3], 24]
    assert written(slow, 0.4 * moment) == [24]


def test_a_preview_can_be_kept(blender, part, stage, modal):
    """It is written as a bake is, and says what it is; the rest of the rays is not waited for."""
    furnish(stage)
    blender.context.view_layer.update()
    with pytest.raises(RuntimeError, match="No preview is shown"):
        blender.ops.prt.keep_preview()
    desk = modal(LONG).until_shown()
    assert blender.ops.prt.keep_preview() == {"FINISHED"}
    assert desk.until_it_ends() == {"FINISHED"} and part("session").session.before is None
    kind, said = desk.reports[-1]
    assert kind == "INFO" and said.startswith("Kept the preview of 6 object(s), 816 receivers, ")
    assert said.endswith(f" of {LONG} rays.")
    assert all(f"of {LONG} rays" in text for text in glances(blender, part))
    assert part("light").has_light(blender.context.scene.world) and blender.ops.prt.bake.poll()


def test_a_vertex_that_moves_ends_the_bake(blender, part, stage, modal):
    """With a sentence, and what was there before; an object that moves does not, nor does the sky."""
    plain, _ = furnish(stage, mapping=True)
    blender.ops.prt.bake(samples=4, seed=7)
    layers = part("layers").read(plain.data)
    desk = modal(LONG).until_shown()
    assert not np.array_equal(part("layers").read(plain.data), layers)
    plain.location.x += 0.1
    world = blender.context.scene.world
    world.node_tree.nodes["Mapping"].inputs["Rotation"].default_value[2] = 1.0
    blender.context.view_layer.update()
    assert desk.event() == {"RUNNING_MODAL"}
    plain.data.vertices[0].co.z += 0.1
    plain.data.update()
    blender.context.view_layer.update()
    assert desk.event() == {"CANCELLED"} and part("job").running_job() is None
    assert desk.reports[-1] == ("ERROR", "Mesh of 'Plain' was edited during the bake; nothing was changed: bake again.")
    assert np.array_equal(part("layers").read(plain.data), layers)
    assert "preview_of" not in plain.data["prt_bake"]
    assert part("light").read_turn(world)[0, 1] != 0.0


def test_other_vertices_leave_no_place_for_what_was(blender, part, stage, modal):
    """The earlier layers of a mesh that has other elements by now are gone, which is said."""
    plain, _ = furnish(stage)
    blender.ops.prt.bake(samples=4, seed=7)
    desk = modal(LONG).until_shown()
    plain.data.vertices.add(1)
    plain.data.update()
    blender.context.view_layer.update()
    assert desk.event() == {"CANCELLED"}
    assert ("WARNING", f"'{plain.data.name}' was edited: its earlier transport is gone.") in desk.reports
    assert "_PRT_0" not in plain.data.attributes and "prt_bake" not in plain.data


def test_they_are_missed_at_the_end_too(blender, part, stage, modal):
    """Where Blender has reported no edit, as in Edit Mode."""
    plain, _ = furnish(stage)
    blender.ops.prt.bake(samples=4, seed=7)
    desk = modal(LONG).until_shown()
    plain.data.vertices.add(1)
    with pytest.raises(part("errors").MeshError, match=r"'Sphere' was edited .* its earlier transport is gone"):
        desk._bake.write(blender.context, desk._preview.result)
    assert "_PRT_0" not in plain.data.attributes and part("session").session.before is None


def test_edit_mode_is_not_disturbed(blender, part, stage, modal):
    """A preview waits until the user has left it."""
    plain, _ = furnish(stage)
    plain.select_set(True)
    blender.context.view_layer.objects.active = plain
    blender.ops.object.mode_set(mode="EDIT")
    desk = modal(LONG)
    desk.until(lambda: desk._preview)
    assert desk._preview and part("session").session.before is None and plain.mode == "EDIT"
    blender.ops.object.mode_set(mode="OBJECT")
    desk.until_shown()
    assert f"of {LONG} rays" in glances(blender, part)[0]


def test_nothing_else_touches_what_is_baked_meanwhile(blender, stage, modal):
    """What would be taken back with the preview, or written over by the end."""
    furnish(stage)
    modal(LONG).until_shown()
    for name in ("remove", "add_shading", "remove_shading", "import_games202", "freeze", "refine"):
        assert not getattr(blender.ops.prt, name).poll(), name


def test_objects_may_be_renamed_meanwhile(blender, part, stage, modal):
    """That ends the bake, and what was there before comes back under the new name."""
    plain, _ = furnish(stage)
    desk = modal(LONG).until_shown()
    plain.name = "Ball"
    assert desk.until_it_ends() == {"CANCELLED"}
    assert "'Plain' was removed or renamed meanwhile" in desk.reports[-1][1]
    assert "_PRT_0" not in plain.data.attributes


def test_another_file_and_disabling_end_it(blender, part, stage, modal):
    """Of the one nothing is put into the other; without the extension the file is what it was."""
    furnish(stage)
    blender.context.view_layer.update()
    before = stage.file_snapshot()
    desk = modal(LONG).until_shown()
    headless = importlib.import_module("headless")
    with headless.extension_disabled():
        assert stage.file_snapshot() == before and not desk._job.running
    desk = modal(LONG).until_shown()
    blender.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    assert part("session").session.before is None
    desk.cancel(blender.context)
    assert not desk._job.running and not blender.data.meshes


def test_a_world_that_cannot_be_projected_is_white(blender, part, stage, modal):
    """For the previews, too; and it has no light again if nothing comes of them."""
    furnish(stage)
    world = blender.context.scene.world
    blender.data.images.remove(blender.data.images["Sky"])
    blender.context.view_layer.update()
    before = stage.file_snapshot()
    desk = modal(LONG).until_shown()
    assert part("light").stands_in(world)
    desk.event("ESC", "PRESS")
    desk.until_it_ends()
    assert stage.file_snapshot() == before


@pytest.mark.parametrize("wanted", [False, True])
def test_scripts_have_none_unless_they_want_them(blender, part, stage, shown, wanted):
    """Whether they are worth it or not."""
    furnish(stage)
    assert blender.ops.prt.bake(samples=1 << 13, mode="SHADOWED", **({"previews": True} if wanted else {})) == {
        "FINISHED"
    }
    assert bool(shown) == wanted
    assert not any("preview" in text for text in glances(blender, part))
