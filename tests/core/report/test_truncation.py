# SPDX-License-Identifier: GPL-3.0-or-later
"""Nine coefficients lose of a sky, and of its suns, what is known by other means."""

import numpy as np
import pytest

from prt_addon.core.problem import BakeSettings
from prt_addon.core.report.document import PARTS, surface_report
from prt_addon.core.report.findings import Effort, find
from prt_addon.core.report.subject import Lighting
from prt_addon.core.report.suns import find_suns
from prt_addon.core.report.truncation import truncation
from prt_addon.core.sky.projection import project_equirect
from tests.core import shapes, skies
from tests.core.report.surfaces import FEW, SCENE, floor, light_of, smooth_sky, subjects_of, sunny_sky


def test_convex_mesh_loses_the_cosines_own_bands():
    """A ball under a sun and a sky of band 4: what sums over all texels find that a cosine cut off after a band loses."""
    grey = np.full((64, 128, 3), skies.AROUND)
    sunny, sunless = (skies.with_band(sky, 4, 0.5) for sky in (skies.with_disc(64, (1.0, 2.0, 0.5), 0.02, 1e4), grey))
    [subject] = subjects_of({"ball": shapes.icosphere(4)}, BakeSettings("SHADOWED", 16))
    found = truncation([find(subject, light_of(sunny), Effort(512, 64))])
    for order, wanted in skies.losses(sunny, sunny, (1, 2, 4, 6)).items():
        got = found.by_order[order]
        assert got.low - 0.002 < wanted < got.high + 0.002, f"order {order}: {got}, {wanted}"
    assert found.by_order[2].value == pytest.approx(found.by_order[3].value, rel=0.03), "band 3 of the cosine is zero"
    assert found.relative_rms.value == pytest.approx(found.by_order[2].value, rel=1e-4)
    assert found.by_order[2].value > 0.05
    wanted = skies.losses(sunless, sunny, (2,))[2]
    assert 0.0 < found.without_suns.low < wanted < found.without_suns.high


@pytest.mark.parametrize(
    ("height", "towards", "radius", "times"),
    [
        (512, (1, 0, 0), 0.0047, 1e5),
        (256, (0, -1, 2), 0.01, 1e5),
        (256, (0, 0, 1), 0.01, 1e5),
        (256, (1, 2, 0), 0.01, 9e2),
    ],
    ids=["as large as ours", "between", "at the pole", "too faint"],
)
def test_share_of_a_disc(height, towards, radius, times):
    """A sun as large as ours is, one in the zenith: their share is that of the disc, but for its rim."""
    suns = find_suns(skies.with_disc(height, towards, radius, times))
    wanted = skies.share_of_disc(radius, times) if times > 1e4 else 0.0
    assert suns.share == pytest.approx(wanted, rel=0.01)
    assert np.median(suns.without) == pytest.approx(skies.AROUND) == pytest.approx(suns.without.min())


def test_band_limited_sky_is_not_truncated():
    """Under shadows and bounces; order 1 would lose some."""
    subjects = subjects_of({"ball": shapes.bumpy_sphere(3)}, BakeSettings("INTERREFLECTED", 16))
    found = truncation([find(one, light_of(smooth_sky()), FEW) for one in subjects])
    assert found.relative_rms.high < 2e-3
    assert found.by_order[1].low > 0.05
    assert found.without_suns is None


def test_sun_is_told_and_could_be_a_lamp():
    """Half of the light: most of the error goes with it, and the truth has converged."""
    light = light_of(sunny_sky())
    assert light.suns.share == pytest.approx(0.5, abs=0.01)
    subjects = subjects_of(floor(12), BakeSettings("SHADOWED", 64))
    found = [find(one, light, FEW) for one in subjects[:1]]
    part = truncation(found)
    assert part.reference_interval < 0.02
    assert part.relative_rms.low > 0.05 > 3.0 * part.without_suns.high
    document = surface_report(found, light.suns.share, PARTS)
    assert "The sun carries 50% of the light: Extract Lamps would leave" in document["all"]["advice"]["truncation"]
    document = surface_report(found, light.suns.share, PARTS, lamps=True)
    assert "which a lamp shows in EEVEE" in document["all"]["advice"]["truncation"]


def test_window_is_counted_and_told():
    """A light that is not its sky's projection: its own loss, and what a new projection would leave."""
    pixels = smooth_sky()
    windowed = project_equirect(pixels)
    windowed[1:] *= 0.5
    [subject] = subjects_of({"ball": shapes.icosphere(3)}, BakeSettings("SHADOWED", 16))
    found = [find(subject, Lighting(pixels, SCENE, windowed), FEW)]
    part = truncation(found)
    assert part.relative_rms.low > 0.05 > part.by_order[2].high
    assert "project it again" in surface_report(found, 0.0, PARTS)["all"]["advice"]["truncation"]


def test_suns_are_found_by_brightness_alone():
    """A bright quarter of the sky is none; negative texels do not hide one."""
    sky = np.full((32, 64, 3), 0.1, dtype=np.float32)
    sky[:16, :32] = 10.0
    assert not find_suns(sky).matter and find_suns(sky).without is sky
    sunny = sunny_sky()
    sunny[0] = -1.0
    found = find_suns(sunny)
    assert found.matter and found.without.max() < 1.0
