# SPDX-License-Identifier: GPL-3.0-or-later
"""GAMES202 files through the operators: what is written, that it comes back, and what is refused."""

import numpy as np
import pytest


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
    stored = part("scene.transport_layers").read(mesh)[mesh.loop_triangles[0].loops[0]].mean(axis=1)
    basis = part("core.sh").basis
    turn = np.array(Euler((0.3, -0.4, 1.2)).to_matrix())
    for direction in np.random.default_rng(5).normal(size=(8, 3)):
        direction /= np.linalg.norm(direction)
        theirs = y_up_condon_shortley(direction)
        sky = 2.0 * basis(turn @ direction) @ part("scene.light").read_light(scene.world)
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
    before = part("scene.transport_layers").read(baked.data).mean(axis=2)
    blender.ops.prt.export_games202(directory=str(tmp_path))
    header, *rows = (tmp_path / "transport.txt").read_text().splitlines()
    scaled = [" ".join(f"{float(number) * np.pi:.6g}" for number in row.split()) for row in rows]
    (tmp_path / "transport.txt").write_text("\n".join([header, *scaled]) + "\n")
    blender.ops.prt.import_games202(directory=str(tmp_path))
    np.testing.assert_allclose(part("scene.transport_layers").read(baked.data).mean(axis=2), before, atol=2e-6)


def test_refusals_leave_everything_as_it_was(blender, part, scene, stage, baked, tmp_path):
    """Another mesh's file names both counts; a missing folder is said; the bake and the light stay."""
    blender.ops.prt.export_games202(directory=str(tmp_path))
    before = part("scene.transport_layers").read(baked.data)
    text = (tmp_path / "transport.txt").read_text()
    (tmp_path / "transport.txt").write_text("\n".join(text.splitlines()[:-1]) + "\n")
    with pytest.raises(RuntimeError, match=r"35 rows.*36 face corners"):
        blender.ops.prt.import_games202(directory=str(tmp_path))
    with pytest.raises(RuntimeError, match=r"nowhere.*cannot be used"):
        blender.ops.prt.import_games202(directory=str(tmp_path / "nowhere"))
    assert np.array_equal(part("scene.transport_layers").read(baked.data), before)
    assert scene.world.animation_data.drivers
    blender.ops.prt.remove()
    with pytest.raises(RuntimeError, match="not baked"):
        blender.ops.prt.export_games202(directory=str(tmp_path))
