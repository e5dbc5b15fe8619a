# SPDX-License-Identifier: GPL-3.0-or-later
"""The interreflected bake is Cycles' light, vertex by vertex, where both light the same scene.

The sky holds nothing beyond order 2, so nine coefficients lose none of it; the surfaces are diffuse; light bounces as
often in both. What is left to differ is an error of the bake, if the meshes are fine enough for light to be linear
across a triangle.
"""

from math import pi

import numpy as np
import pytest

SEGMENTS = 10
BOUNCES = 3
WHITE, RED = (0.8, 0.8, 0.8), (0.8, 0.1, 0.05)


def sheet(stage, name, material, location, turn=(0.0, 0.0, 0.0), unit=1.0):
    """A flat grid of 2 x 2, facing up before its turn: its vertices have one normal, so that transport is per vertex."""
    ob = stage.object_of(name, stage.grid(SEGMENTS), material, [unit * x for x in location])
    ob.rotation_euler, ob.scale = turn, (unit,) * 3
    return ob


def alcove(stage, floor, wall, overhang, unit=1.0):
    """A floor, a wall along its edge and an overhang on the wall, under the sky of six colours. They touch, and share no vertex.

    All show each other their fronts.
    """
    world, _ = stage.environment(stage.picture("Six", stage.six_coloured_sky()))
    world.cycles.sampling_method = "NONE"  # so soft a sky is found by the cosine alone: ten times as fast
    return [
        sheet(stage, "Floor", floor, (0.0, 0.0, 0.0), unit=unit),
        sheet(stage, "Wall", wall, (-1.0, 0.0, 1.0), (0.0, pi / 2, 0.0), unit),
        sheet(stage, "Overhang", overhang, (0.0, 0.0, 2.0), (pi, 0.0, 0.0), unit),
    ]


def select(blender, objects):
    for ob in blender.context.view_layer.objects:
        ob.select_set(ob in objects)
    blender.context.view_layer.objects.active = objects[0]


def our_bake(blender, part, objects, **settings):
    """Transport (vertices, 9, 3) of each object."""
    select(blender, objects)
    blender.ops.prt.bake(update_light=False, update_shading=False, samples=1024, **settings)
    return [part("layers").read(ob.data) for ob in objects]


def our_light(blender, part, objects, **settings):
    """(objects, vertices, 3) what a white receiver shows, by our bake and our light."""
    blender.ops.prt.project_light()
    light = part("light").read_light(blender.context.scene.world)
    return np.einsum("ovic,ic->ovc", our_bake(blender, part, objects, **settings), light)


def cycles_light(blender, objects, samples, seed=0):
    """The same by Cycles: its bake of diffuse light without the receiver's own colour."""
    cycles = blender.context.scene.cycles
    blender.context.scene.render.engine = "CYCLES"
    cycles.samples, cycles.seed = samples, seed
    cycles.max_bounces = cycles.diffuse_bounces = BOUNCES
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    for ob in objects:
        layers = ob.data.color_attributes
        layers.active_color = layers.get("Truth") or layers.new("Truth", "FLOAT_COLOR", "POINT")
    select(blender, objects)
    blender.ops.object.bake(type="DIFFUSE", pass_filter={"DIRECT", "INDIRECT"}, target="VERTEX_COLORS")
    return np.array([[item.color[:3] for item in ob.data.color_attributes["Truth"].data] for ob in objects])


def rms(values, truth):
    """(objects, 3) root mean square of the values, relative to the truth's own, per object and channel."""
    return np.sqrt((values**2).mean(axis=1) / (truth**2).mean(axis=1))


def assert_agrees(blender, part, objects):
    """Ours within 2 % of Cycles' and 1 % of its mean, on each object and channel; returns Cycles'."""
    one, other = (cycles_light(blender, objects, samples=2048, seed=seed) for seed in (0, 1))
    truth = (one + other) / 2.0
    noise = rms((one - other) / 2.0, truth)  # of the mean of two seeds
    assert noise.max() < 0.005, f"the truth is too noisy to judge by: {noise}"
    error = our_light(blender, part, objects, mode="INTERREFLECTED", bounces=BOUNCES) - truth
    bias = error.mean(axis=1) / truth.mean(axis=1)
    print(f"noise\n{noise}\nrms\n{rms(error, truth)}\nbias\n{bias}")  # pytest shows it on failure, or with -s
    assert rms(error, truth).max() < 0.02
    assert np.abs(bias).max() < 0.01
    return truth


def lay_picture(stage, ob, pixels):
    """Put a picture over a sheet by its UV map, its texels sharp, in place of its material's colour."""
    layer = ob.data.uv_layers.new()
    corners = [ob.data.vertices[loop.vertex_index].co for loop in ob.data.loops]
    layer.data.foreach_set("uv", np.array([((co.x + 1.0) / 2.0, (co.y + 1.0) / 2.0) for co in corners]).ravel())
    tree = ob.active_material.node_tree
    texture = tree.nodes.new("ShaderNodeTexImage")
    texture.image, texture.interpolation = stage.picture("Floor", pixels), "Closest"
    return tree.links.new(texture.outputs["Color"], tree.nodes["Diffuse BSDF"].inputs["Color"])


def test_cycles_measures_as_we_do(blender, part, scene, stage):
    """An open plane under a constant sky shows the sky's radiance: both baked numbers have the same unit."""
    world, _ = stage.environment(stage.picture("Constant", np.full((8, 16, 3), (0.25, 0.5, 2.0))))
    world.cycles.sampling_method = "NONE"
    plane = [sheet(stage, "Plane", stage.diffuse(), (0.0, 0.0, 0.0))]
    for light in (cycles_light(blender, plane, samples=4), our_light(blender, part, plane, mode="SHADOWED")):
        np.testing.assert_allclose(light, np.broadcast_to((0.25, 0.5, 2.0), light.shape), rtol=1e-3)


def test_red_wall_over_a_white_floor(blender, part, scene, stage):
    """Shadows and three bounces of coloured light; leaving the bounces out would be noticed."""
    white = stage.diffuse("White", WHITE)
    objects = alcove(stage, white, stage.diffuse("Red", RED), white)
    truth = assert_agrees(blender, part, objects)
    unbounced = our_light(blender, part, objects, mode="SHADOWED")
    assert rms(unbounced - truth, truth).min() > 0.05


def test_the_unit_makes_no_difference(blender, part, scene, stage):
    """Sheets of two millimetres and of two kilometres have the transport of those of two metres, creases too.

    Not by way of Cycles, which is 3 % off itself at two millimetres.
    """
    white, red = stage.diffuse("White", WHITE), stage.diffuse("Red", RED)
    found = []
    for unit in (1.0, 1e-3, 1e3):
        objects = alcove(stage, white, red, white, unit)
        found.append(np.array(our_bake(blender, part, objects, mode="INTERREFLECTED", bounces=BOUNCES)))
        for ob in objects:
            blender.data.objects.remove(ob)
    for other in found[1:]:
        assert np.sqrt(((other - found[0]) ** 2).mean() / (found[0] ** 2).mean()) < 2e-3


@pytest.mark.slow
def test_textured_floor_bleeds_its_colours(blender, part, scene, stage):
    """A floor half green, half blue, under white surfaces; taking the mean of its picture would be noticed."""
    white, floor = stage.diffuse("White", WHITE), stage.diffuse("Floor")
    objects = alcove(stage, floor, white, white)
    halves = np.array([[(0.1, 0.8, 0.1)], [(0.1, 0.1, 0.8)]])
    link = lay_picture(stage, objects[0], halves)
    truth = assert_agrees(blender, part, objects)
    floor.node_tree.links.remove(link)
    floor.node_tree.nodes["Diffuse BSDF"].inputs["Color"].default_value[:3] = halves.mean(axis=(0, 1))
    mean_floor = our_light(blender, part, objects, mode="INTERREFLECTED", bounces=BOUNCES)
    assert rms(mean_floor - truth, truth)[1, 1:].min() > 0.03, "on the wall, in green and blue"


@pytest.mark.slow
def test_what_is_not_selected_bounces_light(blender, part, scene, stage):
    """Baking the floor alone gives it the bits that it gets when all are baked; the others stay as they are."""
    white = stage.diffuse("White", WHITE)
    floor, *others = alcove(stage, white, stage.diffuse("Red", RED), white)
    alone = our_bake(blender, part, [floor], mode="INTERREFLECTED", bounces=BOUNCES)[0]
    assert not any(part("layers").is_baked(ob.data) for ob in others)
    together = our_bake(blender, part, [floor, *others], mode="INTERREFLECTED", bounces=BOUNCES)[0]
    np.testing.assert_array_equal(alone, together)
    assert (np.ptp(alone, axis=2).max(axis=1) > 1e-3).mean() > 0.9, "nearly all of a white floor is tinted by the wall"
