# SPDX-License-Identifier: GPL-3.0-or-later
"""The ray caster gives what geometry says, and steps into none of embreex's traps."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from prt_addon.core.errors import MeshError, RayCasterMissing
from prt_addon.core.surface import Opacity, TexturePatch
from prt_addon.core.transport import raycast
from prt_addon.core.transport.raycast import RayScene
from tests.core import shapes
from tests.core.references import random_directions


def rays(origin, directions):
    """Rays from one point, as the scene wants them."""
    directions = np.ascontiguousarray(directions, dtype=np.float32)
    return np.tile(np.float32(origin), (len(directions), 1)), directions


def zeros(*shape, dtype=np.float32):
    """Rays of a wrong shape or type."""
    return np.zeros(shape, dtype=dtype)


WRONG = {
    "fewer origins": (zeros(1, 3), zeros(4, 3)),
    "fewer directions": (zeros(4, 3), zeros(1, 3)),
    "float64 origins": (zeros(4, 3, dtype=np.float64), zeros(4, 3)),
    "float64 directions": (zeros(4, 3), zeros(4, 3, dtype=np.float64)),
    "two columns": (zeros(4, 2), zeros(4, 2)),
    "one ray, flat": (zeros(3), zeros(3)),
    "transposed": (zeros(3, 4).T, zeros(4, 3)),
    "strided": (zeros(4, 3), zeros(8, 3)[::2]),
}


@pytest.mark.parametrize("query", ["visible", "hits"])
@pytest.mark.parametrize("wrong", WRONG.values(), ids=WRONG.keys())
def test_wrong_rays_are_refused(wrong, query):
    """embreex reads past the end of such arrays: the interpreter dies, or one ray's answer is given for all."""
    with pytest.raises(ValueError, match=r"rays must be|origins for"):
        getattr(RayScene(*shapes.box()), query)(*wrong)


def test_no_rays():
    """An object without vertices casts none."""
    scene = RayScene(*shapes.box())
    assert scene.visible(zeros(0, 3), zeros(0, 3)).shape == (0,)
    assert scene.hits(zeros(0, 3), zeros(0, 3)).triangle.shape == (0,)


def test_visible_agrees_with_hits_and_with_geometry():
    """A square overhead hides the directions whose line through its plane lies inside it."""
    scene = RayScene(*shapes.grid(4, size=2.0))
    directions = random_directions(4000)
    below = scene.normalised(np.array([0.1, 0.2, -1.0]))
    at_plane = np.array([0.1, 0.2]) + directions[:, :2] / directions[:, 2:]
    blocked = (directions[:, 2] > 0) & (np.abs(at_plane) < 1).all(axis=1)
    assert 100 < blocked.sum() < 2000
    assert np.array_equal(scene.visible(*rays(below, directions)), ~blocked)
    assert np.array_equal(scene.hits(*rays(below, directions)).triangle >= 0, blocked)


def test_hits_tell_triangle_and_barycentrics():
    """Corner 0 weighs 1 - u - v: bounces read the light of the right corners."""
    vertices, triangles = shapes.bumpy_sphere(2)
    scene = RayScene(vertices, triangles)
    origins, directions = rays(scene.normalised(np.zeros(3)), random_directions(500))
    hits = scene.hits(origins, directions)
    assert (hits.triangle >= 0).all()
    corners = scene.normalised(vertices)[triangles[hits.triangle]]
    weights = np.stack([1 - hits.u - hits.v, hits.u, hits.v], axis=1)
    assert (weights > -1e-5).all()
    points = np.einsum("nc,nck->nk", weights, corners)
    towards = (points - origins) / np.linalg.norm(points - origins, axis=1, keepdims=True)
    assert np.allclose(towards, directions, rtol=0, atol=1e-5)


@pytest.mark.parametrize(("mesh", "faces"), [(shapes.box(), 12), (shapes.icosphere(1), 80)])
def test_front_is_counter_clockwise(mesh, faces):
    """From outside all are fronts, from inside all are backs: the sign of Ng has changed between Embree's versions."""
    scene = RayScene(*mesh)
    outward = random_directions(500)
    origins, directions = rays(scene.normalised(np.zeros(3)), outward)
    inside, outside = scene.hits(origins, directions), scene.hits(origins + 3 * directions, -directions)
    assert len(np.unique(inside.triangle)) == len(np.unique(outside.triangle)) == faces
    assert not inside.front.any()
    assert outside.front.all()


def test_a_miss_is_no_front():
    """Rays into the void have no face at all."""
    hits = RayScene(*shapes.box()).hits(*rays((5, 0, 0), [(1, 0, 0)]))
    assert hits.triangle[0] == -1 and not hits.front[0]


def test_edges_are_tight():
    """Rays aimed exactly at shared edges do not slip through; without embreex's `robust`, 3 % of them do."""
    vertices, triangles = shapes.icosphere(4)
    scene = RayScene(vertices, triangles)
    share = np.random.default_rng(0).random((len(triangles), 1))
    targets = scene.normalised(share * vertices[triangles[:, 0]] + (1 - share) * vertices[triangles[:, 1]])
    leaks = [scene.visible(*rays(origin, targets - np.float32(origin))) for origin in random_directions(10) * 0.5]
    assert np.mean(leaks) < 0.005


@pytest.mark.parametrize("scale", [1e-4, 1.0, 1e4])
@pytest.mark.parametrize("place", [0.0, 1e5])
def test_far_and_tiny_scenes(scale, place):
    """A model a tenth of a millimetre in size, 100 km out, casts the same shadows: in float32 it would be one point."""
    vertices, triangles = shapes.torus()
    offset = np.array([place, -place, place / 3])
    here, there = RayScene(vertices, triangles), RayScene(vertices * scale + offset, triangles)
    directions = random_directions(2000)
    point = np.array([0.3, 0.1, 0.2])
    expected = here.visible(*rays(here.normalised(point), directions))
    got = there.visible(*rays(there.normalised(point * scale + offset), directions))
    assert 200 < expected.sum() < 1800
    assert np.mean(expected != got) <= 0.001


def test_normalised_is_about_a_unit_sphere():
    """Whatever comes in; the directions of rays stay as they are, since nothing is turned or stretched."""
    vertices = shapes.torus()[0] * 300 + (7, 8, 9)
    unit = RayScene(vertices, shapes.torus()[1]).normalised(vertices)
    assert 0.5 < np.linalg.norm(unit, axis=1).max() <= 2
    ratios = np.linalg.norm(np.diff(unit, axis=0), axis=1) / np.linalg.norm(np.diff(vertices, axis=0), axis=1)
    assert np.allclose(ratios, ratios[0], rtol=1e-9)


def test_skips_follow_the_object_between_limits():
    """A share of the object's size; never below what float32 resolves there, nor above what a lone object skips."""
    scene = RayScene(shapes.box()[0] * 50, shapes.box()[1])
    middle, rim = np.zeros((1, 3)), np.array([[0.6, 0.0, 0.8]])
    assert np.isclose(scene.radius, 50 * np.sqrt(3))
    for place in (middle, rim):
        assert scene.skips(place, scene.radius) == pytest.approx([1e-4])
        assert scene.skips(place, scene.radius / 4) == pytest.approx([0.25e-4])
        assert scene.skips(place, scene.radius * 10) == pytest.approx([1e-4])
    assert scene.skips(rim, 0.0) == pytest.approx([1e-5])
    assert scene.skips(middle, scene.radius / 1e6) == pytest.approx([1e-10])


def test_scene_of_one_point():
    """Faces collapsed onto a point, as a build-up animation starts with, divide nothing by zero."""
    scene = RayScene(np.full((3, 3), 5.0), np.array([[0, 1, 2]], dtype=np.int32))
    assert np.isfinite(scene.normalised(np.full((1, 3), 5.0))).all()
    assert scene.visible(*rays((0.5, 0, 0), [(0, 0, 1)])).all()


def test_nothing_to_cast_at():
    """What blocks nothing may still receive: all rays leave."""
    scene = RayScene(np.zeros((3, 3)), np.zeros((0, 3), dtype=np.int32))
    assert scene.visible(*rays((0, 0, 0), [(0, 0, 1), (1, 0, 0)])).all()
    assert (scene.hits(*rays((0, 0, 0), [(0, 0, 1)])).triangle == -1).all()


def test_light_passes_one_sided_backs():
    """Through any number of them, up to what stands behind; from the front they block, and so do two-sided backs."""
    layers = [(z, 1.0) for z in (1.0, 1.5, 1.5, 2.0)] + [(3.0, -1.0)]
    corners = np.array([(-9, -9, 0), (9, -9, 0), (0, 9, 0)], dtype=np.float64)
    vertices = np.concatenate([corners + np.array([0, 0, z]) for z, _ in layers])
    triangles = np.arange(len(vertices), dtype=np.int32).reshape(-1, 3)
    triangles[-1] = triangles[-1, ::-1]  # looks down
    one_sided = np.array([True, True, True, True, False])

    def hits(height, direction, count=5, sides=None):
        scene = RayScene(vertices[: 3 * count], triangles[:count], one_sided=sides)
        start = tuple(scene.normalised(np.array([0.0, 0.0, height])))
        found, free = (
            getattr(scene, query)(*rays(start, [direction, (0.1, 0.1, direction[2])])) for query in ("hits", "visible")
        )
        assert ((found.triangle < 0) == free).all() and len(set(found.triangle)) == 1
        return found.triangle[0], bool(found.front[0])

    up, down = (0, 0, 1), (0, 0, -1)
    assert hits(0.0, up) == (0, False)
    assert hits(0.0, up, sides=one_sided) == (4, True) and hits(2.5, down, sides=one_sided) == (3, True)
    assert hits(0.0, up, 4, one_sided[:4])[0] == -1
    one_sided[3] = False
    assert hits(0.0, up, sides=one_sided) == (3, False)


def pane(opacity, height=1.0, panes=1):
    """Squares above each other, far wider than high, that stop a share of the light."""
    sheets = [shapes.grid(1, size=400.0) for _ in range(panes)]
    vertices = np.concatenate([points + np.array([0, 0, height + 0.1 * k]) for k, (points, _) in enumerate(sheets)])
    triangles = np.concatenate([faces + 4 * k for k, (_, faces) in enumerate(sheets)]).astype(np.int32)
    return RayScene(vertices, triangles, opacity=Opacity(np.full((len(triangles), 1), opacity)))


@pytest.mark.parametrize("panes", [1, 2, 5])
def test_panes_let_their_share_through(panes):
    """Each on its own: light behind n panes is the n-th power of what one lets through. Whatever is looked up together."""
    scene, directions = pane(0.4, panes=panes), random_directions(60000, seed=3)
    directions[:, 2] = np.abs(directions[:, 2]) + 0.05
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    origins, directions = rays(tuple(scene.normalised(np.zeros(3))), directions)
    free = scene.visible(origins, directions)
    deviation = np.sqrt(0.6**panes * (1.0 - 0.6**panes) / len(free))
    assert free.mean() == pytest.approx(0.6**panes, abs=4.0 * deviation)
    for part in (slice(0, 7), slice(7, 50000), slice(50000, None)):
        assert (scene.visible(origins[part], directions[part]) == free[part]).all()


@pytest.mark.parametrize(("opacity", "passes"), [(0.0, True), (1.0, False), (np.nan, True)])
def test_the_ends_are_exact(opacity, passes):
    """Nothing that is whole leaks, and nothing that is not there blocks."""
    scene = pane(opacity)
    start = tuple(scene.normalised(np.zeros(3)))
    assert (
        scene.visible(*rays(start, [(0.3 * np.cos(a), 0.3 * np.sin(a), 0.9539392) for a in range(999)])) == passes
    ).all()


def test_a_picture_cuts_out():
    """A ray passes where the picture's alpha is 0, and hits where it is 1; what stands behind is found through the holes."""
    vertices, triangles = shapes.joined(shapes.grid(1), (shapes.grid(1)[0] + np.array([0, 0, 1.0]), shapes.grid(1)[1]))
    uv = (vertices[triangles[:2]][..., :2] / 2.0 + 0.5).astype(np.float32)
    squares = (np.indices((4, 4)).sum(axis=0) % 2).astype(np.float32)[..., None]
    patch = TexturePatch(np.arange(2), uv, squares, "Closest")
    scene = RayScene(vertices, triangles, opacity=Opacity(np.ones((4, 1)), (patch,)))
    x, y = (np.indices((4, 4)).reshape(2, -1) + 0.5) / 2.0 - 1.0
    above = scene.normalised(np.stack([x, y, np.full(16, -1.0)], axis=-1)).astype(np.float32)
    hits = scene.hits(above, np.tile(np.array([0, 0, 1], dtype=np.float32), (16, 1)))
    stopped = squares[(np.arange(16) % 4), (np.arange(16) // 4), 0] > 0.5
    assert ((hits.triangle < 2) == stopped).all() and (hits.triangle >= 0).all()


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_broken_coordinates(bad):
    """They would make the whole scene NaN."""
    vertices, triangles = shapes.box()
    vertices[3, 1] = bad
    with pytest.raises(MeshError, match="NaN"):
        RayScene(vertices, triangles)


def test_without_the_ray_caster():
    """The module imports where embreex is not installed; only casting says what to do."""
    root = Path(__file__).resolve().parents[3]
    code = (
        f"import sys; sys.path.insert(0, {str(root)!r}); sys.modules['embreex'] = None\n"
        "from prt_addon.core import errors\n"
        "from prt_addon.core.transport import raycast\n"
        "print(raycast.is_available())\n"
        "try: raycast.require()\n"
        "except errors.RayCasterMissing as error: print(error)\n"
    )
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert answer.startswith("False\n")
    assert "Unshadowed" in answer


def test_missing_ray_caster_is_told_before_bad_meshes(monkeypatch):
    """A scene cannot be built without it."""
    assert raycast.is_available()
    monkeypatch.setattr(raycast, "EmbreeScene", None)
    with pytest.raises(RayCasterMissing):
        RayScene(*shapes.box())
