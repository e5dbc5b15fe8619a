# SPDX-License-Identifier: GPL-3.0-or-later
"""File > Import > glTF of an exported bake gives the same picture, and broken files do no harm."""

import numpy as np
import pytest

from prt_addon.core.exchange.glb import Glb
from prt_addon.core.layout import BACKS
from tests.web.views import relative_rms


def matte(blender, name, colour):
    """What glTF can hold, without gloss: that mirrors the sky itself, which no coefficients hold."""
    from headless import use_nodes

    material = blender.data.materials.new(name)
    use_nodes(material)
    inputs = material.node_tree.nodes["Principled BSDF"].inputs
    inputs["Base Color"].default_value, inputs["Specular IOR Level"].default_value = (*colour, 1.0), 0.0
    return material


@pytest.fixture
def fill(blender, scene, stage):
    """Fill the scene: a ball on a floor, a turned and scaled box in its own axes and a child of it, under a turned sky; bake."""

    def run(sky, lamps):
        _, mapping = stage.environment(sky, strength=0.7)
        mapping.inputs["Rotation"].default_value = (0.4, -0.3, 2.3)
        stage.object_of("Ball", stage.icosphere(4, 0.6), matte(blender, "Clay", (0.8, 0.5, 0.2)), (-0.4, 0.3, 0.7))
        stage.object_of("Floor", stage.grid(40, 1.5), matte(blender, "Ground", (0.6, 0.7, 0.6)))
        box = stage.object_of("Box", stage.cube(0.6), matte(blender, "Other", (0.3, 0.6, 0.5)), (0.7, -0.6, 0.4))
        box.rotation_euler, box.scale, box.prt.space = (0.4, 0.3, 0.8), (1.0, 0.7, 1.4), "OBJECT"
        blender.ops.prt.bake(mode="INTERREFLECTED", samples=32, lamps=lamps)
        stage.top_camera(scale=2.6)

    return run


@pytest.fixture
def imported(blender, stage):
    """An empty scene with what was imported into it, and the camera as before."""

    def run(path, **options):
        blender.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
        assert blender.ops.import_scene.gltf(filepath=str(path), **options) == {"FINISHED"}
        stage.top_camera(scale=2.6)
        return blender.context.scene

    return run


@pytest.mark.parametrize(
    ("sky", "lamps", "precision"), [("six", "NONE", "FLOAT"), ("six", "NONE", "SHORT"), ("sunny", "ONE", "FLOAT")]
)
def test_the_same_picture(blender, part, scene, stage, fill, imported, tmp_path, sky, lamps, precision):
    """Within a hundredth, turned and scaled as it was, with the shadows of the sky's suns; it goes on turning with the world."""
    picture = (
        stage.picture("Six", stage.six_coloured_sky(64)) if sky == "six" else stage.picture("Sunny", stage.sunny_sky())
    )
    fill(picture, lamps)
    wanted = stage.render(tmp_path / "wanted.exr")
    light = part("light").shown_light(scene.world)
    scene.prt.gltf.precision = precision
    glb = tmp_path / "scene.glb"
    blender.ops.export_scene.gltf(filepath=str(glb))
    found = imported(glb)
    np.testing.assert_allclose(part("light").shown_light(found.world), light, atol=1e-5 * np.abs(light).max())
    shown = stage.render(tmp_path / "shown.exr")
    seen = (wanted[..., 3] > 0.999) & (shown[..., 3] > 0.999)
    assert seen.mean() > 0.8 and relative_rms(shown[seen], wanted[seen]) < 0.01
    suns = [ob for ob in blender.data.objects if ob.type == "LIGHT"]
    assert len(suns) == (lamps == "ONE") and "prt_relight" not in found
    found.world.node_tree.nodes["Mapping"].inputs["Rotation"].default_value[2] += 1.5
    assert relative_rms(stage.render(tmp_path / "turned.exr")[seen], wanted[seen]) > 0.05


def from_below(scene):
    scene.camera.location, scene.camera.rotation_euler = (0.0, 0.0, -10.0), (np.pi, 0.0, 0.0)


@pytest.mark.parametrize("precision", ["FLOAT", "SHORT"])
def test_backs_show_the_same(blender, part, scene, stage, imported, tmp_path, precision):
    """Seen from below within a hundredth: sheets on points, on corners, in their own axes and behind a modifier, beside a closed box.
    The light of their fronts would be far off."""
    stage.environment(stage.picture("Six", stage.six_coloured_sky(64)), strength=0.7)
    places = ((-0.6, -0.6, 0.0), (0.6, -0.6, 0.0), (-0.6, 0.6, 0.0), (0.6, 0.6, 0.0))
    _, corners, own, carried = (
        stage.object_of(f"Sheet {k}", stage.grid(12, 0.5), matte(blender, f"Leaf {k}", (0.8, 0.6, 0.4)), place)
        for k, place in enumerate(places)
    )
    stage.crease(corners.data)
    own.prt.space, own.rotation_euler = "OBJECT", (0.4, 0.3, 0.8)
    modifier = carried.modifiers.new("Finer", "SUBSURF")
    modifier.levels = modifier.render_levels = 1
    stage.object_of("Box", stage.cube(0.3), matte(blender, "Other", (0.3, 0.6, 0.5)), (0.0, 0.0, -0.8))
    blender.ops.prt.bake(mode="INTERREFLECTED", samples=32, lamps="NONE")
    assert part("layers").domain_of(corners.data) == "CORNER"
    stage.top_camera(scale=2.6)
    from_below(scene)
    wanted = stage.render(tmp_path / "wanted.exr")
    scene.prt.gltf.precision = precision
    glb = tmp_path / "scene.glb"
    blender.ops.export_scene.gltf(filepath=str(glb), export_apply=True)
    from_below(imported(glb))
    meshes = {ob.name: ob.data for ob in blender.data.objects if ob.type == "MESH"}
    assert [name for name, mesh in meshes.items() if not part("layers").has_backs(mesh)] == ["Box"]
    shown = stage.render(tmp_path / "shown.exr")
    seen = (wanted[..., 3] > 0.999) & (shown[..., 3] > 0.999)
    found = relative_rms(shown[seen], wanted[seen])
    print(f"{found:.2e} off")
    assert seen.mean() > 0.4 and found < 0.01
    for mesh in meshes.values():
        for name in (name for name in BACKS if name in mesh.attributes):
            mesh.attributes.remove(mesh.attributes[name])
    assert relative_rms(stage.render(tmp_path / "fronts.exr")[seen], wanted[seen]) > 0.2


def test_a_part_of_the_layers_of_backs_is_dropped(blender, part, small, imported, tmp_path):
    """The fronts are imported as ever."""
    glb = Glb(small.read_bytes())
    del glb.document["meshes"][0]["primitives"][0]["attributes"]["_PRT_B1"]
    path = tmp_path / "partly.glb"
    path.write_bytes(glb.written())
    imported(path)
    mesh = blender.data.objects["Ball"].data
    assert "prt_bake" in mesh and not any(name.startswith("_PRT_B") for name in mesh.attributes.keys())  # noqa: SIM118 - a collection of bpy


@pytest.fixture
def small(blender, scene, stage, tmp_path):
    """A ball, baked for both sides, exported in 16 bits."""
    stage.environment(stage.picture("Six", stage.six_coloured_sky(64)))
    stage.object_of("Ball", stage.icosphere(1), matte(blender, "Clay", (0.8, 0.5, 0.2))).prt.sides = "BOTH"
    blender.ops.prt.bake(mode="UNSHADOWED", lamps="NONE")
    scene.prt.gltf.precision = "SHORT"
    path = tmp_path / "ball.glb"
    blender.ops.export_scene.gltf(filepath=str(path))
    return path


def scene_extras(document):
    return document["scenes"][0]["extras"]["prt_relight"]


def primitive_extras(document):
    return document["meshes"][0]["primitives"][0]["extras"]["prt_relight"]


BROKEN = {
    "no object": (lambda document: document["scenes"][0]["extras"].update(prt_relight=7), "its extras are no object"),
    "no version": (lambda document: scene_extras(document).pop("version"), "its extras have no version"),
    "newer": (lambda document: scene_extras(document).update(version=9), "a newer version of PRT Relight exported it"),
    "newer layers": (
        lambda document: scene_extras(document).update(layout=9),
        "a newer version of PRT Relight exported it",
    ),
    "order": (lambda document: scene_extras(document).update(order="3"), "its order is '3', and not 2"),
    "axes": (lambda document: scene_extras(document).update(axes=np.eye(3).tolist()), "export it with +Y Up"),
    "light": (
        lambda document: scene_extras(document).update(light=[[1, 2, 3]]),
        "its 'light' is missing, or not 9 x 3 numbers",
    ),
    "words": (
        lambda document: scene_extras(document).update(strength="bright"),
        "its 'strength' is missing, or not a number",
    ),
    "turn": (
        lambda document: scene_extras(document).update(turn=np.ones((3, 3)).tolist()),
        "its 'turn' is no rotation",
    ),
    "suns": (
        lambda document: scene_extras(document).update(suns=[{"direction": [0, 0, 2]}]),
        "its 'irradiance' is missing",
    ),
    "scales": (
        lambda document: primitive_extras(document).update(scales=[1.0]),
        "the 'scales' of mesh 'Sphere' are missing",
    ),
    "scales of backs": (
        lambda document: primitive_extras(document).pop("backs"),
        "the 'backs' of mesh 'Sphere' are missing, or not 3 pairs of numbers",
    ),
}


@pytest.mark.parametrize("kind", BROKEN)
def test_what_is_broken_is_said_and_imported_without_its_bake(blender, small, imported, tmp_path, capfd, kind):
    """One sentence; the mesh, its material and the world are there as without us."""
    damage, sentence = BROKEN[kind]
    glb = Glb(small.read_bytes())
    damage(glb.document)
    path = tmp_path / "broken.glb"
    path.write_bytes(glb.written())
    capfd.readouterr()
    scene = imported(path)
    said = "".join(capfd.readouterr())
    assert "'broken' is imported without its bake" in said and sentence in said
    ball = blender.data.objects["Ball"]
    assert len(ball.data.vertices) == 12 and ball.data.materials[0].name == "Clay" and "prt_bake" not in ball.data
    assert scene.world is None and not [tree for tree in blender.data.node_groups if "prt_version" in tree]


def test_files_of_others_are_imported_as_ever(blender, small, imported, tmp_path, capfd):
    """Without our extras nothing of ours happens, and nothing is said."""
    glb = Glb(small.read_bytes())
    del glb.document["scenes"][0]["extras"]
    path = tmp_path / "foreign.glb"
    path.write_bytes(glb.written())
    capfd.readouterr()
    scene = imported(path)
    assert "PRT Relight" not in "".join(capfd.readouterr()) and scene.world is None
    assert "prt_bake" not in blender.data.objects["Ball"].data


def test_a_light_that_is_there_stays(blender, part, scene, stage, small, imported, capfd):
    """It lights what is imported, which is said; materials that came are relit."""
    blender.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    stage.environment(stage.picture("White", np.ones((16, 32, 3), dtype=np.float32)))
    blender.ops.prt.project_light()
    world = blender.context.scene.world
    before = part("light").read_light(world)
    capfd.readouterr()
    assert blender.ops.import_scene.gltf(filepath=str(small)) == {"FINISHED"}
    assert "world 'Sky' has a light of its own, which lights what was imported" in "".join(capfd.readouterr())
    np.testing.assert_array_equal(part("light").read_light(world), before)
    ball = blender.data.objects["Ball"]
    assert any(
        "prt_version" in (getattr(node.node_tree, "keys", list)())
        for node in ball.data.materials[0].node_tree.nodes
        if node.type == "GROUP"
    )
    assert part("record").read_record(ball.data).version and part("layers").space_of(ball.data) == "SCENE"


def test_the_world_before_is_kept(blender, small, imported):
    """In the file, whoever uses it; the new one has the file's name."""
    blender.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    scene = blender.context.scene
    scene.world = blender.data.worlds.new("Before")
    blender.ops.import_scene.gltf(filepath=str(small))
    assert scene.world.name == "ball" and blender.data.worlds["Before"].use_fake_user


def test_what_was_imported_is_exported_alike(blender, small, imported, tmp_path):
    """Transport, light, turn and strength, in 16 bits a second time."""
    scene = imported(small)
    scene.prt.gltf.precision = "SHORT"
    again = tmp_path / "again.glb"
    blender.ops.export_scene.gltf(filepath=str(again))
    first, second = (Glb(path.read_bytes()) for path in (small, again))
    for name in ("light", "turn", "strength", "axes"):
        wanted, found = (scene_extras(glb.document)[name] for glb in (first, second))
        np.testing.assert_allclose(found, wanted, atol=2e-5 * np.abs(scene_extras(first.document)["light"]).max())
    for name in ("_PRT_0", "_PRT_8", "_PRT_B0", "_PRT_B2"):
        one, other = (
            glb.values(glb.document["meshes"][0]["primitives"][0]["attributes"][name]).astype(int)
            for glb in (first, second)
        )
        assert {*map(tuple, one)} == {*map(tuple, other)}
