# SPDX-License-Identifier: GPL-3.0-or-later
"""The course's text files hold its convention, come back as they were written, and are refused where they are broken."""

import numpy as np
import pytest

from prt_addon.core.exchange import games202
from prt_addon.core.exchange.games202 import InterchangeError
from prt_addon.core.sky import cube_map
from prt_addon.core.sphere import sh
from prt_addon.core.sphere.rotation import rotation_matrix
from tests.core.references import COURSE_FACES, order2, random_directions

OPEN = 1 / np.sqrt(4 * np.pi)


def course_basis(directions):
    """The nine harmonics as in the course's library, written out; directions in its own axes, y up, pole on z."""
    x, y, z = np.moveaxis(np.asarray(directions, dtype=np.float64), -1, 0)
    return np.stack(
        [
            0.282095 + 0 * x,
            -0.488603 * y,
            0.488603 * z,
            -0.488603 * x,
            1.092548 * x * y,
            -1.092548 * y * z,
            0.315392 * (-x * x - y * y + 2 * z * z),
            -1.092548 * x * z,
            0.546274 * (x * x - y * y),
        ],
        axis=-1,
    )


def to_course_axes(directions):
    """Blender's z is up; the course's y is, and its z comes towards the viewer, Blender's -y."""
    x, y, z = np.moveaxis(directions, -1, 0)
    return np.stack([x, z, -y], axis=-1)


def some_transport(corners=12, seed=4):
    """Rows as of open receivers of all orientations, slightly shadowed."""
    normals = random_directions(corners, seed)
    shade = np.random.default_rng(seed).uniform(0.6, 1, size=(corners, 1))
    shade[0] = 1
    return shade * order2(normals) * sh.per_coefficient([1, 2 / 3, 1 / 4])


def some_light(seed=5):
    return np.random.default_rng(seed).normal(size=(9, 3))


def body(path):
    """The numbers of a file, by the plainest of readers."""
    return np.array([[float(word) for word in line.split()] for line in path.read_text().splitlines()])


def test_conversion_is_direct_evaluation():
    """A function is the same function in both conventions: same value where the same direction is meant."""
    directions, ours = random_directions(40), some_light()
    theirs = games202.course_matrix() @ ours
    shown = course_basis(to_course_axes(directions)) @ theirs
    assert np.allclose(shown, order2(directions) @ ours, rtol=0, atol=1e-5)  # six published digits


def test_signs_and_axes_by_hand():
    """Lamps on each axis: band 1 shows where they went."""
    for ours, theirs in (
        ((1, 0, 0), (0, 0, -1)),  # right stays right: the course's third number is -x
        ((0, 0, 1), (-1, 0, 0)),  # up is its y: the first is -y
        ((0, 1, 0), (0, -1, 0)),  # ahead is its -z: the second is z
    ):
        band1 = (games202.course_matrix() @ order2(np.array(ours, dtype=float)))[1:4]
        assert np.allclose(band1 / np.abs(band1).max(), theirs, rtol=0, atol=1e-14)


@pytest.mark.parametrize("order", [0, 1, 2, 8])
def test_conversion_is_orthogonal_and_exact(order):
    """So that light . transport is the same in both; what is only moved is moved bit for bit."""
    matrix = games202.course_matrix(order)
    assert np.allclose(matrix @ matrix.T, np.eye(len(matrix)), rtol=0, atol=1e-13)
    assert np.array_equal(matrix, matrix.T)  # one matrix serves both ways
    assert set(np.abs(matrix[:4, :4]).ravel()) <= {0.0, 1.0}
    assert set(np.abs(matrix[4:9, 4:9]).ravel()) <= {0.0, 0.5, np.sqrt(0.75), 1.0}
    turned = rotation_matrix(cube_map.Y_UP_TO_Z_UP, order)
    assert np.allclose(np.abs(matrix), np.abs(turned), rtol=0, atol=1e-12)


def test_written_light_is_the_course_s(tmp_path):
    """Nine rows R G B, as the course's precomputation would print its own sum over the sky."""
    path = tmp_path / "light.txt"
    lamps, colours = random_directions(5), np.random.default_rng(6).uniform(size=(5, 3))
    games202.write_light(path, order2(lamps).T @ colours)
    assert np.allclose(body(path), course_basis(to_course_axes(lamps)).T @ colours, rtol=0, atol=2e-5)


def test_course_cube_map_to_course_light(tmp_path):
    """Its own loop: names, table, row order and harmonics as it has them, without a word of ours."""
    size, path = 8, tmp_path / "light.txt"
    random = np.random.default_rng(7)
    faces = {name: random.uniform(size=(size, size, 3)).astype(np.float32) for name in cube_map.FACES}
    total, fine = np.zeros((9, 3)), 4  # the solid angle by splitting a texel in fine**2
    inner = (np.arange(fine) + 0.5) / fine
    for name, (right, down, centre) in COURSE_FACES.items():
        for row, column in np.ndindex(size, size):
            u, v = 2 * (column + 0.5) / size - 1, 2 * (row + 0.5) / size - 1
            direction = u * np.array(right) + v * np.array(down) + np.array(centre)
            us, vs = (2 * (index + inner) / size - 1 for index in (column, row))
            angle = np.sum((1 + us**2 + vs[:, None] ** 2) ** -1.5) * (2 / size / fine) ** 2
            total += angle * np.outer(course_basis(direction / np.linalg.norm(direction)), faces[name][row, column])
    games202.write_light(path, cube_map.project_cubemap(faces, "GAMES202"))
    assert np.allclose(body(path), total, rtol=0, atol=1e-3 * np.abs(total).max())


def test_written_transport(tmp_path):
    """A header with the vertex count, a row per corner, the 1/pi, and a last line break."""
    path, transport = tmp_path / "transport.txt", some_transport()
    games202.write_transport(path, transport, 4)
    text = path.read_text()
    assert text.startswith("4\n0.282095 ") and text.endswith("\n") and not text.endswith("\n\n")
    rows = np.array([[float(word) for word in line.split(" ")] for line in text.splitlines()[1:]])
    assert rows.shape == (12, 9)
    normals = random_directions(12, 4)
    shown = course_basis(to_course_axes(normals)) * [1, *[2 / 3] * 3, *[1 / 4] * 5]
    assert np.allclose(rows / rows[:, :1], shown / shown[:, :1], rtol=0, atol=1e-4)


def test_six_significant_digits(tmp_path):
    """As C++ prints by default; rounding of the change of axes is not printed."""
    path, light = tmp_path / "light.txt", np.zeros((9, 3))
    light[0] = (1234567.0, 0.000123456789, 2 / 3)
    games202.write_light(path, light)
    assert path.read_bytes() == b"1.23457e+06 0.000123457 0.666667\n" + b"0 0 0\n" * 8


@pytest.mark.parametrize("scale", [1e-6, 1, 9.9999996, 1e5])
@pytest.mark.parametrize("seed", range(5))
def test_light_round_trip(tmp_path, seed, scale):
    """Exported, imported and exported again: the same bytes, whatever the range of the numbers."""
    first, second = tmp_path / "light.txt", tmp_path / "again.txt"
    wide = some_light(seed) * 10.0 ** np.random.default_rng(seed).integers(-9, 1, size=(9, 3))
    for light in (some_light(seed) * scale, wide * scale):
        light[0, 0] = scale
        games202.write_light(first, light)
        read = games202.read_light(first)
        assert np.allclose(read, light, rtol=0, atol=1e-5 * np.abs(light).max())
        games202.write_light(second, read)
        assert first.read_bytes() == second.read_bytes()


@pytest.mark.parametrize("seed", range(5))
def test_foreign_light_round_trip(tmp_path, seed):
    """A file of the course's, with zeros and small numbers beside large ones, is written again as it was."""
    path, random = tmp_path / "light.txt", np.random.default_rng(seed)
    numbers = random.normal(size=(9, 3)) * 10.0 ** random.integers(-5, 1, size=(9, 3)) * (random.random((9, 3)) < 0.7)
    numbers[0] = 1
    numbers[5] = 0
    text = "".join(" ".join(f"{number + 0.0:.6g}" for number in row) + "\n" for row in numbers)
    path.write_text(text)
    games202.write_light(path, games202.read_light(path))
    assert path.read_text() == text


def test_transport_round_trip(tmp_path):
    """Of a mesh of some size; the second file is the first."""
    first, second, transport = tmp_path / "transport.txt", tmp_path / "again.txt", some_transport(3000)
    games202.write_transport(first, transport, 1000)
    read, flavour = games202.read_transport(first, 3000)
    assert flavour == "RADIANCE" and np.allclose(read, transport, rtol=0, atol=1e-6)
    games202.write_transport(second, read, 1000)
    assert first.read_bytes() == second.read_bytes()


@pytest.mark.parametrize("openness", [0.6, 1.0, 1.15])
def test_flavours(tmp_path, openness):
    """With and without 1/pi, of meshes that are rather closed, open, or noisy: the same transport comes out."""
    path, transport = tmp_path / "transport.txt", some_transport() * openness
    games202.write_transport(path, transport * np.pi, 4)
    read, flavour = games202.read_transport(path, 12)
    assert flavour == "IRRADIANCE" and np.allclose(read, transport, rtol=0, atol=1e-5)
    games202.write_transport(path, transport, 4)
    read, flavour = games202.read_transport(path, 12)
    assert flavour == "RADIANCE" and np.allclose(read, transport, rtol=0, atol=1e-5)


def test_some_dark_corners_do_not_hide_the_flavour(tmp_path):
    """The inside of a mesh is black in both: the most open corner decides."""
    path, transport = tmp_path / "transport.txt", some_transport()
    transport[1:] *= 0.01
    games202.write_transport(path, transport * np.pi, 4)
    assert games202.read_transport(path, 12)[1] == "IRRADIANCE"


VARIANTS = {
    "CRLF": lambda text: text.replace("\n", "\r\n"),
    "CR": lambda text: text.replace("\n", "\r"),
    "tabs": lambda text: text.replace(" ", "\t"),
    "commas": lambda text: text.replace(" ", ", "),
    "many spaces": lambda text: text.replace(" ", "   ").replace("\n", "  \n"),
    "blank trailing lines": lambda text: text + "\n  \n\n",
    "no last line break": lambda text: text.rstrip("\n"),
    "byte order mark": lambda text: "\ufeff" + text,
    "scientific": lambda text: "\n".join(
        " ".join(word if len(line.split()) == 1 else f"{float(word):.5E}" for word in line.split())
        for line in text.splitlines()
    ),
}


@pytest.mark.parametrize("variant", VARIANTS)
def test_other_spellings(tmp_path, variant):
    """What editors, spreadsheets and other systems do to such files is read as if nothing had happened."""
    light, transport = tmp_path / "light.txt", tmp_path / "transport.txt"
    games202.write_light(light, some_light())
    games202.write_transport(transport, some_transport(), 4)
    expected = games202.read_light(light), games202.read_transport(transport, 12)[0]
    for path in (light, transport):
        path.write_bytes(VARIANTS[variant](path.read_text()).encode())
    assert np.allclose(games202.read_light(light), expected[0], rtol=0, atol=1e-14)
    assert np.allclose(games202.read_transport(transport, 12)[0], expected[1], rtol=0, atol=1e-14)


ROW = "0.1 0.2 0.3 0.4 0.5 0.6 0.7 0.8 0.9\n"
LIGHT = "0.1 0.2 0.3\n"

BROKEN_LIGHTS = {
    "": r"has 0 rows, but a light has 9",
    LIGHT * 8: r"has 8 rows, but a light has 9",
    LIGHT * 16: r"has 16 rows, but a light has 9",
    LIGHT * 3 + "0.1 0.2\n" + LIGHT * 5: r"line 4: 2 numbers instead of 3; is the file cut off",
    LIGHT * 8 + "0.1 0.": r"line 9: 2 numbers instead of 3",
    LIGHT * 3 + "\n0.1 x 2\n" + LIGHT * 5: r'line 5: "x" is no number',
    LIGHT * 8 + "0.1 nan 0.3\n": r'line 9: "nan" is not finite',
    LIGHT * 8 + "0.1 0.2 -inf\n": r'line 9: "-inf" is not finite',
    LIGHT * 8 + "0.1 0.2 1e999\n": r'line 9: "1e999" is not finite',
    LIGHT * 8 + "# 0.1 0.2\n": r'line 9: "#" is no number',
    LIGHT * 8 + "1_0 0.1 0.2\n": r"something else than rows of 3 numbers",
    "1 2 3 4 5 6 7 8 9\n" * 3: r"line 1: 9 numbers instead of 3",
}

BROKEN_TRANSPORTS = {
    "": "does not start with the number of vertices",
    ROW * 3: "does not start with the number of vertices",
    "many\n" + ROW * 3: "does not start with the number of vertices",
    "-3\n" + ROW * 3: "does not start with the number of vertices",
    "3\n": "has 0 rows, but the mesh has 3 face corners",
    "3\n" + ROW * 2: "has 2 rows, but the mesh has 3 face corners",
    "3\n" + ROW * 6: "has 6 rows, but the mesh has 3 face corners",
    "3\n" + ROW * 2 + "0.1 0.2 0.3": "line 4: 3 numbers instead of 9; is the file cut off",
    "3\n\n" + ROW * 2 + ROW.replace("0.5", "0,5"): "line 5: 10 numbers instead of 9",
    "3\n" + ROW * 2 + ROW.replace("0.5", "NaN"): 'line 4: "NaN" is not finite',
    "3\n" + ROW + ROW.replace("0.5", "0.5.1") + ROW: 'line 3: "0.5.1" is no number',
}


@pytest.mark.parametrize("text", BROKEN_LIGHTS)
def test_broken_lights_are_refused(tmp_path, text):
    """With the line, or with both counts."""
    path = tmp_path / "light.txt"
    path.write_text(text)
    with pytest.raises(InterchangeError, match=r"light\.txt.*" + BROKEN_LIGHTS[text]):
        games202.read_light(path)


@pytest.mark.parametrize("text", BROKEN_TRANSPORTS)
def test_broken_transports_are_refused(tmp_path, text):
    """With the line, or with both counts."""
    path = tmp_path / "transport.txt"
    path.write_text(text)
    with pytest.raises(InterchangeError, match=r"transport\.txt.*" + BROKEN_TRANSPORTS[text]):
        games202.read_transport(path, 3)


def test_pictures_are_refused(tmp_path):
    """A file of bytes, chosen by mistake."""
    path = tmp_path / "light.jpg"
    path.write_bytes(b"\xff\xd8\xff\xe0\x00\x10JFIF")
    with pytest.raises(InterchangeError, match="no text file"):
        games202.read_light(path)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_broken_numbers_are_not_written(tmp_path, bad):
    """Nothing is left behind that cannot be read."""
    light, transport = some_light(), some_transport()
    light[4, 1] = transport[4, 1] = bad
    with pytest.raises(InterchangeError, match=r"light\.txt cannot hold NaN"):
        games202.write_light(tmp_path / "light.txt", light)
    with pytest.raises(InterchangeError, match=r"transport\.txt cannot hold NaN"):
        games202.write_transport(tmp_path / "transport.txt", transport, 4)
    assert not list(tmp_path.iterdir())
