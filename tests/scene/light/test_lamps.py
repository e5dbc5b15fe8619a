# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps take the place of a sky's suns in EEVEE: against Cycles, which sees the sky itself; turned, found again, removed."""

from math import radians

import numpy as np
import pytest

RESOLUTION = 64


@pytest.fixture
def sunny(blender, stage):
    """A ball over a floor in the sun, from aslant; returns the Mapping node."""
    _, mapping = stage.environment(stage.picture("Sunny", stage.sunny_sky()), 0.5)
    white = stage.diffuse("White", (0.8, 0.8, 0.8))
    stage.object_of("Ball", stage.icosphere(4, 0.6), white, (0.0, 0.0, 1.2))
    stage.object_of("Floor", stage.grid(40, 3.0), white)
    stage.top_camera(4.0, RESOLUTION)
    return mapping


@pytest.fixture
def error(blender, stage, tmp_path):
    """Relative RMS of EEVEE's picture, from Cycles'."""

    def measure():
        blender.context.scene.cycles.max_bounces = 6
        truth = stage.render(tmp_path / "truth.exr", "CYCLES", 128)[..., :3]
        shown = stage.render(tmp_path / "shown.exr")[..., :3]
        return np.sqrt(((shown - truth) ** 2).mean() / (truth**2).mean())

    return measure


def suns(blender):
    return [ob for ob in blender.data.objects if ob.type == "LIGHT"]


def bake(blender, **settings):
    assert blender.ops.prt.bake(mode="INTERREFLECTED", bounces=4, samples=256, **settings) == {"FINISHED"}


def test_a_sun_casts_a_sharp_shadow(blender, sunny, error):
    """Less than half the error of nine coefficients; whichever way the sky is turned, and however strong it is."""
    bake(blender, lamps="NONE")
    soft = error()
    assert not suns(blender)
    blender.ops.prt.project_light(lamps="AUTO")
    assert len(suns(blender)) == 1
    assert error() < min(0.4 * soft, 0.07)
    sunny.inputs["Rotation"].default_value = (0.4, -0.3, 2.0)
    background = next(node for node in blender.context.scene.world.node_tree.nodes if node.type == "BACKGROUND")
    background.inputs["Strength"].default_value = 1.5
    assert error() < min(0.4 * soft, 0.07)


@pytest.mark.slow
def test_a_mapping_of_type_texture_turns_the_sun(blender, sunny, error):
    sunny.vector_type, sunny.inputs["Rotation"].default_value = "TEXTURE", (0.4, -0.3, 2.0)
    bake(blender, lamps="ONE")
    assert error() < 0.07


def test_objects_turn_in_the_sun(blender, part, sunny, error):
    """Baked for their own axes, turned after the bake."""
    ball, floor = (blender.data.objects[name] for name in ("Ball", "Floor"))
    ball.prt.space = floor.prt.space = "OBJECT"
    bake(blender, lamps="AUTO")
    ball.rotation_euler = (0.4, 1.0, 0.2)
    ball.location.x = 5.0  # the floor was baked without it
    assert error() < 0.07


def test_unbaked_surfaces_get_no_sun_twice(blender, stage, sunny, tmp_path):
    """EEVEE's own light of the sky holds it."""
    other = stage.object_of("Other", stage.grid(4, 0.4), stage.diffuse("Grey", (0.5, 0.5, 0.5)), (1.0, 1.0, 2.5))
    blender.data.objects["Ball"].select_set(True)
    bake(blender, lamps="NONE")
    before = stage.render(tmp_path / "before.exr")
    blender.ops.prt.project_light(lamps="AUTO")
    after = stage.render(tmp_path / "after.exr")
    points = stage.pixel_points(4.0, RESOLUTION)
    there = (np.abs(points - (1.0, 1.0)) < 0.3).all(axis=-1)
    np.testing.assert_allclose(after[there], before[there], rtol=1e-2)
    assert other.name not in suns(blender)[0].light_linking.receiver_collection.objects


@pytest.fixture
def shiny(blender, stage):
    """Balls of smooth and rough metal and of plastic in the sun, from aslant."""
    stage.environment(stage.picture("Sunny", stage.sunny_sky()), 0.5)
    for x, (metallic, roughness) in enumerate(((1.0, 0.4), (1.0, 0.6), (0.0, 0.4))):
        material = stage.diffuse(f"Ball {x}")
        tree = material.node_tree
        shader = tree.nodes.new("ShaderNodeBsdfPrincipled")
        shader.inputs["Metallic"].default_value, shader.inputs["Roughness"].default_value = metallic, roughness
        tree.links.new(shader.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
        stage.object_of(f"Ball {x}", stage.icosphere(4, 0.5), material, (1.4 * x - 1.4, 0.0, 0.0))
    stage.top_camera(4.0, RESOLUTION)


def test_the_sun_shines_in_gloss(blender, shiny, error):
    """As in Cycles, although EEVEE clamps it in the sky that gloss mirrors: the less is left there, the more lamps add."""
    bake(blender)
    (sun,) = suns(blender)
    assert 0.9 < sun.data.specular_factor < 1.0
    shown = [error()]
    sun.data.driver_remove("specular_factor")
    sun.data.specular_factor = 0.0
    lost = error()
    blender.ops.prt.project_light()
    eevee = blender.context.scene.eevee
    for clamp, share in ((100.0, pytest.approx(1.0 - 100.0 / 150.0, abs=0.04)), (0.0, 0.0)):
        eevee.clamp_surface_indirect = clamp
        blender.context.view_layer.update()
        assert sun.data.specular_factor == share
        shown.append(error())
    assert shown[0] < 0.15 and max(shown) < 0.6 * lost


def test_cycles_does_not_see_the_lamps(blender, stage, sunny, tmp_path):
    before = stage.render(tmp_path / "before.exr", "CYCLES", 16)
    bake(blender, lamps="AUTO")
    after = stage.render(tmp_path / "after.exr", "CYCLES", 16)
    assert abs(after[..., :3].mean() / before[..., :3].mean() - 1.0) < 5e-3


def test_lamps_are_found_again_and_removed(blender, stage, sunny):
    """The next projection uses them again; with the light they go, and nothing of them stays."""
    collections, objects = len(blender.data.collections), len(blender.data.objects)
    bake(blender, lamps="AUTO")
    [sun] = suns(blender)
    blender.ops.prt.project_light(lamps="AUTO")
    assert suns(blender) == [sun]
    blender.ops.prt.project_light(lamps="NONE")
    assert not suns(blender)
    blender.ops.prt.project_light(lamps="AUTO")
    blender.ops.prt.remove()
    assert (len(blender.data.collections), len(blender.data.objects)) == (collections, objects)
    assert not blender.data.lights and "prt_turn_x" not in blender.context.scene.world


def test_another_world_puts_the_lamps_out(blender, stage, sunny):
    """They shine in the scenes of their own world alone."""
    bake(blender, lamps="AUTO")
    scene, other = blender.context.scene, blender.data.scenes.new("Other")
    other.world = scene.world
    blender.ops.prt.project_light(lamps="AUTO")
    assert all(any("prt_lamps_of" in one for one in each.collection.children) for each in (scene, other))
    stage.environment(stage.picture("Soft", stage.six_coloured_sky(32)))
    blender.ops.prt.project_light(lamps="AUTO")
    assert not any("prt_lamps_of" in one for one in scene.collection.children)
    assert any("prt_lamps_of" in one for one in other.collection.children)


def test_lamps_of_a_world_that_was_put_in_its_place(blender, part, stage, sunny):
    """It is followed as the scene's settings say: its sun is taken out, too."""
    bake(blender, lamps="AUTO")
    scene = blender.context.scene
    for lamps, count in (("NONE", 0), ("AUTO", 1)):
        scene.prt.lamps = lamps
        world, _ = stage.environment(stage.picture("Other Sun", stage.sunny_sky()))
        blender.context.view_layer.update()
        assert part("light").has_light(world)
        assert sum("prt_lamps_of" in one for one in scene.collection.children) == count


def test_the_light_says_what_lamps_show(blender, part, stage, sunny):
    """What is stored for them is their share of the light; less it, the sky has no sun."""
    blender.ops.prt.project_light(lamps="ONE")
    light = part("light")
    world = blender.context.scene.world
    left = light.read_light(world) - light.read_lamps(world)
    soft = stage.sunny_sky()
    soft[soft[..., 0] > 10.0] = 0.5
    wanted = part("equirect_projection").project_equirect(soft)
    assert np.abs(left - wanted).max() < 0.12 * wanted[0].max()
    [sun] = suns(blender)
    shown = np.array(sun.data.color) * sun.data.energy / light.strength_of(world)
    direction = np.array(sun.matrix_world.to_3x3())[:, 2]
    np.testing.assert_allclose(direction, stage.SUN, atol=5e-3)
    np.testing.assert_allclose(light.read_lamps(world)[0], shown * part("sh").basis(stage.SUN[None], 0)[0], rtol=2e-3)


def test_the_sun_of_a_sky_texture(blender, sunny, error):
    """Its disc is half a degree wide, and turns by its own Sun Rotation."""
    tree = blender.context.scene.world.node_tree
    sky = tree.nodes.new("ShaderNodeTexSky")
    sky.sky_type = "MULTIPLE_SCATTERING" if blender.app.version >= (5, 0, 0) else "NISHITA"
    sky.sun_disc, sky.sun_elevation, sky.sun_rotation = True, radians(40.0), 0.3
    background = next(node for node in tree.nodes if node.type == "BACKGROUND")
    tree.links.new(sky.outputs[0], background.inputs["Color"])
    background.inputs["Strength"].default_value = 0.02
    bake(blender, lamps="AUTO")
    assert len(suns(blender)) == 1
    assert error() < 0.08
    sky.sun_rotation = 2.0
    assert error() < 0.08


@pytest.mark.parametrize("intensity", [1.0, 0.05, 0.002])
def test_a_faint_sun_disc_is_a_lamp_and_its_glow_is_none(blender, sunny, intensity):
    """EEVEE's own light of such a sky lacks the disc, and nothing else."""
    tree = blender.context.scene.world.node_tree
    sky = tree.nodes.new("ShaderNodeTexSky")
    sky.sky_type = "MULTIPLE_SCATTERING" if blender.app.version >= (5, 0, 0) else "NISHITA"
    sky.sun_disc, sky.sun_elevation, sky.sun_intensity = True, 0.7, intensity
    background = next(node for node in tree.nodes if node.type == "BACKGROUND")
    tree.links.new(sky.outputs[0], background.inputs["Color"])
    blender.ops.prt.project_light(lamps="AUTO")
    [sun] = suns(blender)
    assert np.degrees(sun.data.angle) < 2.0


def test_lamps_are_keyframed_with_the_light(blender, part, sunny, error):
    """A sun that no driver can follow, painted anew for each frame by a keyframed mix of two skies."""
    scene = blender.context.scene
    tree = scene.world.node_tree
    sky = tree.nodes.new("ShaderNodeTexSky")
    sky.sky_type = "MULTIPLE_SCATTERING" if blender.app.version >= (5, 0, 0) else "NISHITA"
    sky.sun_disc, sky.sun_rotation = True, 0.5
    for frame, elevation in ((1, 60.0), (11, 30.0)):
        sky.sun_elevation = radians(elevation)
        sky.keyframe_insert("sun_elevation", frame=frame)
    background = next(node for node in tree.nodes if node.type == "BACKGROUND")
    tree.links.new(sky.outputs[0], background.inputs["Color"])
    background.inputs["Strength"].default_value = 0.02
    bake(blender, lamps="AUTO")
    assert blender.ops.prt.keyframe_light(frame_start=1, frame_end=11, step=5, lamps="ONE") == {"FINISHED"}
    [sun] = suns(blender)
    for frame in (1, 6, 11):
        scene.frame_set(frame)
        height = np.degrees(np.arcsin(np.array(sun.matrix_world)[2, 2]))
        lamps = part("light").read_lamps(scene.world)
        np.testing.assert_allclose(np.linalg.norm(lamps[1:4], axis=0) / lamps[0], np.sqrt(3.0), rtol=1e-3)  # a point's
        assert abs(np.degrees(np.arcsin(lamps[2, 0] / np.linalg.norm(lamps[1:4, 0]))) - height) < 0.5
    assert 29.0 < height < 31.0
    assert error() < 0.1
    blender.ops.prt.remove()
    assert not [action.name for action in blender.data.actions if "PRT" in action.name]


@pytest.fixture
def own_lamps(blender, stage, sunny):
    """Lamps of the user's, called as ours are: one lights the ball alone, one has no shadow of it, one is hidden, one is of a point."""
    scene, data = blender.context.scene, blender.data
    collection = data.collections.new("PRT Lamps")
    scene.collection.children.link(collection)
    found = []
    for number, kind in enumerate(("SUN", "SUN", "SUN", "POINT")):
        light = data.lights.new("PRT Lamp", kind)
        light.energy, light.color, light.specular_factor = 0.5 + number, (1.0, 0.5, 0.25), 0.75
        ob = data.objects.new("PRT Lamp", light)
        ob.location, ob.rotation_euler = (number, 1.0, 3.0), (0.1 * number, 0.2, 0.0)
        collection.objects.link(ob)
        found.append(ob)
    linked = data.collections.new("Linked")
    linked.objects.link(data.objects["Ball"])
    found[0].light_linking.receiver_collection = linked
    found[1].light_linking.blocker_collection = linked
    found[2].hide_render = found[2].visible_glossy = True
    found[2].hide_set(True)
    return found


def state_of_lamps(lamps):
    """All that a user can set of lamps, and where they stand."""

    def settings(block):
        kinds = {"BOOLEAN", "INT", "FLOAT", "STRING", "ENUM"}
        names = {p.identifier for p in block.bl_rna.properties if p.type in kinds} - {
            "use_nodes"
        }  # deprecated since 5.0
        values = {name: getattr(block, name) for name in names}
        return {name: tuple(one) if hasattr(one, "__len__") and name != "name" else one for name, one in values.items()}

    def linking(ob):
        sides = (ob.light_linking.receiver_collection, ob.light_linking.blocker_collection)
        return [side and (side.name, [one.name for one in side.objects]) for side in sides]

    return [
        {
            "object": settings(ob),
            "lamp": settings(ob.data),
            "matrix": [tuple(row) for row in ob.matrix_world],
            "linking": linking(ob),
            "collections": [collection.name for collection in ob.users_collection],
            "hidden": (ob.hide_get(), ob.hide_render),
            "parent": ob.parent,
            "driven": [block.animation_data is not None for block in (ob, ob.data)],
            "properties": [sorted(block.keys()) for block in (ob, ob.data)],
        }
        for ob in lamps
    ]


def test_own_lamps_are_left_alone(blender, part, sunny, own_lamps):
    """Whatever is projected, baked, followed or removed; even those that are called as ours."""
    blender.context.view_layer.update()
    before = state_of_lamps(own_lamps)

    def step(call, count):
        assert call() == {"FINISHED"}
        blender.context.view_layer.update()
        assert state_of_lamps(own_lamps) == before
        assert len(suns(blender)) == len(own_lamps) + count

    ops = blender.ops.prt
    step(lambda: ops.project_light(lamps="AUTO"), 1)
    step(lambda: ops.bake(mode="SHADOWED", samples=8, lamps="AUTO"), 1)
    sunny.inputs["Rotation"].default_value[2] = 1.0
    step(lambda: ops.project_light(lamps="EIGHT"), 1)
    step(lambda: ops.keyframe_light(frame_start=1, frame_end=2), 1)
    step(lambda: ops.project_light(lamps="NONE"), 0)
    step(lambda: ops.project_light(lamps="ONE"), 1)
    step(ops.remove_shading, 1)
    step(ops.remove, 0)
