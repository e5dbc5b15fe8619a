# SPDX-License-Identifier: GPL-3.0-or-later
"""The viewer of docs/examples/games202 draws the pixels that NumPy does, whichever way the sky is turned."""

import numpy as np
import pytest

from tests.core.references import axis_angle, order2, sphere_quadrature
from tests.games202.probes import FLOATS, SCRIPTS, SIZE, STEP, probed
from tests.games202.traced import SIGNS, first_hits, rays_of_pixels, shown, triangles_of

TURNS = [np.eye(3), axis_angle((0, 1, 0), 1.0), axis_angle((1, 0, 0), 2.0), axis_angle((1, 2, -3), 2.5)]
MESH_PROBE = f"""{SCRIPTS}<script>
async function run() {{
  const gl = floatTarget(SIZE, SIZE), viewer = new Viewer(gl);
  await read(viewer);
  const pictures = TURNS.map((turn) => {{
    viewer.turn = turn;
    viewer.draw(SIZE, SIZE, false);
    return pixelsOf(gl, SIZE, SIZE, STEP);
  }});
  return {{ ...viewer.camera.place(), pictures }};
}}
post(run());
</script>"""


def ball_over_a_floor(bm):
    """One mesh, so that the floor has a shadow."""
    import bmesh

    bmesh.ops.create_icosphere(bm, subdivisions=3, radius=0.7)
    bmesh.ops.translate(bm, verts=bm.verts, vec=(0.0, 0.0, 0.4))
    floor = bmesh.ops.create_grid(bm, x_segments=6, y_segments=6, size=1.2)["verts"]
    bmesh.ops.translate(bm, verts=floor, vec=(0.0, 0.0, -0.5))
    bmesh.ops.triangulate(bm, faces=bm.faces)


def turned_light(light, turn):
    """The light of the turned sky, by projecting what is seen along every direction before it was turned."""
    directions, weights = sphere_quadrature(6)
    seen = (order2(directions @ turn) * SIGNS) @ light  # rows times R: R^T of each
    return (order2(directions) * SIGNS * weights[:, None]).T @ seen


def ray_traced(triangles, colours, eye, axes):
    """(rows, columns, 4) what the compared pixels' rays meet first, transparent where that is nothing."""
    rays = rays_of_pixels(axes)
    distance, *met = first_hits(triangles, np.broadcast_to(eye, (rays.size // 3, 3)), rays.reshape(-1, 3))
    covered = np.isfinite(distance)[:, None]
    found = np.concatenate([shown(colours, *met), np.ones_like(covered)], axis=1)
    return np.where(covered, found, 0.0).reshape(*rays.shape[:2], 4)


@pytest.mark.once
def test_pixels_are_numpys(browser, served, exported):
    """At four turns, about other axes than the slider's, too; but for pixels on an edge, which two rasterisers may give away."""
    folder = exported(ball_over_a_floor, SHADOWED=".")
    turns = [turn.tolist() for turn in TURNS]
    found = probed(browser, served, FLOATS + MESH_PROBE, SIZE=SIZE, STEP=STEP, TURNS=turns)
    triangles, light = triangles_of(folder / "figure.obj"), np.loadtxt(folder / "light.txt")
    transport = np.loadtxt(folder / "transport.txt", skiprows=1)
    pictures = []
    for turn, pixels in zip(TURNS, found["pictures"], strict=True):
        colours = (transport @ turned_light(light, turn)).reshape(-1, 3, 3)
        expected = ray_traced(triangles, colours, np.array(found["eye"]), np.array(found["axes"]))
        ours = np.array(pixels).reshape(expected.shape)
        off = np.abs(ours - expected).max(axis=-1) > 1e-3
        assert expected[..., 3].mean() > 0.15 and 0.8 < expected[..., :3].max() < 1.5
        assert off.mean() < 0.005, f"{off.sum()} pixels, by {np.abs(ours - expected).max()}"
        pictures.append(ours)
    assert all(np.abs(other - pictures[0]).max() > 0.1 for other in pictures[1:]), "the turns would be noticed"
