# SPDX-License-Identifier: GPL-3.0-or-later
"""Importing a cube map gives its light and a world that shows it, or a sentence."""

import struct
import zlib

import numpy as np
import pytest
from PIL import Image

FACES = ("posx", "negx", "posy", "negy", "posz", "negz")
ROTATIONS = [(0.0, 0.0, 0.0), (0.0, 0.0, 1.1), (0.7, 0.0, 0.0), (0.4, -0.9, 2.3), (np.pi, 0.2, -1.0)]


def noise(size=16, seed=1):
    """Six byte pictures, no two alike, smooth enough for JPEG."""
    random = np.random.default_rng(seed)
    coarse = random.integers(20, 235, size=(6, size // 8, size // 8, 3))
    return dict(zip(FACES, np.kron(coarse, np.ones((1, 8, 8, 1))).astype(np.uint8), strict=True))


def write_encoded(folder, faces, suffix):
    """Byte pictures (top row first) as files; `16.png` has sixteen bits a channel, and holes in its alpha."""
    folder.mkdir()
    for name, face in faces.items():
        if suffix == "16.png":
            holes = np.full((*face.shape[:2], 1), 128, dtype=np.uint8)
            _write_png16(folder / f"{name}.png", np.concatenate([face, holes], axis=-1).astype(np.uint16) * 257)
        else:
            Image.fromarray(face).save(folder / f"{name}{suffix}", quality=100)
    return folder


def _write_png16(path, pixels):
    """RGBA, by the PNG specification."""

    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    rows = b"".join(b"\0" + row.astype(">u2").tobytes() for row in pixels)
    header = struct.pack(">IIBBBBB", pixels.shape[1], pixels.shape[0], 16, 6, 0, 0, 0)
    parts = chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + parts)


def write_float(stage, folder, faces, suffix=".exr"):
    """Linear pictures (top row first) as files, by Blender."""
    import bpy

    folder.mkdir()
    for name, face in faces.items():
        image = stage.picture(name, face[::-1])
        image.filepath_raw = str(folder / f"{name}{suffix}")
        image.file_format = "OPEN_EXR" if suffix == ".exr" else "HDR"
        image.save()
        bpy.data.images.remove(image)
    return folder


def hot_texel(face, size=64):
    """A sky of two greys, dark below, with one sun beside the middle of a face."""
    faces = {name: np.full((size, size, 3), (0.2, 0.25, 0.3), dtype=np.float32) for name in FACES}
    faces["negy"] /= 4
    faces[face][size // 3, size // 4] = (1000, 600, 300)
    return faces


def photographic(part, size=64):
    """Nearest texels of an HDRI with a strong sun, as OpenGL holds a cube map."""
    import bpy
    import headless

    picture = part("images").linear_pixels(bpy.data.images.load(str(headless.studio_hdri("sunrise"))))
    height, width = picture.shape[:2]
    u, v = np.meshgrid(*[(2 * np.arange(size) + 1) / size - 1] * 2)
    one = np.ones_like(u)
    y_up = {
        "posx": (one, -v, -u),
        "negx": (-one, -v, u),
        "posy": (u, one, v),
        "negy": (u, -one, -v),
        "posz": (u, -v, one),
        "negz": (-u, -v, -one),
    }
    faces = {}
    for name, (x, up, back) in y_up.items():
        azimuth = np.arctan2(-back, x)
        elevation = np.arctan2(up, np.hypot(x, back))
        column = ((0.5 - azimuth / (2 * np.pi)) * width).astype(int) % width
        faces[name] = picture[((0.5 + elevation / np.pi) * height).astype(int).clip(0, height - 1), column]
    return faces


@pytest.mark.parametrize("table", ["OPENGL", "GAMES202"])
@pytest.mark.parametrize("suffix", [".png", ".jpg", ".JPEG", "16.png"])
def test_encoded_faces(blender, part, scene, tmp_path, table, suffix):
    """Bytes are decoded as sRGB, or by the course's gamma, whatever Blender thinks of the file."""
    faces = noise()
    folder = write_encoded(tmp_path / "Sky", faces, suffix)
    if suffix in {".jpg", ".JPEG"}:
        faces = {name: np.asarray(Image.open(folder / f"{name}{suffix}")) for name in FACES}
    blender.ops.prt.import_cubemap(directory=str(folder), table=table)
    fraction = {name: face / 255 for name, face in faces.items()}
    if table == "GAMES202":
        linear = {name: x**2.2 for name, x in fraction.items()}
    else:
        linear = {n: np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4) for n, x in fraction.items()}
    wanted = part("cube_map").project_cubemap(linear, table)
    stored = part("light").read_light(scene.world)
    np.testing.assert_allclose(stored, wanted, rtol=0, atol=1e-5 * wanted.max())


@pytest.mark.parametrize("suffix", [".exr", ".hdr"])
def test_float_faces(blender, part, scene, stage, tmp_path, suffix):
    """Linear as they are, in both tables; .hdr keeps eight bits. They go before .png of the same names."""
    faces = hot_texel("posz", 16)
    folder = write_float(stage, tmp_path / "Sky", faces, suffix)
    for name, face in noise(8).items():
        Image.fromarray(face).save(folder / f"{name}.png")
    for table in ("OPENGL", "GAMES202"):
        blender.ops.prt.import_cubemap(directory=str(folder), table=table)
        wanted = part("cube_map").project_cubemap(faces, table)
        stored = part("light").read_light(scene.world)
        np.testing.assert_allclose(stored, wanted, rtol=0, atol=(1e-6 if suffix == ".exr" else 8e-3) * wanted.max())


@pytest.mark.parametrize("sky", [*FACES, "photographic"])
def test_light_is_what_blender_shows(blender, part, scene, stage, tmp_path, sky):
    """At five rotations, against Cycles' own panorama of the world that was set up, integrated by brute force.

    The bound is 1e-3 of the largest coefficient: Cycles interpolates between texels, which blurs a sun of one texel by
    1e-4 at this size.
    """
    from tests import panorama

    faces = photographic(part) if sky == "photographic" else hot_texel(sky)
    blender.ops.prt.import_cubemap(directory=str(write_float(stage, tmp_path / "Sky", faces)))
    mapping = scene.world.node_tree.nodes["Mapping"]
    for rotation in ROTATIONS:
        mapping.inputs["Rotation"].default_value = rotation
        shown = part("light").shown_light(scene.world)
        wanted = panorama.light_of_world(tmp_path / "world.exr", 256)
        assert np.abs(shown - wanted).max() < 1e-3 * np.abs(wanted).max(), rotation


def test_the_world_holds_the_light(blender, part, scene, stage, tmp_path):
    """Projecting the world again, as a bake does, after saving and loading, gives the light of the faces."""
    folder = write_float(stage, tmp_path / "Sky", hot_texel("negz", 32))
    blender.ops.prt.import_cubemap(directory=str(folder))
    before = part("light").read_light(scene.world)
    blender.ops.wm.save_as_mainfile(filepath=str(tmp_path / "sky.blend"))
    blender.ops.wm.open_mainfile(filepath=str(tmp_path / "sky.blend"))
    world = blender.context.scene.world
    assert part("light").remove_light(world)
    blender.ops.prt.project_light()
    after = part("light").read_light(world)
    np.testing.assert_allclose(after, before, rtol=0, atol=2e-4 * before.max())


def test_light_is_windowed_like_any_other(blender, part, scene, stage, tmp_path):
    """As given, or as the scene has it; and then it is fresh."""
    folder = write_float(stage, tmp_path / "Sky", hot_texel("negz", 16))
    blender.ops.prt.import_cubemap(directory=str(folder))
    whole = part("light").read_light(scene.world)
    factors = np.repeat(part("windowing").band_factors("HANN"), [1, 3, 5])[:, None]
    scene.prt.window = "HANN"
    for given in ({}, {"window": "NONE"}):
        blender.ops.prt.import_cubemap(directory=str(folder), **given)
        stored = part("light").read_light(scene.world)
        np.testing.assert_allclose(stored, whole if given else whole * factors, rtol=0, atol=1e-9)
        assert part("light_state").light_state(scene.world).text == "Light is fresh"


def test_size_of_the_panorama(blender, scene, tmp_path):
    """Twice the face, unless that is more than wanted."""
    folder = write_encoded(tmp_path / "Sky", noise(), ".png")
    for wanted, height in ((2048, 32), (20, 20)):
        blender.ops.prt.import_cubemap(directory=str(folder), max_height=wanted)
        texture = scene.world.node_tree.nodes["Environment Texture"]
        assert tuple(texture.image.size) == (2 * height, height)


def test_the_world_before_stays(blender, scene, stage, tmp_path):
    """With its light; the new one is named after the folder, and the faces themselves are not kept."""
    old, _ = stage.environment(stage.picture("Old", stage.six_coloured_sky(16)))
    blender.ops.prt.project_light()
    images = set(blender.data.images)
    blender.ops.prt.import_cubemap(directory=str(write_encoded(tmp_path / "Grace", noise(), ".png")))
    assert scene.world.name == "Grace" and old.use_fake_user and "prt_light_0" in old
    assert [image.name for image in set(blender.data.images) - images] == ["Grace"]
    assert blender.data.images["Grace"].packed_file


def _remove(folder):
    (folder / "negy.png").unlink()


def _resize(folder):
    Image.new("RGB", (8, 8)).save(folder / "posz.png")


def _stretch(folder):
    Image.new("RGB", (16, 8)).save(folder / "posz.png")


def _spoil(folder):
    (folder / "negx.png").write_bytes(b"This is no picture.")


def _empty(folder):
    (folder / "posx.png").write_bytes(b"")


REFUSALS = [
    (_remove, "lacks negy: a cube map is six pictures"),
    (_resize, "posz is 8 texels wide but posx is 16"),
    (_stretch, "posz is 16 x 8 texels: crop it to a square"),
    (_spoil, "negx.png"),
    (_empty, "posx.png"),
]


@pytest.mark.parametrize(("spoil", "message"), REFUSALS)
def test_refusals_leave_everything_as_it_was(blender, scene, stage, tmp_path, spoil, message):
    """One sentence about the face; no world, no image, no light."""
    world, _ = stage.environment(stage.picture("Old", stage.six_coloured_sky(16)))
    folder = write_encoded(tmp_path / "Sky", noise(), ".png")
    spoil(folder)
    images = set(blender.data.images)
    with pytest.raises(RuntimeError, match=message):
        blender.ops.prt.import_cubemap(directory=str(folder))
    assert scene.world == world and len(blender.data.worlds) == 1 and set(blender.data.images) == images
    assert not [key for key in world.keys() if key.startswith("prt_")]  # noqa: SIM118 - an ID is no dict


def test_broken_texels_and_folders_are_refused(blender, scene, stage, tmp_path):
    """NaN is named with its face; a missing folder with its path."""
    faces = hot_texel("posx", 8)
    faces["posy"][1, 2] = np.nan
    with pytest.raises(RuntimeError, match="posy holds NaN"):
        blender.ops.prt.import_cubemap(directory=str(write_float(stage, tmp_path / "Sky", faces)))
    with pytest.raises(RuntimeError, match=r"nowhere.*cannot be used"):
        blender.ops.prt.import_cubemap(directory=str(tmp_path / "nowhere"))


SCHEMES = [
    "px nx py ny pz nz",
    "right left top bottom front back",
    "sky_rt sky_lf sky_up sky_dn sky_ft sky_bk",
    "Studio-PosX Studio-NegX Studio-PosY Studio-NegY Studio-PosZ Studio-NegZ",
    "skyright skyleft skytop skybottom skyfront skyback",
    "x+ x- y+ y- z+ z-",
    "posx_4k negx_4k posy_4k negy_4k posz_4k negz_4k",
]


@pytest.mark.parametrize("names", SCHEMES)
def test_faces_by_all_usual_names(blender, part, scene, tmp_path, names):
    """What the sites that offer cube maps call them; another picture in the folder does no harm."""
    faces = noise()
    write_encoded(tmp_path / "plain", faces, ".png")
    renamed = write_encoded(tmp_path / "other", dict(zip(names.split(), faces.values(), strict=True)), ".png")
    Image.fromarray(faces["posx"]).save(renamed / "thumbnail.png")
    lights = []
    for folder in ("plain", "other"):
        blender.ops.prt.import_cubemap(directory=str(tmp_path / folder))
        lights.append(part("light").read_light(scene.world))
    np.testing.assert_array_equal(*lights)


def composed(faces, layout):
    """One picture of six faces, put together by hand."""
    size = len(faces["posx"])
    if layout == "cross":
        whole, places = np.zeros((3 * size, 4 * size, 3)), "posy 0 1 negx 1 0 posz 1 1 posx 1 2 negz 1 3 negy 2 1"
    elif layout == "upright cross":
        whole, places = np.zeros((4 * size, 3 * size, 3)), "posy 0 1 negx 1 0 posz 1 1 posx 1 2 negy 2 1 negz 3 1"
    else:
        whole, places = np.zeros((size, 6 * size, 3)), " ".join(f"{name} 0 {k}" for k, name in enumerate(FACES))
        if layout == "column":
            return composed(faces, "strip").reshape(size, 6, size, 3).swapaxes(0, 1).reshape(6 * size, size, 3)
    words = places.split()
    for name, row, column in zip(words[::3], map(int, words[1::3]), map(int, words[2::3]), strict=True):
        face = faces[name][::-1, ::-1] if (layout, name) == ("upright cross", "negz") else faces[name]
        whole[row * size : (row + 1) * size, column * size : (column + 1) * size] = face
    return whole


@pytest.mark.parametrize("layout", ["cross", "upright cross", "strip", "column"])
def test_one_picture_with_all_faces(blender, part, scene, tmp_path, layout):
    faces = noise()
    write_encoded(tmp_path / "six", faces, ".png")
    Image.fromarray(composed(faces, layout).astype(np.uint8)).save(tmp_path / "whole.png")
    lights = []
    for given in ({"directory": str(tmp_path / "six")}, {"filepath": str(tmp_path / "whole.png")}):
        blender.ops.prt.import_cubemap(**given)
        lights.append(part("light").read_light(scene.world))
    np.testing.assert_array_equal(*lights)
    assert scene.world.name == "whole"


@pytest.mark.parametrize("layout", ["cross", "upright cross"])
def test_crosses_have_no_seams(part, layout):
    """A smooth sky is smooth across the edges at which faces of a cross meet: they lie as they fold."""
    size = 32
    v, u = np.meshgrid(*[(np.arange(size) + 0.5) / size * 2 - 1] * 2, indexing="ij")
    faces = {}
    for name, table in zip(FACES, part("cube_map")._TABLES["OPENGL"], strict=True):
        right, down, middle = table
        directions = u[..., None] * right + v[..., None] * down + middle
        directions /= np.linalg.norm(directions, axis=-1, keepdims=True)
        faces[name] = directions @ np.array([[1.0, 0.2, -0.4], [0.3, -1.0, 0.5], [-0.2, 0.6, 1.0]])
    whole = composed(faces, layout)
    filled = composed({name: np.ones_like(face) for name, face in faces.items()}, layout) > 0
    for axis in (0, 1):
        step = np.abs(np.diff(whole, axis=axis))
        both = filled.take(range(1, whole.shape[axis]), axis) & filled.take(range(whole.shape[axis] - 1), axis)
        assert step[both].max() < 3.0 * 2.0 / size


def test_a_picture_that_is_no_cube_map_is_refused(blender, scene, tmp_path):
    Image.fromarray(np.zeros((10, 30, 3), dtype=np.uint8)).save(tmp_path / "wide.png")
    with pytest.raises(RuntimeError, match="30 x 10 is no cube map"):
        blender.ops.prt.import_cubemap(filepath=str(tmp_path / "wide.png"))
