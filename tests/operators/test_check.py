# SPDX-License-Identifier: GPL-3.0-or-later
"""`bpy.ops.prt.check` and `freshness`: what makes which bakes stale, what it says, and what does not matter."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

NOTHING, MOVED, OTHERS, GEOMETRY, COLOURS = set(), {"MOVED"}, {"OTHERS"}, {"GEOMETRY"}, {"COLOURS"}


@pytest.fixture
def stage(scene):
    import stage

    stage.environment(stage.picture("Sky", stage.six_coloured_sky(16)))
    return stage


@pytest.fixture
def three(blender, stage):
    """A textured floor, a red ball and a cube without a material, none selected."""
    floor = stage.object_of("Floor", stage.grid(4, 3.0), stage.diffuse("Tiles"))
    floor.data.uv_layers.new()
    tree = floor.data.materials[0].node_tree
    texture = tree.nodes.new("ShaderNodeTexImage")
    texture.image = stage.picture("Texels", np.random.default_rng(1).random((4, 4, 3)))
    shader = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeBsdfDiffuse")
    tree.links.new(texture.outputs["Color"], shader.inputs["Color"])
    ball = stage.object_of("Ball", stage.icosphere(2), stage.diffuse("Red", (0.8, 0.1, 0.1)), (0, 0, 1.5))
    cube = stage.object_of("Cube", stage.cube(0.5), None, (1.5, 0, 0.5))
    return floor, ball, cube


@pytest.fixture
def bake(blender, scene):
    """Bake all, or some, with the scene's settings."""

    def run(mode, *objects):
        scene.prt.mode, scene.prt.samples = mode, 8
        select(blender, *objects)
        blender.ops.prt.bake()
        select(blender)

    return run


@pytest.fixture
def stale(blender, part):
    """The causes of all stale objects, by name; the others must be fresh."""

    def find():
        blender.context.view_layer.update()
        meshes = [ob for ob in blender.context.scene.objects if ob.type == "MESH"]
        found = part("freshness").freshness(blender.context, meshes)
        assert {one.state for one in found} <= {"FRESH", "STALE"}
        return {one.name: set(one.causes) for one in found if one.state == "STALE"}

    return find


def select(blender, *objects):
    for ob in blender.data.objects:
        ob.select_set(ob in objects)


def shift(ob):
    ob.location.x += 0.1


def turn(ob):
    ob.rotation_euler.z += 0.3


def push_vertex(ob):
    ob.data.vertices[0].co.z += 0.01
    ob.data.update()


def sharpen(ob):
    """Other shading normals, the same surface."""
    ob.data.polygons[0].use_smooth = not ob.data.polygons[0].use_smooth
    ob.data.update()


def bend_normals(ob):
    ob.data.normals_split_custom_set([(0.6, 0.0, 0.8)] * len(ob.data.loops))


def paint(ob):
    """Another colour of its material."""
    nodes = ob.data.materials[0].node_tree.nodes
    next(n for n in nodes if n.bl_idname == "ShaderNodeBsdfDiffuse").inputs["Color"].default_value = (0, 1, 0, 1)


EVERYONE = ("Floor", "Ball", "Cube")
MODES = ("UNSHADOWED", "SHADOWED", "INTERREFLECTED")
CHANGES = [
    # what is done to the ball, and what it does to the ball and to the others, by mode
    (shift, (NOTHING, NOTHING), (MOVED, OTHERS), (MOVED, OTHERS)),
    (turn, (MOVED, NOTHING), (MOVED, OTHERS), (MOVED, OTHERS)),
    (push_vertex, (GEOMETRY, NOTHING), (GEOMETRY, OTHERS), (GEOMETRY, OTHERS)),
    (sharpen, (GEOMETRY, NOTHING), (GEOMETRY, NOTHING), (GEOMETRY, OTHERS)),
    (bend_normals, (GEOMETRY, NOTHING), (GEOMETRY, NOTHING), (GEOMETRY, OTHERS)),
    (paint, (NOTHING, NOTHING), (NOTHING, NOTHING), (COLOURS, COLOURS)),
]


@pytest.mark.parametrize("mode", MODES)
def test_each_cause_is_told_of_those_it_concerns(three, bake, stale, mode):
    """And no other; baking again makes all fresh."""
    for change, *by_mode in CHANGES:
        bake(mode)
        assert stale() == {}
        change(three[1])
        its_own, of_others = by_mode[MODES.index(mode)]
        expected = {"Floor": of_others, "Ball": its_own, "Cube": of_others}
        assert stale() == {name: causes for name, causes in expected.items() if causes}, change.__name__


def test_what_does_not_matter(blender, scene, stage, three, bake, stale):
    """Names, selection, cameras, lights, the sky, materials' names, colour layers that nothing reads."""
    floor, ball, cube = three
    bake("INTERREFLECTED")
    ball.name, ball.data.name, ball.data.materials[0].name = "Aaa", "Bbb", "Ccc"
    select(blender, cube)
    blender.context.view_layer.objects.active = floor
    stage.top_camera().location = (3, 4, 5)
    lamp = blender.data.objects.new("Lamp", blender.data.lights.new("Lamp", "POINT"))
    scene.collection.objects.link(lamp)
    stage.environment(stage.picture("Other sky", np.ones((2, 4, 3))))
    cube.data.color_attributes.new("Unused", "FLOAT_COLOR", "POINT")
    assert stale() == {}


@pytest.mark.parametrize("mode", ["SHADOWED", "INTERREFLECTED"])
def test_newcomers_and_leavers_are_noticed(blender, stage, three, bake, stale, mode):
    """Whatever shades, be it a curve or an instance; what renders do not show does not."""
    bake(mode)
    curve = blender.data.curves.new("Text", "FONT")
    curve.body, curve.extrude = "A", 0.1
    text = stage.object_of("Text", curve)
    assert stale() == dict.fromkeys(EVERYONE, OTHERS)
    text.hide_render = True
    assert stale() == {}
    collection = blender.data.collections.new("Balls")
    collection.objects.link(three[1])
    empty = stage.object_of("Empty", None, location=(0, 3, 0))
    empty.instance_type, empty.instance_collection = "COLLECTION", collection
    assert stale() == dict.fromkeys(EVERYONE, OTHERS)
    blender.data.objects.remove(empty)
    assert stale() == {}
    three[2].hide_render = True
    assert stale() == {"Floor": OTHERS, "Ball": OTHERS, "Cube": {"HIDDEN"}}


def test_subsets_agree_with_the_whole(blender, part, three, bake, stale):
    """Which objects are baked or checked together makes no difference."""
    floor, ball, cube = three
    bake("INTERREFLECTED", cube)
    bake("INTERREFLECTED", ball, floor)
    assert stale() == {}
    shift(cube)
    blender.context.view_layer.update()
    freshness = part("freshness").freshness
    for company in ([ball], [ball, cube], [cube, floor, ball]):
        found = {one.name: set(one.causes) for one in freshness(blender.context, company)}
        assert found["Ball"] == OTHERS
    bake("INTERREFLECTED", ball)
    assert stale() == {"Floor": OTHERS, "Cube": MOVED}


def test_modes_side_by_side(blender, three, bake, stale):
    """Each bake is compared by its own mode, whatever the modes of its neighbours."""
    floor, ball, cube = three
    for mode, ob in (("UNSHADOWED", floor), ("SHADOWED", cube), ("INTERREFLECTED", ball)):
        bake(mode, ob)

    def causes():
        return {name: found - {"SETTINGS"} for name, found in stale().items() if found != {"SETTINGS"}}

    assert causes() == {}
    sharpen(floor)  # the cube sees its shape alone, the ball also what it bounces
    assert causes() == {"Floor": GEOMETRY, "Ball": OTHERS}
    sharpen(floor)
    paint(ball)
    assert causes() == {"Ball": COLOURS}
    shift(floor)
    assert causes() == {"Cube": OTHERS, "Ball": OTHERS}


def test_texels_and_swapped_colours(blender, stage, three, bake, stale):
    """One changed texel counts, and so do two objects that trade their materials, and nodes that Cycles evaluates."""
    _, ball, cube = three
    bake("INTERREFLECTED")
    image = blender.data.images["Texels"]
    pixels = np.array(image.pixels, dtype=np.float32)
    pixels[5] = 1.0 - pixels[5]
    image.pixels.foreach_set(pixels)
    assert stale() == dict.fromkeys(EVERYONE, COLOURS)
    cube.data.materials[0] = stage.diffuse("Green", (0, 1, 0))
    bake("INTERREFLECTED")
    cube.data.materials[0], ball.data.materials[0] = ball.data.materials[0], cube.data.materials[0]
    assert stale() == dict.fromkeys(EVERYONE, COLOURS)
    nodes, links = (getattr(ball.data.materials[0].node_tree, name) for name in ("nodes", "links"))
    noise = nodes.new("ShaderNodeTexNoise")
    links.new(noise.outputs["Color"], next(n for n in nodes if n.bl_idname == "ShaderNodeBsdfDiffuse").inputs["Color"])
    bake("INTERREFLECTED")
    assert stale() == {}
    noise.inputs["Scale"].default_value = 11.0
    assert stale() == dict.fromkeys(EVERYONE, COLOURS)


def test_duplicates_do_not_cancel(blender, stage, bake, stale):
    """Two objects of one shape in one place are two occluders; the second to come or go is noticed."""
    ball = stage.object_of("Ball", stage.icosphere(2))
    bake("SHADOWED")
    twins = [stage.object_of("Twin", stage.cube()) for _ in range(2)]
    bake("SHADOWED")
    assert stale() == {}
    for twin in twins:
        blender.data.objects.remove(twin)
    assert stale() == {ball.name: OTHERS}


def test_settings_that_matter_to_the_mode(blender, scene, part, three, bake):
    """Said with both values; what the mode does not use is not compared."""
    floor, _, _ = three
    glance = part("freshness").glance

    def said():
        [found] = part("freshness").freshness(blender.context, [floor])
        assert glance(blender.context, floor) == found
        return found.text

    bake("SHADOWED", floor)
    scene.prt.bounces, scene.prt.tolerance = 9, 0.5
    assert said() == "fresh"
    scene.prt.samples, scene.prt.seed = 512, 7
    assert said() == "stale: baked with other settings (8 samples, now 512; seed 0, now 7)"
    scene.prt.mode = "UNSHADOWED"
    assert said() == "stale: baked with other settings (shadowed, now unshadowed)"
    bake("UNSHADOWED", floor)
    scene.prt.samples = 99
    assert said() == "fresh"
    bake("INTERREFLECTED", floor)
    scene.prt.bounces = 1
    assert said() == "fresh"
    scene.prt.tolerance = 0.25
    assert said() == "stale: baked with other settings (tolerance 0.5, now 0.25)"
    scene.prt.tolerance = 0.0
    assert said() == "stale: baked with other settings (9 bounces, now 1; tolerance 0.5, now 0)"


@pytest.mark.parametrize("mode", ["SHADOWED", "INTERREFLECTED"])
def test_an_object_baked_for_itself_may_move(blender, three, bake, stale, mode):
    """Turned, mirrored, in other company, it stays fresh; its scale, its geometry and its own colours count."""
    floor, ball, _ = three
    floor.prt.space = "OBJECT"
    bake(mode)
    shift(floor)
    floor.rotation_euler = (1.0, 2.0, 3.0)
    floor.scale = (-1.0, 1.0, 1.0)
    shift(ball)
    assert stale() == {"Ball": MOVED | OTHERS, "Cube": OTHERS}
    floor.scale.y = 1.01
    assert stale()["Floor"] == MOVED
    floor.prt.space = "SCENE"
    assert stale()["Floor"] == MOVED | {"SETTINGS"}


def test_never_baked_removed_and_older_versions(blender, scene, part, three, bake):
    """What cannot be checked says so."""
    floor, ball, cube = three
    bake("SHADOWED", floor, ball)
    record = ball.data["prt_bake"].to_dict()
    del record["fingerprint"], record["elements"]
    ball.data["prt_bake"] = cube.data["prt_bake"] = record | {"version": 1}  # the cube has no layers
    found = part("freshness").freshness(blender.context, three)
    assert [one.state for one in found] == ["FRESH", "UNKNOWN", "NEVER"]
    assert found[1].text == "of unknown origin: bake again to be able to check"


def test_the_drawn_state_follows_at_once_or_with_the_next_check(blender, scene, part, stage, three, bake):
    """Moves and counts are seen without a check; deeper causes as the last check or bake of the session found them."""
    floor, ball, cube = three
    module = part("freshness")

    def drawn(ob):
        blender.context.view_layer.update()
        found = module.glance(blender.context, ob)
        return found.state, set(found.causes)

    assert drawn(floor) == ("NEVER", set())
    bake("SHADOWED")
    assert drawn(floor) == ("FRESH", set())
    part("session").session.checked.clear()  # as in the next session
    assert drawn(floor) == ("UNCHECKED", set())
    assert blender.ops.prt.check() == {"FINISHED"}
    assert drawn(floor) == ("FRESH", set())
    shift(cube)
    assert drawn(cube) == ("STALE", MOVED) and drawn(floor) == ("FRESH", set())
    blender.ops.prt.check()
    assert drawn(floor) == ("STALE", OTHERS)
    cube.location.x -= 0.1
    assert drawn(cube) == ("FRESH", set()) and drawn(floor) == ("STALE", OTHERS)
    shift(cube)
    bake("SHADOWED")
    assert drawn(floor) == ("FRESH", set())
    ball.data.vertices.add(1)
    assert drawn(ball) == ("STALE", GEOMETRY)


def test_reports(blender, part, three, bake, capfd):
    """A line per object and a summary."""
    floor, ball, _ = three
    bake("SHADOWED", floor, ball)
    shift(ball)
    capfd.readouterr()
    assert blender.ops.prt.check() == {"FINISHED"}
    said = capfd.readouterr().out
    assert "'Floor': stale: other objects changed or moved." in said
    assert "'Ball': stale: it was moved." in said
    assert "'Cube': never baked." in said
    assert "3 object(s): 2 stale, 1 never baked." in said
    select(blender, floor)
    blender.ops.prt.check(samples=3)
    assert "(8 samples, now 3).\nInfo: 1 object(s): 1 stale." in capfd.readouterr().out


def test_a_script_may_ask_for_an_error(blender, three, bake):
    """That names what is stale, and nothing else."""
    floor, ball, _ = three
    bake("SHADOWED", floor, ball)
    assert blender.ops.prt.check(fail_if_stale=True) == {"FINISHED"}
    shift(ball)
    blender.context.view_layer.update()
    with pytest.raises(RuntimeError, match="Stale: 'Ball', 'Floor'"):
        blender.ops.prt.check(fail_if_stale=True)
    assert blender.ops.prt.check() == {"FINISHED"}


def test_modifiers_and_edit_mode(blender, three, bake, stale):
    """What is evaluated counts; looking from Edit Mode leaves the person there and finds their edits."""
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
    tools = Path(__file__).parents[2] / "tools"
    run = subprocess.run(
        [sys.executable, tmp_path / "reopen.py", path, tools], check=True, capture_output=True, text=True
    )
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
