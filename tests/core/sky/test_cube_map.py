# SPDX-License-Identifier: GPL-3.0-or-later
"""Six faces become the SH light and the equirectangular picture of the sky that they show."""

import numpy as np
import pytest

from prt_addon.core.errors import PictureError
from prt_addon.core.sky import cube_map
from prt_addon.core.sky import projection as envmap
from tests.core.references import order2, random_directions, sphere_quadrature

# The two tables as published, u right and v down, in a Y-up world: the OpenGL specification's, solved for the
# direction, and the course's.
OPENGL = {
    "posx": lambda u, v: (1, -v, -u),
    "negx": lambda u, v: (-1, -v, u),
    "posy": lambda u, v: (u, 1, v),
    "negy": lambda u, v: (u, -1, -v),
    "posz": lambda u, v: (u, -v, 1),
    "negz": lambda u, v: (-u, -v, -1),
}
GAMES202 = {
    "posx": lambda u, v: (1, -v, u),
    "negx": lambda u, v: (-1, -v, u),
    "posy": lambda u, v: (u, -1, -v),
    "negy": lambda u, v: (u, 1, v),
    "posz": lambda u, v: (-u, -v, -1),
    "negz": lambda u, v: (u, -v, 1),
}
TABLES = {"OPENGL": OPENGL, "GAMES202": GAMES202}
EVERY_FACE = [(table, face) for table in TABLES for face in cube_map.FACES]


def seen(table, face, u, v):
    """Unit direction in Blender's axes, written out: ahead, -z of a Y-up world, is +y."""
    x, y, z = np.broadcast_arrays(*TABLES[table][face](u, v))
    return np.stack([x, -z, y], axis=-1) / np.sqrt(x * x + y * y + z * z)[..., None]


def black(size):
    return {face: np.zeros((size, size, 3), dtype=np.float32) for face in cube_map.FACES}


def random_cube(size, seed=5):
    """Texels of a wide range, as in photographs."""
    random = np.random.default_rng(seed)
    return {face: random.exponential(size=(size, size, 3)).astype(np.float32) ** 3 for face in cube_map.FACES}


def smooth_cube(size, table, light):
    """Each texel shows the order-2 light (9, 3) at its middle."""
    u = (2 * np.arange(size) + 1) / size - 1
    return {face: (order2(seen(table, face, u, u[:, None])) @ light).astype(np.float32) for face in cube_map.FACES}


@pytest.mark.parametrize("size", [1, 2, 7, 64])
def test_solid_angles_cover_the_sphere(size):
    """Six faces are a sphere; a texel is the integral of its part of the face, by quadrature."""
    angles = cube_map.face_solid_angles(size)
    assert angles.shape == (size, size)
    assert np.isclose(6 * angles.sum(), 4 * np.pi, rtol=1e-13)
    node, weight = np.polynomial.legendre.leggauss(20)
    for row, column in ((0, 0), (size // 2, size - 1)):
        u, v = (2 * (index + (node + 1) / 2) / size - 1 for index in (column, row))
        density = (1 + u**2 + v[:, None] ** 2) ** -1.5
        assert np.isclose(angles[row, column], weight @ density @ weight / size**2, rtol=1e-11)


def test_solid_angles_of_some_rows():
    """A part is the part of the whole."""
    assert np.array_equal(cube_map.face_solid_angles(9, slice(3, 5)), cube_map.face_solid_angles(9)[3:5])


@pytest.mark.parametrize("table", TABLES)
@pytest.mark.parametrize("size", [1, 2, 33])
def test_constant_cube(table, size):
    """L_0 = c sqrt(4pi) and nothing else, at any size: the cube's symmetry leaves nothing in bands 1 and 2."""
    faces = [np.full((size, size, 3), (1, 2, 7.25), dtype=np.float32)] * 6
    light = cube_map.project_cubemap(faces, table)
    assert np.allclose(light[0], np.sqrt(4 * np.pi) * np.array([1, 2, 7.25]), rtol=1e-13)
    assert np.allclose(light[1:], 0, atol=1e-12)


@pytest.mark.parametrize(("table", "face"), EVERY_FACE)
def test_hot_texel_lands_where_the_table_says(table, face):
    """Off the middle of each face: a face that is mirrored, turned or swapped cannot pass."""
    size, row, column = 32, 3, 22
    faces = black(size)
    faces[face][row, column] = (1000, 500, 250)
    light = cube_map.project_cubemap(faces, table)
    direction = seen(table, face, (2 * column + 1) / size - 1, (2 * row + 1) / size - 1)
    radiance = np.outer(order2(direction), (1000, 500, 250)) * cube_map.face_solid_angles(size)[row, column]
    assert np.allclose(light, radiance, rtol=0, atol=1e-12)


@pytest.mark.parametrize("table", TABLES)
def test_every_texel_by_hand(table):
    """One basis for six faces is the plain sum over all texels."""
    faces, angles, light = random_cube(6), cube_map.face_solid_angles(6), np.zeros((9, 3))
    for face, row, column in ((f, r, c) for f in faces for r in range(6) for c in range(6)):
        direction = seen(table, face, (2 * column + 1) / 6 - 1, (2 * row + 1) / 6 - 1)
        light += np.outer(order2(direction) * angles[row, column], faces[face][row, column])
    assert np.allclose(cube_map.project_cubemap(faces, table), light, rtol=0, atol=1e-12)
    assert np.allclose(cube_map.project_cubemap(list(faces.values()), table), light, rtol=0, atol=1e-12)
    assert np.allclose(cube_map.project_cubemap(faces, table, 8)[:9], light, rtol=0, atol=1e-12)


@pytest.mark.parametrize("texels", [1, 40, 1 << 20])
def test_rows_at_a_time_do_not_matter(monkeypatch, texels):
    """How much memory is used must change neither the light nor the picture."""
    faces = random_cube(17)
    light, picture = cube_map.project_cubemap(faces), cube_map.to_equirect(faces)
    monkeypatch.setattr(cube_map, "_TEXELS_AT_A_TIME", texels)
    assert np.allclose(cube_map.project_cubemap(faces), light, rtol=1e-12, atol=1e-12)
    assert np.allclose(cube_map.to_equirect(faces), picture, rtol=1e-6, atol=0)


def test_sums_are_float64():
    """In float32, millions of small texels drift by percents."""
    faces = [np.full((1024, 1024, 3), 0.1, dtype=np.float32)] * 6
    light = cube_map.project_cubemap(faces)
    assert np.allclose(light[0], np.float64(np.float32(0.1)) * np.sqrt(4 * np.pi), rtol=1e-12)


@pytest.mark.parametrize("table", TABLES)
@pytest.mark.parametrize("size", [16, 64])
def test_projection_of_a_known_light(table, size):
    """An order-2 sky comes back; texels that stand at their middle leave an error of 1 / N**2."""
    light = np.random.default_rng(9).normal(size=(9, 3))
    projected = cube_map.project_cubemap(smooth_cube(size, table, light), table)
    assert np.abs(projected - light).max() < 2 / size**2 * np.abs(light).max()


@pytest.mark.parametrize("table", TABLES)
@pytest.mark.parametrize("size", [16, 64])
def test_equirect_shows_the_same_light(table, size):
    """The Blender world made from a cube map is lit as the cube map is, within 3 / N**2 for a smooth sky."""
    light = np.random.default_rng(10).normal(size=(9, 3))
    faces = smooth_cube(size, table, light)
    picture = cube_map.to_equirect(faces, table)
    assert picture.shape == (2 * size, 4 * size, 3) and picture.dtype == np.float32
    error = np.abs(envmap.project_equirect(picture) - cube_map.project_cubemap(faces, table)).max()
    assert error < 3 / size**2 * np.abs(light).max()


@pytest.mark.parametrize("table", TABLES)
def test_equirect_of_noise(table):
    """The worst case, texels that have nothing to do with each other: within 2 % of the mean light at 64."""
    faces = random_cube(64)
    light = cube_map.project_cubemap(faces, table)
    shown = envmap.project_equirect(cube_map.to_equirect(faces, table))
    assert np.abs(shown - light).max() < 0.02 * light[0].max()


@pytest.mark.parametrize(("table", "face"), EVERY_FACE)
def test_equirect_shows_each_face_where_it_is(table, face):
    """Blender's lookup formula, along the table's direction, finds the texel's colour."""
    size, height = 8, 512
    faces = {name: np.full((size, size, 3), 9, dtype=np.float32) for name in cube_map.FACES}
    ramp = np.arange(size, dtype=np.float32)
    faces[face][...] = np.stack([*np.broadcast_arrays(ramp, ramp[:, None]), np.zeros((size, size))], axis=-1)
    picture = cube_map.to_equirect(faces, table, height)
    for column, row in ((1, 2), (6, 4), (3, 3)):
        x, y, z = seen(table, face, (2 * column + 1) / size - 1, (2 * row + 1) / size - 1)
        u, v = 0.5 - np.arctan2(y, x) / (2 * np.pi), 0.5 + np.arcsin(z) / np.pi
        colour = picture[int(v * height), int(u * 2 * height) % (2 * height)]
        assert np.allclose(colour, (column, row, 0), rtol=0, atol=0.05)


def test_no_seams_between_faces():
    """Across the edges of a smooth cube map the error is of the second order, as within its faces."""
    light = np.random.default_rng(11).normal(size=(9, 3))
    height = 128
    row, column = np.indices((height, 2 * height))
    azimuth, elevation = np.pi * (1 - (column + 0.5) / height), np.pi * ((row + 0.5) / height - 0.5)
    ring = np.cos(elevation)
    directions = np.stack([ring * np.cos(azimuth), ring * np.sin(azimuth), np.sin(elevation)], axis=-1)
    picture = cube_map.to_equirect(smooth_cube(32, "OPENGL", light), height=height)
    assert np.abs(picture - order2(directions) @ light).max() < 0.02 * np.abs(light).max()


def test_faces_are_seen_from_inside():
    """None of OpenGL's is mirrored; of the course's, one is."""
    for table, signs in (("OPENGL", [-1] * 6), ("GAMES202", [1, -1, -1, -1, -1, -1])):
        middles = np.array([seen(table, face, 0, 0) for face in cube_map.FACES])
        rights, downs = (np.array([seen(table, face, *uv) for face in cube_map.FACES]) for uv in ((1, 0), (0, 1)))
        assert np.array_equal(np.sign(np.linalg.det(np.stack([rights, downs, middles], axis=1))), signs)
        assert np.allclose(np.linalg.det(cube_map._TABLES[table]), signs)


def test_course_light_is_the_real_one_with_faces_moved():
    """The two tables agree after renaming four faces and mirroring one, and on nothing less."""
    faces = random_cube(8)
    course = cube_map.project_cubemap(faces, "GAMES202")
    moved = {
        **faces,
        "posx": faces["posx"][:, ::-1],
        "posy": faces["negy"],
        "negy": faces["posy"],
        "posz": faces["negz"],
        "negz": faces["posz"],
    }
    assert np.allclose(cube_map.project_cubemap(moved, "OPENGL"), course, rtol=0, atol=1e-12)
    assert not np.allclose(cube_map.project_cubemap(faces, "OPENGL"), course, rtol=0, atol=0.1)


def test_brute_force_integral():
    """Looking up every direction of a quadrature, by OpenGL's own table of s and t, gives the same light."""
    size = 32
    faces = smooth_cube(size, "OPENGL", np.random.default_rng(12).normal(size=(9, 3)))
    directions, weights = sphere_quadrature(300)
    x, y, z = directions[:, 0], directions[:, 2], -directions[:, 1]  # Y up
    lookup = {  # major axis, s, t
        "posx": (x, -z, -y),
        "negx": (-x, z, -y),
        "posy": (y, x, z),
        "negy": (-y, x, -z),
        "posz": (z, x, -y),
        "negz": (-z, -x, -y),
    }
    total = np.zeros((9, 3))
    for face, (major, s, t) in lookup.items():
        here = major == np.abs(np.stack([x, y, z])).max(axis=0)
        column, row = (((w[here] / major[here] + 1) / 2 * size).astype(int).clip(0, size - 1) for w in (s, t))
        total += (order2(directions[here]) * weights[here, None]).T @ faces[face][row, column]
    light = cube_map.project_cubemap(faces)
    assert np.abs(light - total).max() < 3 / size**2 * np.abs(light).max()


def test_decoding():
    """The course's plain power and the published sRGB curve; from bytes and from fractions."""
    encoded = np.array([0, 10, 128, 255], dtype=np.uint8)
    course = cube_map.decode(encoded, "GAMES202")
    assert course.dtype == np.float32
    assert np.allclose(course, (np.array([0, 10, 128, 255]) / 255) ** 2.2, rtol=1e-5)
    assert np.allclose(cube_map.decode((encoded / 255).astype(np.float32), "GAMES202"), course, rtol=1e-6)
    assert np.allclose(cube_map.decode(encoded), [0, 10 / 255 / 12.92, 0.21586, 1], rtol=1e-4)


def broken(change):
    faces = black(4)
    change(faces)
    return faces


def hot(value):
    return lambda faces: faces["negz"].__setitem__((0, 1, 2), value)


BROKEN = [
    (lambda faces: faces.pop("negy"), "lacks negy"),
    (lambda faces: faces.update(posy=np.zeros((4, 5, 3))), "posy is 5 x 4 texels"),
    (lambda faces: faces.update(negz=np.zeros((8, 8, 3))), "negz is 8 texels wide but posx is 4"),
    (lambda faces: faces.update(posx=np.zeros((0, 0, 3))), "posx is 0 x 0"),
    (lambda faces: faces.update(posz=np.zeros((4, 4, 4))), "posz is no RGB"),
    (lambda faces: faces.update(posz=np.zeros((4, 4))), "posz is no RGB"),
    (hot(np.nan), "negz holds NaN"),
    (hot(-np.inf), "negz holds NaN or infinite"),
]


@pytest.mark.parametrize(("change", "message"), BROKEN)
@pytest.mark.parametrize("use", [cube_map.project_cubemap, cube_map.to_equirect])
def test_broken_faces_are_refused(use, change, message):
    """The message names the face, and what is wrong with it."""
    with pytest.raises(PictureError, match=message):
        use(broken(change))


def test_five_faces_are_refused():
    """In a row without names, the count is all that can be said."""
    with pytest.raises(PictureError, match="6 faces, not 5"):
        cube_map.project_cubemap(list(black(2).values())[:5])


def test_directions_map_to_blender_axes():
    """Up is up, ahead is +y, right is right."""
    y_up = np.array([[0, 1, 0], [0, 0, -1], [1, 0, 0]])
    assert np.array_equal(y_up @ cube_map.Y_UP_TO_Z_UP.T, [[0, 0, 1], [0, 1, 0], [1, 0, 0]])
    some = random_directions(5)
    x, y, z = some.T
    assert np.array_equal(some @ cube_map.Y_UP_TO_Z_UP.T, np.stack([x, -z, y], axis=1))


def lone_suns(size):
    """One texel beside the middle of each face, in a black sky."""
    faces = black(size)
    for index, face in enumerate(faces.values()):
        face[size // 3, size // 2 + index] = (1000, 500 * index, 200)
    return faces


@pytest.mark.parametrize("table", TABLES)
@pytest.mark.parametrize("size", [16, 64])
def test_resampling_keeps_suns(table, size):
    """Their energy within 3 %; with the light put right, what is left is a tenth of a texel of direction."""
    for faces in (lone_suns(size), {**black(size), "posy": lone_suns(size)["posy"]}):
        light = cube_map.project_cubemap(faces, table)
        picture = cube_map.to_equirect(faces, table)
        assert np.abs(envmap.project_equirect(picture) - light)[0].max() < 0.03 * light[0].max()
        shown = envmap.project_equirect(cube_map.with_light(picture, light), interpolated=True)
        assert np.abs(shown - light).max() < 0.1 * 2 / size * np.abs(light).max()


def test_with_light_changes_little():
    """A noisy sky with a sun: the light is the faces' own to six digits, the sky without the sun stays as it was."""
    faces = random_cube(64)
    faces["posz"][20, 30] = 1e5
    light = cube_map.project_cubemap(faces)
    picture = cube_map.to_equirect(faces)
    right = cube_map.with_light(picture, light)
    assert right.dtype == np.float32
    assert np.abs(envmap.project_equirect(picture) - light).max() > 1e-3 * np.abs(light).max()
    assert np.abs(envmap.project_equirect(right, interpolated=True) - light).max() < 2e-6 * np.abs(light).max()
    assert np.median(np.abs(right / picture - 1)) < 2e-3


@pytest.mark.parametrize(("size", "height"), [(64, 32), (60, 50), (30, 16)])
def test_smaller_equirect(size, height):
    """A picture coarser than the cube map averages it; its light can be put right all the same."""
    faces = random_cube(size)
    light, picture = cube_map.project_cubemap(faces), cube_map.to_equirect(faces, height=height)
    assert picture.shape == (height, 2 * height, 3)
    assert np.abs(envmap.project_equirect(picture) - light).max() < 0.1 * light.max()
    shown = envmap.project_equirect(cube_map.with_light(picture, light), interpolated=True)
    assert np.abs(shown - light).max() < 1e-5 * light.max()


def test_with_light_of_black():
    """Nothing to change, nothing to divide by."""
    picture = np.zeros((8, 16, 3), dtype=np.float32)
    assert np.array_equal(cube_map.with_light(picture, np.zeros((9, 3))), picture)
