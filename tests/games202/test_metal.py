# SPDX-License-Identifier: GPL-3.0-or-later
"""The page's rough metal is the engine's, with and without the light of all bounces."""

import shutil
from functools import partial

import numpy as np
import pytest

from prt_addon.core.microfacet import compensation, ggx, table
from prt_addon.core.microfacet.albedo import by_quadrature
from tests.games202.probes import FLOATS, PAGE, probed

UP = np.array([0.0, 0.0, 1.0])
GRID = np.linspace(0.02, 1.0, 200)
METAL_PROBE = """<script src="program.js"></script><script src="metal.js"></script>
<script>
async function run() {
  const tables = [await Metal.table("GGX_E_LUT.png"), await Metal.table("GGX_Eavg_LUT.png")];
  const gl = floatTarget(10 * SIZE, 2 * SIZE), metal = new Metal(gl, ...tables);
  metal.lamp = LAMP;
  return [false, true].map((course) => {
    metal.course = course;
    metal.draw(10 * SIZE, 2 * SIZE, false);
    return pixelsOf(gl, 10 * SIZE, 2 * SIZE, 1);
  });
}
post(run());
</script>"""


def metal(size, lamp, colour, bounce_colour):
    """(2 size, 10 size, 3) the same spheres by the engine; below, with the light of all bounces."""
    line = 2.0 * (np.arange(size) + 0.5) / size - 1.0
    x, y = np.meshgrid(line, line)
    away = x * x + y * y
    normals = np.stack([x, y, np.sqrt(np.maximum(1.0 - away, 0.01))], axis=-1)
    mu_out, mu_in = normals[..., 2], normals @ lamp
    half = normals @ (lamp + UP) / np.linalg.norm(lamp + UP)
    facing = (away <= 0.99) & (mu_in > 0.0)
    columns = []
    for roughness in np.arange(1, 11) / 10.0:
        alpha, inward = roughness**2, np.where(facing, mu_in, 1.0)
        seen = ggx.masking_shadowing(mu_out, inward, alpha)
        first = colour * (ggx.distribution(half, alpha) * seen / (4.0 * mu_out * inward))[..., None]
        average = table.average_albedo(roughness)
        albedo = partial(np.interp, xp=GRID, fp=by_quadrature(GRID, roughness).white)
        further = compensation.lost_lobe(albedo(mu_out), albedo(inward), average)[..., None] * bounce_colour(
            colour, average
        )
        columns.append(
            np.concatenate([first + further, first]) * np.tile((np.pi * facing * inward)[..., None], (2, 1, 1))
        )
    return np.concatenate(columns, axis=1)


@pytest.mark.once
def test_metal_is_the_engines(browser, served):
    """Rows of spheres with and without the second lobe, in both colours of it; the tables are of eight bits."""
    for name in ("GGX_E_LUT.png", "GGX_Eavg_LUT.png"):
        shutil.copy(PAGE.parents[1] / "pictures" / "course" / name, served[0])
    lamp, size = np.array([0.5, 0.0, np.sqrt(0.75)]), 24
    pictures = probed(browser, served, FLOATS + METAL_PROBE, SIZE=size, LAMP=lamp.tolist())
    colours = (compensation.bounce_colour, compensation.course_bounce_colour)
    for pixels, bounce_colour in zip(pictures, colours, strict=True):
        ours = np.array(pixels).reshape(2 * size, 10 * size, 4)[..., :3]
        expected = metal(size, lamp, np.array([0.95, 0.64, 0.54]), bounce_colour)
        np.testing.assert_allclose(ours[size:], expected[size:], atol=1e-3, rtol=1e-3)
        np.testing.assert_allclose(ours[:size], expected[:size], atol=0.02, rtol=1e-3)
    assert np.abs(np.subtract(*pictures)).max() > 0.05, "the course's colour would be noticed"
