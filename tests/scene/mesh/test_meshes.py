# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes become receivers: on vertices or corners, with normals right under odd transforms."""

import numpy as np
import pytest


def receivers(part, bpy, ob):
    plan = part("read").read_bake(bpy.context, [ob])
    return plan.objects[0].receivers


def test_smooth_mesh_has_one_receiver_per_vertex(blender, part, scene, stage):
    """Values per vertex where the shading normal is one."""
    found = receivers(part, blender, stage.object_of("Ball", stage.icosphere(3)))
    assert found.domain == "POINT"
    np.testing.assert_allclose(found.group.points, found.group.normals, atol=2e-2)


def test_cube_has_a_receiver_per_vertex_and_face(blender, part, scene, stage):
    """24 receivers, not 8: a cube looks like a cube; and each lies inside its own face."""
    found = receivers(part, blender, stage.object_of("Cube", stage.cube()))
    assert found.domain == "CORNER"
    assert len(found.group) == 24
    height = np.einsum("ij,ij->i", found.group.points, found.group.normals)
    np.testing.assert_allclose(height, 1.0, atol=1e-6)
    assert (np.abs(found.group.points).max(axis=1) <= 1.0 + 1e-6).all()
    assert (np.sort(np.abs(found.group.points), axis=1)[:, 0] < 1.0 - 1e-4).all(), "not on an edge"


@pytest.mark.parametrize("scale", [(1, 2, 0.5), (-1, 1, 1), (-2, -1, -3)])
def test_normals_under_odd_scales_point_outwards(blender, part, scene, stage, scale):
    """Inverse transpose: an ellipsoid's gradient, also when mirrored; and the triangles' fronts follow."""
    ob = stage.object_of("Ball", stage.icosphere(4))
    ob.scale = scale
    blender.context.view_layer.update()
    plan = part("read").read_bake(blender.context, [ob])
    points, normals = plan.objects[0].receivers.group.points, plan.objects[0].receivers.group.normals
    gradient = points / np.square(scale)
    gradient /= np.linalg.norm(gradient, axis=1, keepdims=True)
    assert np.einsum("ij,ij->i", gradient, normals).min() > 0.995
    a, b, c = (plan.scene.occluders.vertices[plan.scene.occluders.triangles[:, k]] for k in range(3))
    assert (np.einsum("ij,ij->i", np.cross(b - a, c - a), a + b + c) > 0).all()


def test_room_corners_leak_no_light(blender, part, scene, stage):
    """A closed box seen from within is black to its corners, where the walls touch the receivers."""
    mesh = stage.cube()
    mesh.flip_normals()
    stage.object_of("Room", mesh)
    stage.environment(stage.picture("Sky", stage.six_coloured_sky(16)))
    blender.ops.prt.bake(mode="SHADOWED", samples=256)
    transport = part("layers").read(mesh)
    assert np.abs(transport).max() < 1e-6


def test_modifiers_that_keep_the_vertices_are_evaluated(blender, part, scene, stage):
    """A displaced grid is baked where it is seen."""
    ob = stage.object_of("Grid", stage.grid())
    wave = ob.modifiers.new("Wave", "DISPLACE")
    wave.strength, wave.mid_level = 2.0, 0.0
    blender.context.view_layer.update()
    assert receivers(part, blender, ob).group.points[:, 2].min() > 1.9


def test_other_objects_cast_shadows(blender, part, scene, stage):
    """Only the selected one is baked; what hides from renders casts none; instances do."""
    ground = stage.object_of("Ground", stage.grid(1, 0.1))
    roof = stage.object_of("Roof", stage.grid(1, 50.0), location=(0, 0, 1))
    stage.environment(stage.picture("Sky", stage.six_coloured_sky(16)))
    read = part("layers").read

    def brightest():
        ground.select_set(True)
        blender.ops.prt.bake(mode="SHADOWED", samples=64, update_light=False, update_shading=False)
        return read(ground.data)[:, 0].max()

    assert brightest() < 0.01
    assert "_PRT_0" not in roof.data.attributes
    roof.hide_render = True
    assert brightest() == pytest.approx(0.2821, abs=1e-4)
    holder = blender.data.collections.new("Holder")
    roof.hide_render = False
    scene.collection.objects.unlink(roof)
    holder.objects.link(roof)
    empty = blender.data.objects.new("Instancer", None)
    empty.instance_type, empty.instance_collection = "COLLECTION", holder
    scene.collection.objects.link(empty)
    assert brightest() < 0.01
