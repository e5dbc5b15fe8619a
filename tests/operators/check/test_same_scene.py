# SPDX-License-Identifier: GPL-3.0-or-later
"""`freshness` recognises the same scene after modifiers, Edit Mode, undo, another evaluation, and in a reopened file."""

import subprocess
import sys
from pathlib import Path

import numpy as np

from tests.operators.check.changes import GEOMETRY, MOVED, OTHERS, bend_normals, shift


def test_modifiers_and_edit_mode(blender, three, bake, stale):
    """What is evaluated counts; looking from Edit Mode leaves the user there and finds their edits."""
    floor, ball, _ = three
    bake("SHADOWED")
    modifier = ball.modifiers.new("Cast", "CAST")
    assert stale()["Ball"] == GEOMETRY
    modifier.show_render = False
    assert stale() == {}, "what the viewport shows is no matter"
    subdivision = floor.modifiers.new("Subdivision", "SUBSURF")
    assert stale() == {"Floor": GEOMETRY, "Ball": OTHERS, "Cube": OTHERS}
    floor.modifiers.remove(subdivision)
    blender.context.view_layer.objects.active = ball
    blender.ops.object.mode_set(mode="EDIT")
    assert stale() == {}
    blender.ops.mesh.select_all(action="SELECT")
    blender.ops.transform.resize(value=(2, 2, 2))
    assert stale()["Ball"] == GEOMETRY
    assert ball.mode == "EDIT"
    blender.ops.object.mode_set(mode="OBJECT")


def test_undo_and_redo(blender, three, bake, stale):
    """A bake that is back is fresh again."""
    bake("INTERREFLECTED")
    blender.ops.ed.undo_push(message="Baked")
    shift(three[1])
    blender.context.view_layer.update()
    blender.ops.ed.undo_push(message="Moved")
    assert stale()["Ball"] == MOVED
    blender.ops.ed.undo()
    assert stale() == {}
    blender.ops.ed.redo()
    assert stale()["Ball"] == MOVED


REOPEN = """
import sys
sys.path[:0] = sys.argv[2:]
import headless
headless.enable_extension()
import bpy, importlib
bpy.ops.wm.open_mainfile(filepath=sys.argv[1])
freshness = importlib.import_module(headless.PACKAGE + ".prt_addon.scene.bake.freshness").freshness
for one in freshness(bpy.context, [ob for ob in bpy.data.objects if ob.type == "MESH"]):
    print("CHECKED", one.name, one.text)
headless.disable_extension()
"""


def test_a_saved_file_stays_fresh(blender, three, bake, stale, tmp_path):
    """Reopened here and in another process, where neither hash seeds nor addresses are the same."""
    _, ball, cube = three
    ball.rotation_euler = (0.2, 3.5, 1.3)
    ball.parent = cube
    blender.context.view_layer.update()
    bend_normals(cube)
    bake("INTERREFLECTED")
    path = str(tmp_path / "saved.blend")
    for _ in range(2):
        blender.ops.wm.save_as_mainfile(filepath=path)
        blender.ops.wm.open_mainfile(filepath=path)
        assert stale() == {}
    (tmp_path / "reopen.py").write_text(REOPEN)
    tools = Path(__file__).parents[3] / "tools"
    command = [sys.executable, tmp_path / "reopen.py", path, tools]
    # It never ends where something keeps a class of the extension alive: then Blender cannot free its own.
    run = subprocess.run(command, check=True, capture_output=True, text=True, timeout=300)
    said = [line for line in run.stdout.splitlines() if line.startswith("CHECKED")]
    assert said == ["CHECKED Ball fresh", "CHECKED Cube fresh", "CHECKED Floor fresh"]


def test_made_meshes_are_known_by_what_makes_them(blender, part, scene, stage, three, bake, stale, monkeypatch):
    """Other last bits at another evaluation make nothing stale; the original, settings and other objects do."""
    cube = three[2]
    cube.modifiers.new("Bevel", "BEVEL").segments = 3
    cube.modifiers.new("Subdivision", "SUBSURF").render_levels = 2
    bake("SHADOWED")
    assert stale() == {}
    derived = part("derived")
    exact = derived.layer_array

    def shaken(mesh, layer, *rest):
        values = exact(mesh, layer, *rest)
        noise = np.random.default_rng().uniform(-5e-7, 5e-7, values.shape).astype(np.float32)
        return values + noise if mesh.name != cube.data.name or mesh.is_evaluated else values

    monkeypatch.setattr(derived, "layer_array", shaken)
    for _ in range(3):
        assert stale() == {}
    monkeypatch.undo()
    cube.modifiers["Bevel"].width *= 1.1
    assert stale() == {"Floor": OTHERS, "Ball": OTHERS, "Cube": GEOMETRY}
    cube.modifiers["Bevel"].width /= 1.1
    cube.modifiers["Bevel"].show_expanded = False
    assert stale() == {}
    cube.data.vertices[0].co.x += 1e-3
    assert stale()["Cube"] == GEOMETRY
    cube.data.vertices[0].co.x -= 1e-3
    hook = blender.data.objects.new("Hook", None)
    scene.collection.objects.link(hook)
    modifier = cube.modifiers.new("Hook", "HOOK")
    modifier.object = hook
    modifier.vertex_indices_set([0, 1])
    cube.modifiers.move(2, 0)
    bake("SHADOWED")
    assert stale() == {}
    hook.location.x = 0.05
    assert stale()["Cube"] == GEOMETRY
