# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes that are stopped, from the window, by Ctrl-C or by another file, lose nothing and leave nothing."""

import contextlib
import os
import signal
import threading
import time
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

NOT_SOON = 1 << 16  # samples


@pytest.fixture
def stage(stage_under_sky):
    return stage_under_sky


def textured(stage):
    """A material whose colours are looked up for every hit."""
    material = stage.diffuse("Textured")
    tree = material.node_tree
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image = stage.picture("Noise", np.random.default_rng(0).random((64, 64, 3)))
    tree.links.new(node.outputs["Color"], tree.nodes["Diffuse BSDF"].inputs["Color"])
    return material


@pytest.fixture
def large(stage):
    """100,843 receivers with shadows and bounces between them."""
    floor = stage.object_of("Floor", stage.grid(300, 4.0), textured(stage))
    floor.data.uv_layers.new(name="Map")
    return floor, stage.object_of("Ball", stage.icosphere(6), stage.diffuse(), (0, 0, 1.0))


@pytest.fixture
def small(stage):
    return stage.object_of("Ball", stage.icosphere(3), stage.diffuse())


@pytest.fixture
def job_of(blender, part):
    """A job for all that renders, as the button makes it."""

    def make(mode, samples, bounces=3, threads=2):
        part("job").end_engine()
        core, read, choose = part("problem"), part("read"), part("choose")
        settings = core.BakeSettings(mode, samples=samples, bounces=bounces)
        plan = read.read_bake(blender.context, choose.objects_to_bake(blender.context), settings)
        return lambda: part("job").bake_job(plan.problem, threads=threads)

    return make


def snapshot(bpy, stage):
    """All that a bake might change: layers, nodes, properties, data-blocks."""
    materials = {material.name: stage.node_snapshot(material.node_tree) for material in bpy.data.materials}
    blocks = [
        (collection.identifier, sorted(each.name for each in getattr(bpy.data, collection.identifier)))
        for collection in bpy.data.bl_rna.properties
        if collection.type == "COLLECTION" and collection.identifier != "window_managers"
    ]
    objects = [
        (
            ob.name,
            ob.mode,
            ob.select_get(),
            ob.data.name,
            str(ob.data.get("prt_bake") and ob.data["prt_bake"].to_dict()),
        )
        for ob in bpy.context.scene.objects
    ]
    layers = [(mesh.name, sorted(layer.name for layer in mesh.attributes)) for mesh in bpy.data.meshes]
    world = bpy.context.scene.world
    return (
        stage.baked_bytes(bpy.context.scene),
        materials,
        blocks,
        objects,
        layers,
        stage.node_snapshot(world.node_tree),
        sorted(world.keys()),
    )


def engines():
    """The processes of engines that this one has started and that live."""
    lines = []
    for process in Path("/proc").glob("[0-9]*"):
        try:
            parent = int((process / "stat").read_text().rpartition(")")[2].split()[1])
            line = (process / "cmdline").read_bytes()
        except OSError:  # it has ended meanwhile
            continue
        if parent == os.getpid() and b"child.py" in line:
            lines.append(line)
    return lines


def longest_step(job):
    """Run a job to its end, as the button's timer does; the longest that Blender was kept from its work, in seconds."""
    longest = 0.0
    job.start()
    while job.running:
        time.sleep(0.01)
        began = time.perf_counter()
        job.step()
        longest = max(longest, time.perf_counter() - began)
    job.result()
    return longest


def least(measure, limit, tries=6):
    """The least of some measurements: a busy machine makes single ones long, what they are of makes all long."""
    found: list[float] = []
    while len(found) < tries and (not found or min(found) >= limit):
        found.append(measure())
    return min(found)


@pytest.mark.parametrize("mode", ["SHADOWED", "INTERREFLECTED"])
def test_the_window_stays_live(blender, part, large, job_of, mode):
    """No look at the engine takes Blender more than 20 ms while 100,000 receivers are sent, traced, lit and received."""
    make = job_of(mode, 32)

    def measure():
        part("job").end_engine()
        return longest_step(make())

    assert least(measure, 0.02) < 0.02


MOMENTS = {
    "at once": lambda job: True,
    "among the rays": lambda job: job.done.rays > 0.3 * job.work.rays,
    "among the lookups": lambda job: job.done.rays == job.work.rays,
    "among the bounces": lambda job: job.done.bounces > 0,
}


def test_a_cancel_is_quick_and_leaves_nothing(blender, part, stage, large, job_of):
    """Whenever it comes; then it works again."""
    before = snapshot(blender, stage)
    make = job_of("INTERREFLECTED", 64, bounces=100)

    def seconds_to_stop(moment):
        part("job").end_engine()
        job = make()
        job.start()
        while job.running and not moment(job):
            job.wait(0.002)
        assert job.running and blender.ops.prt.cancel() == {"FINISHED"}
        begun = time.perf_counter()
        job.wait()
        stopped = time.perf_counter() - begun
        with pytest.raises(part("errors").Cancelled):
            job.result()
        return stopped

    for name, moment in MOMENTS.items():
        assert least(partial(seconds_to_stop, moment), 0.2) < 0.2, name
    assert snapshot(blender, stage) == before
    assert part("job").running_job() is None
    assert blender.ops.prt.bake(mode="SHADOWED", samples=1) == {"FINISHED"}


def test_progress_counts_bounces_too(part, large, job_of):
    """It rises to the end, says what is done and how long it will take, and ends close to whole."""
    job = job_of("INTERREFLECTED", 96)()
    seen, texts = [], set()
    assert job.text == "preparing the rays"
    job.start()
    while job.running:
        seen.append(job.progress)
        texts.add(job.text)
        job.wait(0.02)
    assert seen == sorted(seen) and seen[-1] <= 1.0
    assert job.done.rays == job.work.rays and job.progress == pytest.approx(1.0, abs=0.01)
    assert any("Mrays/s" in text and "s left" in text for text in texts)
    assert any("bouncing light" in text and not text.startswith("100%") for text in texts)


def test_long_waits_are_told_in_minutes_and_hours(part):
    spoken = part("job").spoken
    said = [spoken(seconds) for seconds in (0.4, 59.7, 120, 200, 3560, 3599, 7312)]
    assert said == ["0 s", "60 s", "120 s", "3 min 20 s", "59 min 20 s", "1 h 0 min", "2 h 2 min"]


@pytest.fixture
def modal(blender, small, job_of):
    """What the button starts, driven event by event: without a window Blender sends none. Only reports go elsewhere."""
    import importlib

    import headless

    operators: Any = importlib.import_module(f"{headless.PACKAGE}.operators.job")

    class Desk(operators.JobOperator):
        def __init__(self):
            self.make, self.reports, self.ended = job_of("SHADOWED", NOT_SOON), [], None

        def report(self, kind, sentence):
            self.reports.append((kind, sentence))

        def _begin(self, _context):
            return self.make()

        def _end(self, _context, result):
            self.ended = result

        def event(self, kind, value="NOTHING"):
            return self.modal(blender.context, SimpleNamespace(type=kind, value=value))

        def until_it_ends(self):
            while (state := self.event("TIMER")) == {"RUNNING_MODAL"}:
                time.sleep(0.01)
            return state

    return Desk()


def test_the_button_reads_works_and_ends(modal, job_of):
    """The first tick of the timer reads the scene, the later ones watch, the last one takes the result."""
    modal.make = job_of("SHADOWED", 256)
    assert modal.event("MOUSEMOVE") == {"PASS_THROUGH"} and modal._job is None
    assert modal.event("TIMER") == {"RUNNING_MODAL"}
    assert modal._job and modal._job.work.rays == 162 * 256
    assert modal.event("MOUSEMOVE") == {"PASS_THROUGH"}
    assert modal.until_it_ends() == {"FINISHED"}
    assert [len(transport) for transport in modal.ended.transport] == [162]


def test_escape_ends_the_button(modal):
    """Soon, with a word, and without a result."""
    assert modal.event("TIMER") == {"RUNNING_MODAL"}
    assert modal.event("ESC", "PRESS") == {"RUNNING_MODAL"}
    assert modal.until_it_ends() == {"CANCELLED"}
    assert modal.reports == [({"WARNING"}, "Cancelled; nothing was changed.")] and modal.ended is None


def test_blender_ends_the_button(blender, modal):
    """Another file is loaded, or the window closes: the job is over when Blender goes on."""
    modal.cancel(blender.context)
    modal.event("TIMER")
    modal.cancel(blender.context)
    assert not modal._job.running


def test_a_second_press_of_the_button_is_refused(modal, job_of):
    """Before the first one has read the scene, Blender cannot know that it runs."""
    other = job_of("SHADOWED", NOT_SOON)()
    other.start()
    assert modal.event("TIMER") == {"CANCELLED"}
    assert modal.reports == [({"ERROR"}, "A bake is running: wait for it, or cancel it.")]
    other.cancel()
    other.wait()


def test_a_second_bake_is_refused(blender, part, stage, small, job_of, tmp_path):
    """By all operators that bake or need the machine, and by a second job, whoever starts it."""
    make = job_of("SHADOWED", NOT_SOON)
    job = make()
    job.start()
    before = snapshot(blender, stage)
    for name in ("bake", "bake_shard", "merge_shards", "report"):
        operator = getattr(blender.ops.prt, name)
        assert not operator.poll()
        with pytest.raises(RuntimeError, match="A bake is running"):
            operator()
    with pytest.raises(part("errors").PRTError, match="A bake is running"):
        make().start()
    assert part("job").running_job() is job
    job.cancel()
    job.wait()
    assert snapshot(blender, stage) == before
    assert blender.ops.prt.bake(mode="SHADOWED", samples=4) == {"FINISHED"}


def test_another_file_ends_the_engine(blender, part, stage, small, job_of):
    """With the job that it works on, and with what it keeps: both are of a file that is gone."""
    job = job_of("SHADOWED", NOT_SOON)()
    job.start()
    job.wait(0.3)
    blender.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    assert not job.running and part("job").running_job() is None and not engines()
    with pytest.raises(part("errors").Cancelled):
        job.result()
    stage.environment(stage.picture("Sky", stage.six_coloured_sky(16)))
    stage.object_of("Cube", stage.cube())
    assert blender.ops.prt.bake(mode="SHADOWED", samples=4) == {"FINISHED"}
    assert len(engines()) == 1


def test_the_extension_may_be_disabled_meanwhile(blender, part, stage, small, job_of):
    """It ends its engine, and can be enabled and used again."""
    import headless

    job = job_of("SHADOWED", NOT_SOON)()
    job.start()
    began = time.perf_counter()
    with headless.extension_disabled():
        assert not job.running and not engines() and time.perf_counter() - began < 5.0
    assert blender.ops.prt.bake(mode="SHADOWED", samples=4) == {"FINISHED"}


def after_the_start(part, *acts):
    """Do things in another thread, a moment apart, once a job has been running for a while; returns how to wait for it."""
    over = threading.Event()

    def act():
        jobs, until = part("job"), time.monotonic() + 60.0
        while not jobs.running_job() and time.monotonic() < until:
            time.sleep(0.01)
        time.sleep(0.5)
        for each in acts:
            each()
            time.sleep(0.02)
        over.set()

    threading.Thread(target=act).start()
    return over.wait


def press_ctrl_c():
    os.kill(os.getpid(), signal.SIGINT)


@pytest.mark.parametrize("presses", [1, 3])
@pytest.mark.parametrize("operator", ["bake", "bake_shard", "report"])
def test_ctrl_c_in_a_script(blender, part, stage, small, tmp_path, operator, presses):
    """The operator fails, so that the script does; nothing changed, and Ctrl-C is again what it was."""
    options: dict[str, dict[str, Any]] = {
        "bake": {},
        "bake_shard": {"directory": str(tmp_path)},
        "report": {"paths": 1 << 14, "points": 4096},
    }
    if operator == "report":
        blender.ops.prt.bake(mode="SHADOWED", samples=16)
    else:
        options[operator] |= {"mode": "SHADOWED", "samples": NOT_SOON}
    before, answer = snapshot(blender, stage), signal.getsignal(signal.SIGINT)
    wait_for_it = after_the_start(part, *[press_ctrl_c] * presses)
    with pytest.raises(RuntimeError, match="Interrupted; nothing was changed"):
        getattr(blender.ops.prt, operator)(**options[operator])
    for _ in range(presses):
        with contextlib.suppress(
            KeyboardInterrupt
        ):  # those that came after the operator's end are for the script itself
            wait_for_it()
    assert snapshot(blender, stage) == before
    assert signal.getsignal(signal.SIGINT) is answer
    assert part("job").running_job() is None


def test_ctrl_c_between_keyframes(blender, stage, small):
    """The light is projected before anything is written: no keyframe, no mark, the scene at its frame."""
    scene = blender.context.scene
    pressed: list[bool] = []

    def press(*_):
        if scene.frame_current == 3 and not pressed:
            pressed.append(True)
            press_ctrl_c()

    before, answer = snapshot(blender, stage), signal.getsignal(signal.SIGINT)
    blender.app.handlers.frame_change_post.append(press)
    try:
        with pytest.raises(RuntimeError, match="Interrupted; nothing was changed"):
            blender.ops.prt.keyframe_light(frame_start=1, frame_end=200)
    finally:
        blender.app.handlers.frame_change_post.remove(press)
    assert pressed and scene.frame_current == 1
    assert snapshot(blender, stage) == before and scene.world.animation_data is None
    assert signal.getsignal(signal.SIGINT) is answer


def test_cancel_of_a_running_operator(blender, part, stage, small):
    """From a script's other thread while this one waits: that is no error."""
    before = snapshot(blender, stage)
    wait_for_it = after_the_start(part, lambda: part("job").running_job().cancel())
    assert blender.ops.prt.bake(mode="SHADOWED", samples=NOT_SOON) == {"CANCELLED"}
    wait_for_it()
    assert snapshot(blender, stage) == before
