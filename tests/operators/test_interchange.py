# SPDX-License-Identifier: GPL-3.0-or-later
"""GAMES202 files are written by the operators, come back, or are refused."""

import numpy as np
import pytest

from tests.core.references import COURSE_FACES


@pytest.fixture
def baked(blender, scene, stage):
    """A flat-shaded, self-shadowed mesh with an n-gon, under a turned sky of strength 2."""
    _, mapping = stage.environment(stage.picture("Sky", stage.six_coloured_sky(64)), strength=2.0)
    mapping.inputs["Rotation"].default_value = (0.3, -0.4, 1.2)
    ob = stage.object_of("Cube", stage.cube())
    stage.object_of("Roof", stage.grid(1, 1.0), location=(0.5, 0.0, 1.5))
    blender.context.view_layer.objects.active = ob
    ob.select_set(True)
    blender.ops.prt.bake(mode="SHADOWED", samples=64)
    return ob


def y_up_condon_shortley(direction):
    """The course's nine functions of a Blender direction, written out: its axes are (x, z, -y), its pole is its z."""
    x, y, z = direction[0], direction[2], -direction[1]
    return np.array(
        [
            0.282095,
            -0.488603 * y,
            0.488603 * z,
            -0.488603 * x,
            1.092548 * x * y,
            -1.092548 * y * z,
            0.315392 * (3 * z * z - 1),
            -1.092548 * x * z,
            0.546274 * (x * x - y * y),
        ]
    )


def test_files_are_the_courses(blender, part, scene, stage, baked, tmp_path):
    """Read by hand: the sky's radiance and the transport's function along random directions, in the course's basis."""
    from mathutils import Euler

    blender.ops.prt.export_games202(directory=str(tmp_path))
    light = np.loadtxt(tmp_path / "light.txt")
    lines = (tmp_path / "transport.txt").read_text().splitlines()
    assert light.shape == (9, 3) and lines[0] == "8" and len(lines) == 1 + 12 * 3
    first = np.array(lines[1].split(), dtype=float)
    mesh = baked.data
    mesh.calc_loop_triangles()
    stored = part("layers").read(mesh)[mesh.loop_triangles[0].loops[0]].mean(axis=1)
    basis = part("sh").basis
    turn = np.array(Euler((0.3, -0.4, 1.2)).to_matrix())
    for direction in np.random.default_rng(5).normal(size=(8, 3)):
        direction /= np.linalg.norm(direction)
        theirs = y_up_condon_shortley(direction)
        sky = 2.0 * basis(turn @ direction) @ part("light").read_light(scene.world)
        np.testing.assert_allclose(theirs @ light, sky, rtol=1e-4, atol=1e-4)
        np.testing.assert_allclose(theirs @ first, basis(direction) @ stored, atol=2e-6)


def test_round_trip_is_the_identity(blender, part, scene, stage, baked, tmp_path):
    """Export, import onto the bare mesh, export: the same bytes; and the imported light stands still."""
    one, two = tmp_path / "one", tmp_path / "two"
    blender.ops.prt.export_games202(directory=str(one))
    blender.ops.prt.remove()
    blender.ops.prt.import_games202(directory=str(one))
    blender.ops.prt.export_games202(directory=str(two))
    for name, header in (("light.txt", 0), ("transport.txt", 1)):
        first, second = (np.loadtxt(folder / name, skiprows=header) for folder in (one, two))
        np.testing.assert_allclose(first, second, rtol=2e-6, atol=1e-6)
    assert not scene.world.animation_data or not scene.world.animation_data.drivers


def test_the_scale_without_pi_is_detected(blender, part, scene, stage, baked, tmp_path):
    """0.8862 or 0.2821: both arrive as the same transport."""
    before = part("layers").read(baked.data).mean(axis=2)
    blender.ops.prt.export_games202(directory=str(tmp_path))
    header, *rows = (tmp_path / "transport.txt").read_text().splitlines()
    scaled = [" ".join(f"{float(number) * np.pi:.6g}" for number in row.split()) for row in rows]
    (tmp_path / "transport.txt").write_text("\n".join([header, *scaled]) + "\n")
    blender.ops.prt.import_games202(directory=str(tmp_path))
    np.testing.assert_allclose(part("layers").read(baked.data).mean(axis=2), before, atol=2e-6)


def _lines(change):
    """A change of a file that goes through its lines."""
    return lambda text: "\n".join(change(text.splitlines())) + "\n"


def _scientific(lines):
    return [" ".join(f"{float(w):.5E}" for w in line.split()) if " " in line else line for line in lines]


SPELLINGS = {
    "CRLF": lambda text: text.replace("\n", "\r\n"),
    "commas": lambda text: text.replace(" ", ", "),
    "tabs": lambda text: text.replace(" ", "\t"),
    "scientific notation": _lines(_scientific),
    "no last line break": str.rstrip,
}


@pytest.mark.parametrize("spelling", SPELLINGS)
def test_other_spellings_are_read(blender, part, scene, stage, baked, tmp_path, spelling):
    """What other systems make of the files is the same mesh under the same light."""
    read = part("layers").read
    blender.ops.prt.export_games202(directory=str(tmp_path))
    blender.ops.prt.import_games202(directory=str(tmp_path))
    light, transport = part("light").read_light(scene.world), read(baked.data)
    for name in ("light.txt", "transport.txt"):
        text = (tmp_path / name).read_text()
        (tmp_path / name).write_bytes(SPELLINGS[spelling](text).encode())
    blender.ops.prt.import_games202(directory=str(tmp_path))
    np.testing.assert_allclose(part("light").read_light(scene.world), light, rtol=0, atol=1e-12)
    np.testing.assert_allclose(read(baked.data), transport, rtol=0, atol=1e-7)


BROKEN = {
    "truncated light": ("light.txt", _lines(lambda lines: lines[:7]), "has 7 rows, but a light has 9"),
    "light cut in a row": ("light.txt", lambda text: text[:-12], r"light.txt, line 9: \d numbers? instead of 3"),
    "light with NaN": ("light.txt", _lines(lambda lines: ["nan 0 0", *lines[1:]]), '"nan" is not finite'),
    "too many rows": ("transport.txt", lambda text: text + text.splitlines()[1] + "\n", "has 37 rows.*36 face corners"),
    "truncated transport": ("transport.txt", lambda text: text[: len(text) // 2], "transport.txt"),
    "transport with infinity": ("transport.txt", _lines(lambda lines: [*lines[:-1], "inf" + " 0" * 8]), "not finite"),
    "no header": ("transport.txt", _lines(lambda lines: lines[1:]), "number of vertices"),
    "empty": ("transport.txt", lambda text: "", "number of vertices"),
    "words": ("transport.txt", _lines(lambda lines: [lines[0], "v 1 2 3", *lines[2:]]), '"v" is no number'),
}


@pytest.mark.parametrize("case", BROKEN)
def test_broken_files_leave_everything_as_it_was(blender, part, scene, stage, baked, tmp_path, case):
    """One sentence, and the transport, the record, the light and its drivers stay."""
    name, spoil, message = BROKEN[case]
    blender.ops.prt.export_games202(directory=str(tmp_path))
    (tmp_path / name).write_text(spoil((tmp_path / name).read_text()))
    read, light = part("layers").read, part("light")

    def state():
        record = part("record").read_record(baked.data)
        return read(baked.data).tobytes(), light.read_light(scene.world).tobytes(), repr(record)

    before = state()
    with pytest.raises(RuntimeError, match=message):
        blender.ops.prt.import_games202(directory=str(tmp_path))
    assert state() == before and len(scene.world.animation_data.drivers) == 12


def test_transport_of_an_object_that_may_move(blender, part, scene, stage, tmp_path):
    """Baked for the object itself, then turned: what is written is what a bake of the scene writes there."""
    stage.environment(stage.picture("Sky", stage.six_coloured_sky(16)))
    ob = stage.object_of("Cube", stage.cube())
    blender.context.view_layer.objects.active = ob
    ob.prt.space = "OBJECT"
    blender.ops.prt.bake(mode="UNSHADOWED")
    ob.rotation_euler, ob.scale = (0.5, -0.3, 2.0), (-1.5, 1.5, 1.5)
    blender.context.view_layer.update()
    blender.ops.prt.export_games202(directory=str(tmp_path / "object"))
    ob.prt.space = "SCENE"
    blender.ops.prt.bake(mode="UNSHADOWED")
    blender.ops.prt.export_games202(directory=str(tmp_path / "scene"))
    one, two = (np.loadtxt(tmp_path / name / "transport.txt", skiprows=1) for name in ("object", "scene"))
    np.testing.assert_allclose(one, two, atol=3e-6)


def test_an_obj_file_keeps_its_axes_and_order(blender, scene, stage, tmp_path):
    """Imported with Blender's axes and baked: row by row the functions of the file's own normals, in the file's axes."""
    points = np.random.default_rng(8).normal(size=(6, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    faces = [(0, 1, 2), (3, 0, 2), (5, 4, 1), (2, 4, 3)]
    lines = [f"{kind} {x:.6f} {y:.6f} {z:.6f}" for kind in ("v", "vn") for x, y, z in points]
    lines += ["f " + " ".join(f"{index + 1}//{index + 1}" for index in face) for face in faces]
    (tmp_path / "some.obj").write_text("\n".join(lines) + "\n")
    stage.environment(stage.picture("Sky", stage.six_coloured_sky(16)))
    blender.ops.wm.obj_import(filepath=str(tmp_path / "some.obj"))
    blender.ops.prt.bake(mode="UNSHADOWED")
    blender.ops.prt.export_games202(directory=str(tmp_path))
    lobe = np.repeat([1, 2 / 3, 1 / 4], [1, 3, 5])
    in_ours = points[:, [0, 2, 1]] * (1, -1, 1)
    wanted = [lobe * y_up_condon_shortley(in_ours[index]) for face in faces for index in face]
    np.testing.assert_allclose(np.loadtxt(tmp_path / "transport.txt", skiprows=1), wanted, atol=2e-4)


def test_a_stale_bake_is_said(blender, scene, stage, baked, tmp_path, capfd):
    """The files are written all the same; other settings of the next bake do not matter."""
    scene.prt.samples = 7
    blender.ops.prt.export_games202(directory=str(tmp_path))
    assert "is stale" not in capfd.readouterr().out
    baked.location.x = 0.5
    blender.context.view_layer.update()
    blender.ops.prt.export_games202(directory=str(tmp_path))
    assert "'Cube' is stale: it was moved" in capfd.readouterr().out


def test_the_course_s_own_parameters(blender, part, scene, stage, tmp_path):
    """Its exercise as three lines of script: cube map, type, and the files, as its own loops compute both."""
    from PIL import Image

    size, random, faces = 16, np.random.default_rng(3), {}
    (tmp_path / "Sky").mkdir()
    for name in ("posx", "negx", "posy", "negy", "posz", "negz"):
        Image.fromarray(random.integers(0, 255, (size, size, 3)).astype(np.uint8)).save(
            tmp_path / "Sky" / f"{name}.jpg"
        )
        faces[name] = (np.asarray(Image.open(tmp_path / "Sky" / f"{name}.jpg")) / 255) ** 2.2
    ob = stage.object_of("Ball", stage.icosphere(1))
    blender.context.view_layer.objects.active = ob

    blender.ops.prt.import_cubemap(directory=str(tmp_path / "Sky"), table="GAMES202")
    blender.ops.prt.bake(mode="UNSHADOWED")
    blender.ops.prt.export_games202(directory=str(tmp_path))

    def course(x, y, z):  # a direction in its axes, given in ours
        return y_up_condon_shortley((x, -z, y))

    light = np.zeros((9, 3))
    for name, frame in COURSE_FACES.items():
        for row, column in np.ndindex(size, size):
            u, v = ((2 * index + 1) / size - 1 for index in (column, row))
            angle = (2 / size) ** 2 * (1 + u * u + v * v) ** -1.5
            direction = np.array([u, v, 1]) @ np.array(frame)
            light += angle * np.outer(course(*direction / np.linalg.norm(direction)), faces[name][row, column])
    written = np.loadtxt(tmp_path / "light.txt")
    np.testing.assert_allclose(written, light, rtol=0, atol=2e-3 * light.max())  # middle values of 16 x 16 texels

    lobe = np.repeat([1, 2 / 3, 1 / 4], [1, 3, 5])
    vertices = [ob.data.vertices[index].normal for face in ob.data.polygons for index in face.vertices]
    wanted = [lobe * y_up_condon_shortley(normal) for normal in vertices]
    np.testing.assert_allclose(np.loadtxt(tmp_path / "transport.txt", skiprows=1), wanted, atol=1e-5)


def test_refusals_leave_everything_as_it_was(blender, part, scene, stage, baked, tmp_path):
    """Another mesh's file names both counts; a missing folder is said; the bake and the light stay."""
    blender.ops.prt.export_games202(directory=str(tmp_path))
    before = part("layers").read(baked.data)
    text = (tmp_path / "transport.txt").read_text()
    (tmp_path / "transport.txt").write_text("\n".join(text.splitlines()[:-1]) + "\n")
    with pytest.raises(RuntimeError, match=r"35 rows.*36 face corners"):
        blender.ops.prt.import_games202(directory=str(tmp_path))
    with pytest.raises(RuntimeError, match=r"nowhere.*cannot be used"):
        blender.ops.prt.import_games202(directory=str(tmp_path / "nowhere"))
    assert np.array_equal(part("layers").read(baked.data), before)
    assert scene.world.animation_data.drivers
    blender.ops.prt.remove()
    with pytest.raises(RuntimeError, match="not baked"):
        blender.ops.prt.export_games202(directory=str(tmp_path))
