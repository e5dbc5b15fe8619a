# SPDX-License-Identifier: GPL-3.0-or-later
"""Nine coefficients lose of a sky, and of what its lamps leave, what is known by other means."""

import numpy as np
import pytest

from prt_addon.core.problem import BakeSettings
from prt_addon.core.report.advice import about_truncation
from prt_addon.core.report.document import PARTS, surface_report
from prt_addon.core.report.findings import Effort, find
from prt_addon.core.report.measures import Estimate
from prt_addon.core.report.subject import Lighting
from prt_addon.core.report.truncation import Truncation, truncation
from prt_addon.core.sky.find_lamps import extract_lamps
from prt_addon.core.sky.lamps import Lamp, Lamps
from prt_addon.core.sky.projection import project_equirect
from tests.core import shapes, skies
from tests.core.report.surfaces import AUTOMATIC, FEW, SCENE, floor, light_of, smooth_sky, subjects_of, sunny_sky


def test_convex_mesh_loses_the_cosines_own_bands():
    """A ball under a sun and a sky of band 4: what sums over all texels find that a cosine cut off after a band loses."""
    sunny = skies.with_band(skies.with_disc(64, (1.0, 2.0, 0.5), 0.02, 1e4), 4, 0.5)
    [subject] = subjects_of({"ball": shapes.icosphere(4)}, BakeSettings("SHADOWED", 16))
    found = truncation([find(subject, light_of(sunny), Effort(512, 64))])
    for order, wanted in skies.losses(sunny, sunny, (1, 2, 4, 6)).items():
        got = found.by_order[order]
        assert got.low - 0.002 < wanted < got.high + 0.002, f"order {order}: {got}, {wanted}"
    assert found.by_order[2].value == pytest.approx(found.by_order[3].value, rel=0.03), "band 3 of the cosine is zero"
    assert found.relative_rms.value == pytest.approx(found.by_order[2].value, rel=1e-4)
    assert found.by_order[2].value > 0.05
    wanted = skies.losses(np.minimum(sunny, 10.0 * skies.mean(sunny)), sunny, (2,))[2]  # the sun is a compact lamp
    assert 0.0 < found.without_lamps.low < wanted < found.without_lamps.high


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
    """A sun as large as ours is, one in the zenith: their share is that of the disc."""
    sky = skies.with_disc(height, towards, radius, times)
    lamps, without = extract_lamps(sky, *AUTOMATIC)
    wanted = skies.share_of_disc(radius, times) if times > 1e4 else 0.0
    assert lamps.share == pytest.approx(wanted, rel=0.01) and len(lamps.lamps) == (times > 1e4)
    assert np.median(without) == pytest.approx(skies.AROUND) == pytest.approx(without.min())
    assert without.max() == pytest.approx(10.0 * skies.mean(sky)) or without is sky


def test_band_limited_sky_is_not_truncated():
    """Under shadows and bounces; order 1 would lose some."""
    subjects = subjects_of({"ball": shapes.bumpy_sphere(3)}, BakeSettings("INTERREFLECTED", 16))
    found = truncation([find(one, light_of(smooth_sky()), FEW) for one in subjects])
    assert found.relative_rms.high < 2e-3
    assert found.by_order[1].low > 0.05
    assert found.without_lamps is None and light_of(smooth_sky()).lamps == Lamps()


def test_lamps_are_told():
    """Half of the light: most of the error goes with it, and the truth has converged."""
    light = light_of(sunny_sky())
    assert light.lamps.share == pytest.approx(0.5, abs=0.01)
    subjects = subjects_of(floor(12), BakeSettings("SHADOWED", 64))
    found = [find(one, light, FEW) for one in subjects[:1]]
    part = truncation(found)
    assert part.reference_interval < 0.02
    assert part.relative_rms.low > 0.05 > 3.0 * part.without_lamps.high
    document = surface_report(found, light.lamps, PARTS)
    assert "1 lamp would carry 50% of the light: Extract Lamps would leave" in document["all"]["advice"]["truncation"]
    document = surface_report(found, light.lamps, PARTS, shown=True)
    assert "1 lamp carries 50% of the light, and shows it in EEVEE: " in document["all"]["advice"]["truncation"]
    assert document["lamps"] == {
        "count": 1,
        "share_of_light": pytest.approx(light.lamps.share, rel=1e-4),
        "shown": True,
    }


def test_lamps_that_matter_little_are_told_beside_the_order():
    """In the plural where they are many."""
    loss, four = Estimate(0.3, 0.29, 0.31), Lamps((Lamp(np.array((0.0, 0.0, 1.0)), 1.0, 0.1),) * 4, share=0.05)
    part = Truncation(loss, dict.fromkeys(range(1, 7), loss), loss, 0.01)
    assert about_truncation(part, four, False).startswith("4 lamps would carry 5.0% of the light. Order 3 would leave")
    shown = about_truncation(part, four, True)
    assert shown.startswith("4 lamps carry 5.0% of the light, and show it in EEVEE. Order 3 would leave")


def test_four_lamps_of_a_studio_are_known():
    """None is a sun: a wide one in a dim room, three spots. What is left of the error is measured against what is left of the light."""
    sky = np.full((64, 128, 3), 0.01)
    for towards, radius in (((1, 0, 1), 0.28), ((-1, 0.5, 1), 0.1), ((0.3, -1, 0.8), 0.12), ((-0.5, -1, 0.3), 0.1)):
        sky += skies.with_disc(64, towards, radius, 1.0 + (5.0 if radius > 0.2 else 60.0), 0.1) - np.float32(0.1)
    light = light_of(sky.astype(np.float32))
    assert len(light.lamps.lamps) == 4 and light.lamps.share > 0.5
    [subject] = subjects_of({"ball": shapes.icosphere(4)}, BakeSettings("SHADOWED", 16))
    part = truncation([find(subject, light, Effort(512, 64))])
    rest = extract_lamps(sky.astype(np.float32), *AUTOMATIC)[1]
    assert (
        part.without_lamps.low
        < skies.losses(rest, sky, (2,))[2]
        < part.without_lamps.high
        < 0.7 * part.relative_rms.low
    )


def test_window_is_counted_and_told():
    """A light that is not its sky's projection: its own loss, and what a new projection would leave."""
    pixels = smooth_sky()
    windowed = project_equirect(pixels)
    windowed[1:] *= 0.5
    [subject] = subjects_of({"ball": shapes.icosphere(3)}, BakeSettings("SHADOWED", 16))
    found = [find(subject, Lighting(pixels, SCENE, windowed, AUTOMATIC), FEW)]
    part = truncation(found)
    assert part.relative_rms.low > 0.05 > part.by_order[2].high
    assert "project it again" in surface_report(found, Lamps(), PARTS)["all"]["advice"]["truncation"]


def test_a_bright_quarter_is_no_lamp_and_nothing_hides_one():
    """Neither do negative texels, nor a rule of few."""
    sky = np.full((32, 64, 3), 0.1, dtype=np.float32)
    sky[:16, :32] = 10.0
    sunny = sunny_sky()
    sunny[0] = -1.0
    for rule in (AUTOMATIC, (1, 0.0)):
        lamps, without = extract_lamps(sky, *rule)
        assert lamps == Lamps() and without is sky
        lamps, without = extract_lamps(sunny, *rule)
        assert lamps.share == pytest.approx(0.5, abs=0.01)
        assert without.max() == pytest.approx(10.0 * skies.mean(np.maximum(sunny, 0.0)))
        np.testing.assert_array_equal(without[0], sunny[0])
