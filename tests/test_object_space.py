# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects baked in their own axes, turned, moved, mirrored or animated, look as if baked again where they stand."""

import numpy as np
import pytest

from tests import bare_blender

# Turn of the object, turn of the world, scale. Scale belongs to the bake, the turns come after it.
PLACES = [
    ((0.9, 0.0, 0.0), (0.0, 0.0, 0.0), (1.0, 1.0, 1.0)),
    ((0.4, -0.9, 2.3), (0.5, -0.4, 1.9), (1.2, 0.7, 0.9)),
    ((-1.7, 0.6, 0.8), (0.0, 1.1, 0.3), (1.0, -1.0, 0.8)),
]


def two_spheres(stage, name="Pair", material=None, location=(0.0, 0.0, 0.0), size=1.0):
    """One mesh of a ball close beside a larger one: it shadows itself, whatever side is seen."""
    import bmesh
    from mathutils import Matrix

    def build(bm):
        bmesh.ops.create_icosphere(bm, subdivisions=3, radius=0.8 * size)
        for centre in ((0.55, 0.35, 0.95), (-0.7, -0.9, 0.2)):
            matrix = Matrix.Translation(np.multiply(centre, size))
            bmesh.ops.create_icosphere(bm, subdivisions=2, radius=0.3 * size, matrix=matrix)

    return stage.object_of(name, stage.from_bmesh(name, build), material or stage.diffuse(), location)


def bake(blender, ob, space, mode="UNSHADOWED", **settings):
    """Bake one object for a space, light and shading as they are set up."""
    ob.prt.space = space
    ob.select_set(True)
    assert blender.ops.prt.bake(mode=mode, **settings) == {"FINISHED"}
    assert ob.data["prt_bake"]["space"] == space
    ob.select_set(False)


def place(blender, ob, turn, scale=(1.0, 1.0, 1.0)):
    ob.rotation_euler, ob.scale = turn, scale
    blender.context.view_layer.update()


def rms(values):
    return np.sqrt(np.mean(np.square(values)))


@pytest.mark.parametrize(
    "where",
    [
        pytest.param(PLACES[0], id="plain"),
        pytest.param(PLACES[1], id="scaled", marks=pytest.mark.slow),
        pytest.param(PLACES[2], id="mirrored", marks=pytest.mark.slow),
    ],
)
def test_turning_equals_baking_again(blender, scene, stage, tmp_path, where):
    """EEVEE's pixels: own axes, turned after the bake, against the world's axes, baked after the turn.

    Unshadowed transport is exact, so that every pixel must agree; shadowed transport agrees but for the noise of two
    independent bakes, and without bias.
    """
    turn, sky_turn, scale = where
    ob = two_spheres(stage)
    stage.top_camera()
    _, mapping = stage.environment(stage.picture("Six", stage.six_coloured_sky()))
    mapping.inputs["Rotation"].default_value = sky_turn
    for mode, samples in (("UNSHADOWED", 1), ("SHADOWED", 1024)):
        place(blender, ob, (0.0, 0.0, 0.0), scale)
        bake(blender, ob, "OBJECT", mode, samples=samples)
        place(blender, ob, turn, scale)
        turned = stage.render(tmp_path / "turned.exr")
        bake(blender, ob, "SCENE", mode, samples=samples)
        again = stage.render(tmp_path / "again.exr")
        seen = again[..., 3] > 0.5
        assert seen.sum() > 600
        error, wanted = (turned - again)[seen][:, :3], again[seen][:, :3]
        if mode == "UNSHADOWED":
            assert np.abs(error).max() / wanted.max() < 3e-3
            open_sky = wanted
        else:
            assert rms(wanted - open_sky) / rms(open_sky) > 0.1, "it shadows itself"
            assert rms(error) / rms(wanted) < 0.013, "sqrt(2) of the noise of 1024 rays, 0.9 %"
            assert np.abs(error.mean(axis=0) / wanted.mean(axis=0)).max() < 2e-3


def test_one_material_serves_both_spaces(blender, part, scene, stage, tmp_path):
    """A turned object of each kind under one material, in one frame: the mesh says which axes it is in."""
    clay = stage.diffuse()
    moving, fixed = (two_spheres(stage, name, clay, (x, 0, 0), 0.6) for name, x in (("Moving", -0.7), ("Fixed", 0.7)))
    stage.top_camera()
    stage.environment(stage.picture("Six", stage.six_coloured_sky()))
    place(blender, fixed, (0.4, -0.9, 2.3))
    moving.prt.space = "OBJECT"
    blender.ops.prt.bake(mode="UNSHADOWED")
    space_of = part("layers").space_of
    assert (space_of(moving.data), space_of(fixed.data)) == ("OBJECT", "SCENE")
    place(blender, moving, (0.4, -0.9, 2.3))
    frame = stage.render(tmp_path / "frame.exr")
    moving.prt.space = "SCENE"
    blender.ops.prt.bake(mode="UNSHADOWED")
    again = stage.render(tmp_path / "again.exr")
    seen = again[..., 3] > 0.5
    assert np.abs(frame - again)[seen].max() / again[seen].max() < 3e-3
    assert moving.data.materials[0] == fixed.data.materials[0]


def test_animated_object_in_a_blender_without_the_extension(blender, scene, stage, tmp_path):
    """Keyframes of turn and place, saved, rendered by a Blender that lacks us: as if baked again in every frame."""
    ob = two_spheres(stage, size=0.8)
    stage.top_camera()
    stage.environment(stage.picture("Six", stage.six_coloured_sky()))
    for number, (turn, location) in enumerate([((1.2, 0.0, 0.4), (0.2, 0, 0)), ((-0.7, 2.0, 1.0), (0, -0.3, 1))], 1):
        ob.rotation_euler, ob.location = turn, location
        ob.keyframe_insert("rotation_euler", frame=number)
        ob.keyframe_insert("location", frame=number)
    wanted = []
    for number in (1, 2):
        scene.frame_set(number)
        bake(blender, ob, "SCENE")
        wanted.append(stage.render(tmp_path / "again.exr"))
    bake(blender, ob, "OBJECT")
    for shown, again in zip(bare_blender.rendered(blender, stage, tmp_path, 2), wanted, strict=True):
        seen = again[..., 3] > 0.5
        assert seen.sum() > 400
        assert np.abs(shown - again)[seen].max() / again[seen].max() < 3e-3


@pytest.mark.parametrize("where", PLACES, ids=["plain", "scaled", "mirrored"])
def test_own_axes_turned_are_the_worlds(blender, part, scene, stage, where):
    """The stored numbers: `T_scene = M(F) T_object` for the object's axes F, a reflection too, in closed form."""
    layers, rotation_matrix = part("layers"), part("rotation").rotation_matrix
    stage.environment(stage.picture("Six", stage.six_coloured_sky(16)))
    ob = two_spheres(stage)
    turn, _, scale = where
    place(blender, ob, turn, scale)
    bake(blender, ob, "OBJECT")
    own = layers.read(ob.data)
    bake(blender, ob, "SCENE")
    columns = np.array(ob.matrix_world)[:3, :3]
    axes = columns / np.linalg.norm(columns, axis=0)
    assert np.linalg.det(axes) == pytest.approx(np.sign(np.prod(scale)))
    wanted = np.einsum("ij,njc->nic", rotation_matrix(axes), own)
    np.testing.assert_allclose(layers.read(ob.data), wanted, atol=2e-5)


@pytest.mark.parametrize("mode", ["SHADOWED", "INTERREFLECTED"])
def test_own_surface_is_all_that_counts(blender, part, scene, stage, mode):
    """Neither company, place nor turn changes an object that moves: the same bits but for rays that graze an edge, and
    for hits that a last bit has moved, which may draw another corner of their triangle to bounce off.
    """
    layers = part("layers")
    stage.environment(stage.picture("Six", stage.six_coloured_sky(16)))
    ob = two_spheres(stage)
    bake(blender, ob, "OBJECT", mode, samples=256)
    alone = layers.read(ob.data)
    stage.object_of("Roof", stage.grid(2, 30.0), stage.diffuse("Red", (1, 0, 0)), (0, 0, 1.5))
    bake(blender, ob, "OBJECT", mode, samples=256)
    assert np.array_equal(layers.read(ob.data), alone)
    ob.location = (3, 1, -2)
    place(blender, ob, (0.4, -0.9, 2.3))
    bake(blender, ob, "OBJECT", mode, samples=256)
    unseen = 1e-3 if mode == "INTERREFLECTED" else 1e-6
    other = (np.abs(layers.read(ob.data) - alone).max(axis=(1, 2)) > unseen).mean()
    assert other < 0.02
    if mode == "INTERREFLECTED":
        assert (alone[:, 0, 0] - alone[:, 0, 2]).max() > 0.01, "its own bounces take on its own colour"


def test_company_is_shadowed_and_all_rays_are_counted(blender, part, scene, stage):
    """Objects of both kinds in one bake: what moves still occludes what stays, not the other way round."""
    layers = part("layers")
    stage.environment(stage.picture("Six", stage.six_coloured_sky(16)))
    ground = stage.object_of("Ground", stage.grid(1, 0.1), stage.diffuse())
    roof = stage.object_of("Roof", stage.grid(1, 50.0), location=(0, 0, 1))
    open_sky = 0.2821
    roof.prt.space = "OBJECT"
    blender.ops.prt.bake(mode="SHADOWED", samples=64)
    assert layers.read(ground.data)[:, 0].max() < 0.01
    assert layers.read(roof.data)[:, 0] == pytest.approx(open_sky, abs=1e-4)
    ground.prt.space = "OBJECT"
    blender.ops.prt.bake(mode="SHADOWED", samples=64)
    assert layers.read(ground.data)[:, 0] == pytest.approx(open_sky, abs=1e-4)
    roof.prt.space = "SCENE"
    settings = part("problem").BakeSettings(samples=64)
    plan = part("read").read_bake(blender.context, [ground, roof], settings)
    job = part("job").bake_job(plan.problem, threads=1)
    job.start()
    assert [len(transport) for transport in job.result().transport] == [4] * 4  # of both sides
    assert job.done == job.work and job.done.rays == 16 * 64


def test_bounces_of_moving_objects_reach_those_that_stay(blender, part, scene, stage):
    """Interreflected: a red wall that moves colours the floor from where it stands, and keeps none of the floor's light."""
    read = part("layers").read
    stage.environment(stage.picture("Six", stage.six_coloured_sky(16)))
    floor = stage.object_of("Floor", stage.grid(4, 1.0), stage.diffuse("White", (1, 1, 1)))
    wall = stage.object_of("Wall", stage.grid(4, 1.0), stage.diffuse("Red", (1, 0, 0)), (-1, 0, 1))
    place(blender, wall, (0, np.pi / 2, 0))
    settings = {"mode": "INTERREFLECTED", "samples": 256, "bounces": 2}
    blender.ops.prt.bake(**settings)
    coloured = read(floor.data)
    assert (coloured[:, 0, 0] - coloured[:, 0, 1]).max() > 0.01
    wall.prt.space = "OBJECT"
    blender.ops.prt.bake(**settings)
    assert np.array_equal(read(floor.data), coloured)
    assert read(wall.data)[:, 0] == pytest.approx(0.2821, abs=1e-4)


def sheared(blender, stage):
    """A turned child of a parent that is scaled along one axis."""
    parent = blender.data.objects.new("Parent", None)
    blender.context.scene.collection.objects.link(parent)
    parent.scale = (3.0, 1.0, 1.0)
    ob = stage.object_of("Skew", stage.cube())
    ob.parent, ob.rotation_euler = parent, (0.0, 0.0, 0.7)


def flat(blender, stage):
    stage.object_of("Skew", stage.cube()).scale = (1.0, 0.0, 1.0)


@pytest.mark.parametrize("build", [sheared, flat])
def test_sheared_objects_are_refused(blender, scene, stage, build):
    """Their axes are at no right angles, and light cannot be turned into them; for the scene they bake as ever."""
    stage.environment(stage.picture("Six", stage.six_coloured_sky(16)))
    build(blender, stage)
    blender.context.view_layer.update()
    ob = blender.data.objects["Skew"]
    ob.prt.space = "OBJECT"
    with pytest.raises(RuntimeError, match="'Skew' is sheared"):
        blender.ops.prt.bake(mode="UNSHADOWED")
    assert "_PRT_0" not in ob.data.attributes
    bake(blender, ob, "SCENE")


@pytest.mark.parametrize("carried", [False, True])
def test_instances_show_their_sources_transport(blender, part, scene, stage, tmp_path, carried):
    """Of a source that is baked for its own axes: a collection instance is lit as the object would be in its place."""
    stage.environment(stage.picture("Sky", stage.six_coloured_sky(64)))
    source = stage.object_of("Source", stage.cube(0.8), stage.diffuse())
    if carried:
        source.modifiers.new("Bevel", "BEVEL").segments = 3
    source.prt.space = "OBJECT"
    blender.ops.prt.bake(mode="SHADOWED", samples=64)
    stage.top_camera()
    turn = (0.5, 0.4, 1.1)
    source.rotation_euler = turn
    wanted = stage.render(tmp_path / "object.exr")
    source.rotation_euler = (0.0, 0.0, 0.0)
    holder = blender.data.collections.new("Holder")
    holder.objects.link(source)
    scene.collection.objects.unlink(source)
    empty = blender.data.objects.new("Instance", None)
    empty.instance_type, empty.instance_collection, empty.rotation_euler = "COLLECTION", holder, turn
    scene.collection.objects.link(empty)
    found = stage.render(tmp_path / "instance.exr")
    assert wanted[..., :3].max() > 0.3
    np.testing.assert_allclose(found, wanted, atol=2e-3)
