# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes as artists really have them get sane transport, or a sentence that says what is lost."""

import math
import re

import numpy as np
import pytest

OPEN = 0.5 / math.sqrt(math.pi)
SAMPLES = 64


@pytest.fixture
def bake(blender, part, scene):
    """Bakes some objects, and reads (N, 9) of the first: per vertex, or per face corner."""

    def run(ob, *others, mode="SHADOWED", samples=SAMPLES, **options):
        for each in (ob, *others):
            each.select_set(True)
        options = {"update_light": False, "update_shading": False} | options
        assert blender.ops.prt.bake(mode=mode, samples=samples, **options) == {"FINISHED"}
        transport = part("layers").read(ob.data)[..., 0]
        assert np.isfinite(transport).all()
        assert (transport[:, 0] > -1e-6).all() and (transport[:, 0] < OPEN * (1 + 1e-5)).all()
        return transport

    return run


def mesh_of(stage, name, build, smooth=True):
    return stage.object_of(name, stage.from_bmesh(name, build, smooth))


def uv_sphere(segments, rings=None, **options):
    import bmesh

    return lambda bm: bmesh.ops.create_uvsphere(
        bm, u_segments=segments, v_segments=rings or segments // 2, radius=1.0, **options
    )


def vertices_of(ob):
    return np.array([vertex.co[:] for vertex in ob.data.vertices])


def printed(capfd):
    """What operators reported: they print it where there is no window."""
    return capfd.readouterr().out


def test_low_poly_sphere_has_no_terminator_acne(bake, stage):
    """Nothing shadows a convex mesh: shadowed is unshadowed, but for the noise of projecting."""
    for segments in (8, 12, 16):
        ob = mesh_of(stage, f"Ball {segments}", uv_sphere(segments))
        shadowed, closed_form = bake(ob), bake(ob, mode="UNSHADOWED")
        np.testing.assert_allclose(shadowed, closed_form, rtol=0, atol=1e-5)
        ob.hide_render = True
        ob.select_set(False)


@pytest.mark.parametrize("sharp", [False, True])
def test_low_poly_sphere_above_a_floor_is_not_dark_on_top(bake, blender, stage, sharp):
    """Nor anywhere too dark or too bright, also where sharp edges send it to face corners."""
    ball = mesh_of(stage, "Ball", uv_sphere(8))
    ball.location.z = 1.5
    if sharp:
        ball.data.edges.foreach_set("use_edge_sharp", np.arange(len(ball.data.edges)) % 3 == 0)
    stage.object_of("Floor", stage.grid(1, 200.0))
    blender.context.view_layer.update()
    shadowed, closed_form = bake(ball, samples=512), bake(ball, mode="UNSHADOWED")
    normal_z = closed_form[:, 2] / (2 / 3 * math.sqrt(3 / (4 * math.pi)))
    assert (np.ptp(normal_z) > 1.8) and (len(shadowed) > len(ball.data.vertices)) == sharp
    # A tilted receiver above an endless floor sees (1 + cos) / 2 of the sky.
    np.testing.assert_allclose(shadowed[:, 0], OPEN * (1 + normal_z) / 2, rtol=0, atol=5e-3)


def slab(bm):
    """A thick floor with vertices all over its top, z = 0."""
    import bmesh

    bmesh.ops.create_grid(bm, x_segments=40, y_segments=40, size=2.0)
    made = bmesh.ops.extrude_face_region(bm, geom=bm.faces[:], use_keep_orig=True)["geom"]
    bmesh.ops.translate(bm, vec=(0, 0, -2.0), verts=[item for item in made if isinstance(item, bmesh.types.BMVert)])
    bmesh.ops.recalc_face_normals(bm, faces=bm.faces)


@pytest.mark.parametrize("mode", ["SHADOWED", "INTERREFLECTED"])
def test_ball_sunk_into_a_floor_has_no_black_ring(bake, stage, capfd, mode):
    """Both meshes are filled where they lie inside the other, and it is said."""
    ball = mesh_of(stage, "Ball", uv_sphere(48))
    floor = mesh_of(stage, "Floor", slab)
    transport, height = bake(ball, floor, mode=mode), vertices_of(ball)[:, 2]
    assert transport[np.abs(height) < 0.3, 0].min() > 0.35 * OPEN  # the floor hides half of the sky there
    assert transport[height < -0.3, 0].min() > 0.35 * OPEN
    said = printed(capfd)
    assert "2 objects have receivers inside other geometry, which take the light of open parts" in said
    assert "'Ball', 'Floor'" in said


def test_a_wholly_buried_object_is_black_and_said(bake, stage, capfd):
    """There is nothing to fill it from."""
    ball = mesh_of(stage, "Ball", uv_sphere(16))
    shell = mesh_of(stage, "Shell", uv_sphere(16))
    shell.scale = 3, 3, 3
    assert bake(ball, shell)[:, 0].max() == 0.0
    said = printed(capfd)
    assert "No light reaches 'Ball'" in said
    assert "open parts" not in said


def test_faces_turned_inside_out_are_black_and_said(bake, stage, capfd):
    """As any renderer of one-sided faces has it; and what to do about it. (Smooth and seen from within, the coarser a
    mesh is the more light slips behind its faces, along the vertices' tangent planes: at 32 segments, 2 %.)"""
    ball = mesh_of(stage, "Ball", uv_sphere(32))
    ball.data.flip_normals()
    assert bake(ball)[:, 0].max() < 0.05 * OPEN
    assert "No light reaches 'Ball'" in printed(capfd)


def test_one_turned_face_leaves_the_others_alone(bake, blender, stage):
    """A cube with one face turned inwards: five faces open, one black."""
    cube = stage.object_of("Cube", stage.cube())
    import bmesh

    bm = bmesh.new()
    bm.from_mesh(cube.data)
    bm.faces.ensure_lookup_table()
    bmesh.ops.reverse_faces(bm, faces=[bm.faces[2]])
    bm.to_mesh(cube.data)
    bm.free()
    transport = bake(cube).reshape(6, 4, 9)[:, :, 0]
    assert transport[2].max() < 1e-6
    np.testing.assert_allclose(np.delete(transport, 2, axis=0), OPEN, rtol=1e-4)


def test_open_and_two_sided_sheets_keep_their_own_side(bake, stage):
    """A single sheet is lit on its front; of two in one place, each is lit on its own."""
    sheet = stage.object_of("Sheet", stage.grid(6))
    np.testing.assert_allclose(bake(sheet)[:, 0], OPEN, rtol=1e-4)
    back = stage.grid(6)
    back.flip_normals()
    other = stage.object_of("Back", back)
    for first, second in ((sheet, other), (other, sheet)):
        transport = bake(first, second)
        np.testing.assert_allclose(transport[:, 0], OPEN, rtol=1e-4)
        assert np.sign(transport[:, 2]).tolist() == [1.0 if first == sheet else -1.0] * len(transport)


def test_shadow_of_a_single_sheet_is_not_filled(bake, blender, stage):
    """Ground under a low roof sees only its back, and is dark all the same."""
    ground = stage.object_of("Ground", stage.grid(40, 3.0))
    roof = stage.object_of("Roof", stage.grid(1, 1.5), location=(0, 0, 0.05))
    middle = np.abs(vertices_of(ground)[:, :2]).max(axis=1) < 1.0
    assert bake(ground, roof)[middle, 0].max() < 0.05 * OPEN


def litter(mesh):
    """Adds what meshes collect: loose vertices and edges, zero-area faces, doubles."""
    import bmesh

    bm = bmesh.new()
    bm.from_mesh(mesh)
    bm.verts.ensure_lookup_table()
    a, b = bm.verts[0], bm.verts[1]
    loose = [bm.verts.new(place) for place in ((0, 0, 3), (0, 1, 3), (1, 0, 3))]
    bm.edges.new(loose[:2])
    bm.faces.new([a, b, bm.verts.new(a.co)])  # a double of a: no area
    point = [bm.verts.new((0, 0, 1.5)) for _ in range(3)]
    bm.faces.new(point)
    bm.to_mesh(mesh)
    bm.free()


@pytest.mark.parametrize("mode", ["UNSHADOWED", "SHADOWED", "INTERREFLECTED"])
def test_litter_does_not_change_the_rest(bake, stage, mode):
    """Loose vertices and edges beside the faces, faces without area, doubles: finite, and the ball is as before."""
    ball = mesh_of(stage, "Ball", uv_sphere(16))
    clean = bake(ball, mode=mode)
    count = len(clean)
    litter(ball.data)
    ball.data.polygons.foreach_set("use_smooth", [True] * len(ball.data.polygons))
    found = bake(ball, mode=mode)
    assert len(found) == len(ball.data.vertices)
    np.testing.assert_allclose(found[2:count], clean[2:], rtol=0, atol=0.01)  # 0 and 1 have got another face


def test_unwelded_faces_bake_as_welded_flat_ones(bake, stage):
    """Doubles along all edges, as other programs export them: each face is its own."""
    import bmesh

    flat = mesh_of(stage, "Flat", uv_sphere(12), smooth=False)
    welded = bake(flat)
    flat.hide_render = True
    flat.select_set(False)

    def split(bm):
        uv_sphere(12)(bm)
        bmesh.ops.split_edges(bm, edges=bm.edges)

    loose = bake(mesh_of(stage, "Loose", split, smooth=False))
    np.testing.assert_allclose(welded[:, 0], OPEN, rtol=1e-4)
    np.testing.assert_allclose(loose[:, 0], OPEN, rtol=1e-4)


def test_ngons_are_flat_all_over(bake, stage):
    """A lid of one concave face of 24 corners: no seam where it is cut into triangles."""
    import bmesh

    def star(bm):
        angle = 2 * np.pi * np.arange(24) / 24
        radius = np.where(np.arange(24) % 2, 0.4, 1.0)
        bm.faces.new([bm.verts.new((r * np.cos(a), r * np.sin(a), 0)) for a, r in zip(angle, radius, strict=True)])
        bmesh.ops.extrude_face_region(bm, geom=bm.faces[:])
        bmesh.ops.translate(bm, vec=(0, 0, 1), verts=bm.verts[24:])
        bmesh.ops.recalc_face_normals(bm, faces=bm.faces)

    ob = mesh_of(stage, "Star", star, smooth=False)
    transport = bake(ob)
    lids = [np.array(face.loop_indices) for face in ob.data.polygons if face.loop_total == 24]
    assert lids
    for lid in lids:
        np.testing.assert_allclose(transport[lid, 0], OPEN, rtol=1e-4)


def test_custom_normals_are_what_receives(bake, blender, stage):
    """Foliage's trick, all normals up: the upper half is the closed form of a level floor."""
    ball = mesh_of(stage, "Ball", uv_sphere(24))
    ball.data.normals_split_custom_set_from_vertices([(0.0, 0.0, 1.0)] * len(ball.data.vertices))
    blender.context.view_layer.update()
    height = vertices_of(ball)[:, 2]
    transport, closed_form = bake(ball), bake(ball, mode="UNSHADOWED")
    np.testing.assert_allclose(closed_form, np.tile(closed_form[:1], (len(closed_form), 1)), atol=1e-3)
    np.testing.assert_allclose(transport[height > 0.99, 0], OPEN, rtol=1e-3)


@pytest.mark.parametrize(("where", "size"), [((1e5, -1e5, 1e5), 1.0), ((0, 0, 0), 1e-4), ((0, 0, 0), 1e4)])
def test_far_tiny_and_huge_objects_are_as_any(bake, blender, part, stage, where, size):
    """Their own shadows depend on shape alone: rays in float32 start from coordinates made relative in float64."""
    cup = mesh_of(stage, "Cup", uv_sphere(24))
    cup.data.transform(_dent())
    usual = bake(cup)
    cup.location, cup.scale = where, (size,) * 3
    blender.context.view_layer.update()
    found = bake(cup)
    assert np.sqrt(np.mean((found - usual) ** 2) / np.mean(usual**2)) < 1e-3
    np.testing.assert_allclose(found, usual, rtol=0, atol=4 / SAMPLES)  # a few grazing rays tip over


def _dent():
    """Sheared and stretched, so that nothing is symmetric by luck."""
    from mathutils import Matrix

    return Matrix(((1, 0.4, 0, 0), (0, 1, 0.3, 0), (0.2, 0, 0.6, 0), (0, 0, 0, 1)))


def test_what_float32_cannot_hold_is_said(bake, blender, stage, capfd):
    """A ball of one metre, and another a hundred kilometres off: contact shadows are lost, and it says so."""
    ball = mesh_of(stage, "Ball", uv_sphere(16))
    far = mesh_of(stage, "Far", uv_sphere(16))
    far.location.x = 1e5
    blender.context.view_layer.update()
    np.testing.assert_allclose(bake(ball, far)[:, 0], OPEN, rtol=1e-3)
    assert re.search(
        "'(Ball|Far)' is tiny, and far from the finest part of the scene: shadows from closer than 1 ", printed(capfd)
    )


def room(stage, segments=8, size=1.0):
    """Five sheets that touch along their edges without sharing vertices: a room that is open in front."""
    half = math.pi / 2
    places = {
        "Floor": ((0, 0, -1), (0, 0, 0)),
        "Ceiling": ((0, 0, 1), (math.pi, 0, 0)),
        "Back": ((0, 1, 0), (half, 0, 0)),
        "Left": ((-1, 0, 0), (0, half, 0)),
        "Right": ((1, 0, 0), (0, -half, 0)),
    }
    sheets = []
    for name, (place, turn) in places.items():
        ob = stage.object_of(name, stage.grid(segments, size), None, [size * x for x in place])
        ob.rotation_euler = turn
        sheets.append(ob)
    return sheets


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_sheets_that_touch_are_as_dark_as_welded_ones(blender, part, stage, scene, size):
    """The same room twice: of sheets, and as one mesh whose hard edges are shared. Creases do not glow."""
    samples = part("problem").BakeSettings("SHADOWED", 1024)
    bake, read = part("bake").bake, part("read").read_bake
    sheets = room(stage, size=size)
    blender.context.view_layer.update()

    def rows():
        plan = read(blender.context, [ob for ob in scene.objects if ob.type == "MESH"], samples)
        transport = bake(plan.problem).transport
        found = {}
        for one in plan.objects:
            group = one.receivers.group
            for point, normal, value in zip(group.points, group.normals, transport[one.group], strict=True):
                place = tuple(np.rint(point / size * 8).astype(int)) + tuple(np.rint(normal).astype(int))
                found[place] = value
        return found

    apart = rows()
    for ob in sheets:
        ob.select_set(True)
    blender.context.view_layer.objects.active = sheets[0]
    blender.ops.object.join()
    blender.ops.object.mode_set(mode="EDIT")
    blender.ops.mesh.select_all(action="SELECT")
    blender.ops.mesh.remove_doubles(threshold=1e-4 * size)
    blender.ops.object.mode_set(mode="OBJECT")
    sheets[0].data.shade_flat()
    blender.context.view_layer.update()
    welded = rows()
    assert apart.keys() == welded.keys() and len(welded) == 5 * 81
    here, there = (np.array([found[key] for key in welded]) for found in (apart, welded))
    error = np.sqrt(((here - there) ** 2).sum() / (there**2).sum())
    assert error < 0.02, f"{error:.3f}"


@pytest.mark.parametrize("degrees", [30.0, 60.0])
@pytest.mark.parametrize("even", [True, False])
def test_bent_normals_of_a_sheet_see_no_sky_through_it(bake, blender, stage, degrees, even):
    """A card whose normals lean: what it loses is the part of their hemisphere below it, (1 - cos) / 2 of a uniform sky."""
    card = stage.object_of("Card", stage.grid(4, 1.0))
    angle = np.radians(degrees)
    leans = [1.0 if even or vertex.co.x < 0.1 else -1.0 for vertex in card.data.vertices]
    card.data.normals_split_custom_set_from_vertices([(x * np.sin(angle), 0.0, np.cos(angle)) for x in leans])
    blender.context.view_layer.update()
    found = bake(card, samples=1024)[:, 0]
    np.testing.assert_allclose(found, OPEN * (1.0 + np.cos(angle)) / 2.0, rtol=0.01)
