# SPDX-License-Identifier: GPL-3.0-or-later
"""Direct transport is that of closed forms and brute force, and the same however it is cut into pieces."""

import numpy as np
import pytest

from prt_addon.core.errors import Cancelled
from prt_addon.core.monitor import Work
from prt_addon.core.sphere import sh
from prt_addon.core.transport import direct as transport
from prt_addon.core.transport.direct import Receivers, shadowed, unshadowed
from prt_addon.core.transport.raycast import RayScene
from prt_addon.core.workers import Workers
from tests.core import shapes
from tests.core.baking import Noting
from tests.core.references import axis_angle, hemisphere_quadrature, order2, random_directions

OPEN = 0.28209479177387814  # T_0 of a receiver that sees the whole sky: sqrt(1 / 4pi)


def receivers(scene, points, normals):
    """Receivers of an object as large as the scene."""
    count = len(points)
    places = scene.normalised(points)
    return Receivers(places, normals, np.arange(count), scene.skips(places, scene.radius))


def one_receiver(mesh, normal, samples, turn=None):
    """Transport at the origin under a mesh, both turned."""
    turn = np.eye(3) if turn is None else turn
    scene = RayScene(mesh[0] @ turn.T, mesh[1])
    return shadowed(scene, receivers(scene, np.zeros((1, 3)), (turn @ normal)[None]), samples)[0]


def brute_force(normal, sees, points=200):
    """The integral itself: 1/pi V cos Y over the hemisphere."""
    directions, weights = hemisphere_quadrature(normal, points)
    weights = weights * (directions @ normal) * sees(directions) / np.pi
    return weights @ order2(directions)


def self_shadowing(subdivisions=2):
    """Scene and receivers of a mesh that shadows itself."""
    vertices, triangles = shapes.bumpy_sphere(subdivisions)
    scene = RayScene(vertices, triangles)
    return scene, receivers(scene, vertices, shapes.vertex_normals(vertices, triangles))


@pytest.mark.parametrize("normal", [(0, 0, 1), (0, 0, -1), (1, 0, 0), *random_directions(4)])
def test_unshadowed_is_the_integral(normal):
    """The closed form, yardstick of all that follows, agrees with brute force."""
    normal = np.array(normal, dtype=float)
    expected = brute_force(normal, lambda directions: 1.0, points=20)
    assert np.allclose(unshadowed(normal[None])[0], expected, rtol=0, atol=5e-8)


def test_unshadowed_shows_a_constant_sky():
    """A white receiver under a white sky is white: no forgotten pi."""
    result = unshadowed(random_directions(10))
    assert result.dtype == np.float32 and result.shape == (10, 9)
    assert np.allclose(result[:, 0] * np.sqrt(4 * np.pi), 1, rtol=1e-6)


def test_convex_mesh_is_unshadowed():
    """Nothing on a sphere hides the sky from its vertices: equal within float32's rounding, 1e-7."""
    vertices, triangles = shapes.icosphere(4)
    scene = RayScene(vertices, triangles)
    result = shadowed(scene, receivers(scene, vertices, vertices), 128)
    assert np.allclose(result, unshadowed(vertices), rtol=0, atol=1e-7)


def test_enclosed_receiver_gets_exactly_nothing():
    """A closed box leaks no light at all: not between triangles, not by the correction of the table."""
    mesh = shapes.joined(shapes.box(), shapes.icosphere(3))
    scene = RayScene(mesh[0] * (1.5, 1.0, 2.0), mesh[1])
    normals = random_directions(50)
    result = shadowed(scene, receivers(scene, random_directions(50, 5) * 0.5, normals), 1024)
    assert not result.any()


def wall(distance=1.0, size=4000.0):
    """A wall across +x, so large that it hides all but 1e-3 of the half of the sky behind it."""
    vertices, triangles = shapes.grid(1, size)
    return vertices[:, [2, 0, 1]] + (distance, 0, 0), triangles


TURNS = [np.eye(3), axis_angle((1, 2, 3), 1.1), axis_angle((-1, 0.3, 0), 2.5)]


def test_wall_halves_the_sky():
    """Closed form for V = [x < 0] under a normal of +z; only x-odd coefficients beside half of the open ones."""
    expected = np.zeros(9)
    expected[0] = OPEN / 2
    expected[2] = np.sqrt(3 / (4 * np.pi)) / 3
    expected[3] = -np.sqrt(3 / (4 * np.pi)) * 2 / (3 * np.pi)
    expected[6] = np.sqrt(5 / (16 * np.pi)) / 4
    expected[7] = -np.sqrt(15 / (4 * np.pi)) / 8
    result = one_receiver(wall(), np.array([0.0, 0.0, 1.0]), 16384)
    assert np.allclose(result, expected, rtol=0, atol=5e-4)


@pytest.mark.parametrize("turn", TURNS)
@pytest.mark.parametrize("normal", random_directions(3, 11))
def test_wall_beside_a_tilted_receiver(normal, turn):
    """The same by brute force, in any position: the turn into the world and the cosine's side are right."""
    expected = brute_force(turn @ normal, lambda directions: directions @ turn[:, 0] < 0)
    assert np.allclose(one_receiver(wall(), normal, 16384, turn), expected, rtol=0, atol=5e-4)


@pytest.mark.parametrize("turn", TURNS)
@pytest.mark.parametrize("angle", [0.3, 0.8, 1.3])
def test_roof_leaves_a_ring_of_sky(angle, turn):
    """Under a disc of half-angle a, what is left is zonal: cos**2 of the constant, 2/3 cos**3 of band 1, and so on."""
    c = np.cos(angle)
    zonal = np.array([c**2, 2 / 3 * c**3, (3 * c**4 - 2 * c**2) / 4])
    normal = turn[:, 2]
    expected = order2(normal) * np.repeat(zonal, [1, 3, 5])
    result = one_receiver(shapes.disc(np.tan(angle), 1.0), np.array([0.0, 0.0, 1.0]), 16384, turn)
    assert np.allclose(result, expected, rtol=0, atol=1e-4)


def test_shadow_falls_on_the_right_receiver():
    """Rays are receiver-major: of three receivers only the one in the box is dark."""
    vertices, triangles = shapes.box()
    scene = RayScene(np.concatenate([vertices, [[-9.0, 0, 0], [9.0, 0, 0]]]), triangles)
    points, normals = np.array([[-5.0, 0, 0], [0, 0, 0], [5.0, 0, 0]]), np.array([[-1.0, 0, 0], [0, 0, 1], [1, 0, 0]])
    result = shadowed(scene, receivers(scene, points, normals), 64)
    assert np.allclose(result, unshadowed(normals) * [[1], [0], [1]], rtol=0, atol=1e-7)


def test_noise():
    """Random directions instead of the turned Fibonacci set would be five times over these bounds."""
    scene, points = self_shadowing(3)
    reference = shadowed(scene, points, 16384, seed=99)
    assert reference[:, 0].mean() < 0.8 * OPEN  # a mesh with shadows to sample
    for samples, bound in ((256, 0.025), (1024, 0.009)):
        error = shadowed(scene, points, samples) - reference
        relative = np.sqrt(np.mean(error**2) / np.mean(reference**2))
        assert 0.001 < relative <= bound, (samples, relative)


def test_noise_averages_out_over_seeds():
    """Seeds are independent and unbiased: the mean of 16 bakes is nearly four times as good as one."""
    scene, points = self_shadowing()
    reference = shadowed(scene, points, 16384, seed=99)
    bakes = np.array([shadowed(scene, points, 64, seed) for seed in range(16)])
    one, mean = np.sqrt(np.mean((bakes - reference) ** 2)), np.sqrt(np.mean((bakes.mean(axis=0) - reference) ** 2))
    assert mean < one / 3.2


@pytest.mark.parametrize("rays_at_a_time", [1, 100, 1000, 1 << 30])
@pytest.mark.parametrize("threads", [1, 3])
def test_bits_do_not_depend_on_chunks_or_threads(monkeypatch, rays_at_a_time, threads):
    """So that bakes of a farm, or of another machine, can be merged and compared."""
    scene, points = self_shadowing()
    expected = shadowed(scene, points, 100)
    monkeypatch.setattr(transport, "_RAYS_AT_A_TIME", rays_at_a_time)
    chunk = transport.RayPattern(100, 0).chunk
    assert chunk == max(1, rays_at_a_time // 100)
    assert np.array_equal(shadowed(scene, points, 100, workers=Workers(threads)), expected)


def test_bits_do_not_depend_on_the_order_of_receivers():
    """Nor on which others there are: a receiver is known by its id."""
    scene, points = self_shadowing()
    expected = shadowed(scene, points, 100)
    order = np.random.default_rng(4).permutation(len(points))[:77]
    some = Receivers(points.points[order], points.normals[order], points.ids[order], points.skips[order])
    assert np.array_equal(shadowed(scene, some, 100), expected[order])


def test_seed_and_id_change_the_noise():
    """A seed is another pattern; two receivers at one place do not share theirs."""
    scene, points = self_shadowing()
    expected = shadowed(scene, points, 100)
    others = Receivers(points.points, points.normals, points.ids + 1000, points.skips)
    for other in (shadowed(scene, points, 100, seed=1), shadowed(scene, others, 100)):
        changed = (other != expected).any(axis=1)
        assert changed.mean() > 0.5
        assert np.allclose(other, expected, rtol=0, atol=0.1)


def test_far_and_tiny_meshes_bake_the_same():
    """Units and places are the artist's business: the same mesh 1e-4 in size and 1e5 away."""
    vertices, triangles = shapes.bumpy_sphere(2)
    normals = shapes.vertex_normals(vertices, triangles)
    results = []
    for placed in (vertices, vertices * 1e-4, vertices + np.array([1e5, -1e5, 1e5])):
        scene = RayScene(placed, triangles)
        results.append(shadowed(scene, receivers(scene, placed, normals), 256))
    difference = np.array(results[1:]) - results[0]
    assert np.sqrt(np.mean(difference**2) / np.mean(results[0] ** 2)) < 1e-3


def test_transport_obeys_the_bounds_of_light():
    """A receiver cannot see more than the whole sky, nor less than none."""
    scene, points = self_shadowing()
    result = shadowed(scene, points, 256)
    assert result.dtype == np.float32 and result.shape == (len(points), 9)
    assert np.isfinite(result).all()
    assert result[:, 0].min() >= 0 and result[:, 0].max() <= OPEN * (1 + 1e-6)


def test_every_ray_is_told():
    """The progress bar ends at 100 %."""
    scene, points = self_shadowing()
    monitor = Noting()
    shadowed(scene, points, 100, workers=Workers(monitor=monitor))
    assert monitor.done == Work(rays=100 * len(points))


def test_cancel_comes_out():
    """Nothing half-done is returned."""

    def stop():
        raise Cancelled("stop")

    scene, points = self_shadowing()
    with pytest.raises(Cancelled, match="stop"):
        shadowed(scene, points, 100, workers=Workers(monitor=Noting(stop)))


@pytest.mark.parametrize("samples", [1, 2, 64, 256])
def test_table_sums_exactly(samples):
    """The whole table is the closed form of an open sky, in whole numbers that add without rounding."""
    table = transport._exact_table(samples)
    assert np.array_equal(table, np.rint(table))
    assert np.abs(table).max() * 16384 < 2**53
    mean = table.sum(axis=0) / (2.0**30 * samples)
    expected = order2([0, 0, 1]) * np.repeat([1, 2 / 3, 1 / 4], [1, 3, 5])
    assert np.allclose(mean, expected, rtol=0, atol=2.0**-30)
    assert sh.coefficient_count(sh.ORDER) == table.shape[1]
