# SPDX-License-Identifier: GPL-3.0-or-later
"""Light that is traced on the screen is NumPy's: a mirror floor, and the light that a box and its floor exchange."""

import numpy as np
import pytest

from tests.core.references import order2
from tests.games202.probes import FLOATS, SCRIPTS, SIZE, STEP, probed
from tests.games202.traced import FIELD_OF_VIEW, SIGNS, first_hits, rays_of_pixels, shown, triangles_of

COLOUR = np.array([0.8, 0.7, 0.6])
"""Of the box and its floor."""
REFLECTION_PROBE = f"""{SCRIPTS}<script src="gbuffer.js"></script><script src="reflection.js"></script><script>
async function run() {{
  const gl = floatTarget(SIZE, SIZE, "webgl2"), reflection = new Reflection(gl), pictures = {{}};
  reflection.floorOnly = true;
  reflection.samples = RAYS;
  reflection.camera.elevation = 0.4;
  for (const [name, mode, folder] of [["direct", "direct", "."], ["mirror", "mirror", "."], ["indirect", "indirect", "."], ["bounced", "direct", "bounced"]]) {{
    await read(reflection, folder);
    reflection.mode = mode;
    reflection.draw(SIZE, SIZE, false);
    pictures[name] = pixelsOf(gl, SIZE, SIZE, STEP);
  }}
  return {{ ...reflection.camera.place(), pictures }};
}}
post(run());
</script>"""


def box_on_a_floor(bm):
    """Turned, so that two of its sides are seen, and mirrored."""
    import bmesh
    from mathutils import Matrix

    bmesh.ops.create_grid(bm, x_segments=8, y_segments=8, size=1.0)
    placed = Matrix.Translation((0.1, 0.2, 0.4)) @ Matrix.Rotation(0.6, 4, "Z") @ Matrix.Scale(0.8, 4)
    bmesh.ops.create_cube(bm, size=1.0, matrix=placed)
    bmesh.ops.triangulate(bm, faces=bm.faces)


class Seen:
    """The box on its floor as NumPy traces it, and what of its light the browser's camera sees."""

    def __init__(self, folder, eye, axes):
        self.triangles, self.light = triangles_of(folder / "figure.obj"), np.loadtxt(folder / "light.txt")
        transport = np.loadtxt(folder / "transport.txt", skiprows=1)
        self.colours = COLOUR * (transport @ self.light).reshape(-1, 3, 3)
        self.eye, self.axes = np.array(eye), np.array(axes)
        rays = rays_of_pixels(self.axes).reshape(-1, 3)
        distance, self.hit, self.weights = first_hits(self.triangles, np.broadcast_to(self.eye, rays.shape), rays)
        self.covered, self.rays = np.isfinite(distance), rays
        self.places = self.eye + np.where(self.covered, distance, 0.0)[:, None] * rays
        corners = self.triangles[self.hit]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        self.normals = normals / np.linalg.norm(normals, axis=-1, keepdims=True)

    def along(self, places, directions):
        """(N, 3) light from there, and whether the camera sees what sends it; (N,) whether nothing is there."""
        distance, hit, weights = first_hits(self.triangles, places, directions)
        leaves = ~np.isfinite(distance)
        back = places + np.where(leaves, 0.0, distance)[:, None] * directions - self.eye
        far = np.maximum(np.linalg.norm(back, axis=-1), 1e-9)
        nearest, *_ = first_hits(self.triangles, np.broadcast_to(self.eye, back.shape), back / far[:, None])
        in_view = back @ self.axes.T
        limit = -in_view[:, 2] * np.tan(FIELD_OF_VIEW / 2.0)
        on_screen = ~leaves & (np.abs(in_view[:, :2]) < limit[:, None]).all(axis=1) & (np.abs(nearest - far) < 1e-3)
        return shown(self.colours, hit, weights), on_screen, leaves

    def sky(self, directions):
        """(N, 3) the SH light."""
        return np.maximum((order2(directions) * SIGNS) @ self.light, 0.0)


@pytest.mark.once
def test_light_of_the_screen_is_numpys(browser, served, exported):
    """A box on its floor: what a mirror shows, and the light that bounces."""
    folder = exported(box_on_a_floor, COLOUR, INTERREFLECTED="bounced", SHADOWED=".")
    found = probed(browser, served, FLOATS + REFLECTION_PROBE, SIZE=SIZE, STEP=STEP, RAYS=32)
    pictures = {name: np.array(pixels).reshape(-1, 4)[:, :3] for name, pixels in found["pictures"].items()}
    seen = Seen(folder, found["eye"], found["axes"])
    check_direct_light(pictures, seen)
    check_reflections(pictures, seen)
    check_indirect_light(pictures, seen)


def check_direct_light(pictures, seen):
    """Of the G-buffer; but for pixels on an edge."""
    expected = np.where(seen.covered[:, None], shown(seen.colours, seen.hit, seen.weights), 0.0)
    assert (np.abs(pictures["direct"] - expected).max(axis=1) > 1e-3).mean() < 0.005


def check_reflections(pictures, seen):
    """In a mirror floor: the box where the screen shows it, and the SH light where there is only sky."""
    floor = seen.covered & (seen.normals[:, 1] > 0.99) & (seen.places[:, 1] < 0.01)
    directions = seen.rays * (1.0, -1.0, 1.0)
    light, on_screen, leaves = seen.along(seen.places, directions)
    for which, expected in ((floor & on_screen, light), (floor & leaves, seen.sky(directions))):
        off = np.abs(pictures["mirror"] - expected)[which].max(axis=1) > 0.05
        print(f"{which.sum()} pixels, {off.mean():.1%} off")  # pytest shows it on failure, or with -s
        assert which.mean() > 0.04
        assert off.mean() <= 0.03, f"{off.sum()} of {which.sum()} pixels"
    box = floor & on_screen
    for other in (pictures["direct"], seen.sky(directions)):
        assert (np.abs(other - light)[box].max(axis=1) > 0.05).mean() > 0.5, "another picture would be noticed"


def check_indirect_light(pictures, seen):
    """Over all surfaces within 8 % of NumPy's, and so the picture comes closer to what is baked with a bounce."""
    chosen = np.flatnonzero(seen.covered)[::3]
    rng = np.random.default_rng(5)
    total = np.zeros(3)
    for _ in range(16):
        around = rng.normal(size=(len(chosen), 3))
        directions = seen.normals[chosen] + around / np.linalg.norm(around, axis=-1, keepdims=True)  # by the cosine
        light, on_screen, _ = seen.along(
            seen.places[chosen], directions / np.linalg.norm(directions, axis=-1, keepdims=True)
        )
        total += (light * on_screen[:, None]).mean(axis=0) / 16.0
    added = (pictures["indirect"] - pictures["direct"])[chosen]
    print(added.mean(axis=0), COLOUR * total)
    np.testing.assert_allclose(added.mean(axis=0), COLOUR * total, rtol=0.08)
    before, after = (np.linalg.norm(pictures[name] - pictures["bounced"]) for name in ("direct", "indirect"))
    print(f"from the bounce: {before:.3f} without, {after:.3f} with")
    assert after < 0.75 * before
