# SPDX-License-Identifier: GPL-3.0-or-later
"""Each part of a report is right in cases where it is known by other means."""

from dataclasses import replace

import numpy as np
import pytest

from prt_addon.core.problem import BakeSettings
from prt_addon.core.report.document import PARTS, surface_report
from prt_addon.core.report.findings import Effort, find
from prt_addon.core.report.heat import receiver_errors
from prt_addon.core.report.measures import Estimate, percent, percentile, product, relative_rms
from prt_addon.core.report.sampling import sampling
from prt_addon.core.report.tessellation import tessellation
from prt_addon.core.report.total import total
from prt_addon.core.report.truncation import truncation
from prt_addon.core.sky.lamps import Lamps
from tests.core import shapes
from tests.core.references import axis_angle, random_rotations
from tests.core.report.surfaces import FEW, floor, half, light_of, smooth_sky, subjects_of, sunny_sky


def measured_noise(parts, settings, light):
    """Between vertices, by many whole bakes: the spread of what the shader shows."""
    shown = []
    for seed in range(1, 9):
        for subject in subjects_of(parts, replace(settings, seed=seed))[:1]:
            corners = np.einsum("nic,ic->nc", subject.transport, light.stored)[subject.corner_receiver]
            shown.append(corners)
    spread = np.var(shown, axis=0, ddof=1).mean(axis=-1)  # (T, 3): of independent corners
    mean = np.mean(shown, axis=(0, 2))
    return np.sqrt((spread.sum(axis=1) / 6.0).mean() / (mean**2).mean())  # a point's shares have a mean square of 1/6


@pytest.mark.parametrize("mode", ["SHADOWED", "INTERREFLECTED"])
def test_noise_is_what_other_seeds_show(mode):
    """The estimate of one bake, against the spread of eight."""
    light, settings = light_of(smooth_sky()), BakeSettings(mode, 64, bounces=2)
    found = sampling([find(subjects_of(floor(24), settings)[0], light, Effort(1024, 16))])
    wanted = measured_noise(floor(24), settings, light)
    assert found.relative_rms.value == pytest.approx(wanted, rel=0.1)
    assert found.percentile_95.value > found.relative_rms.value


def test_noise_falls_with_the_samples():
    """As the sequence's does, and to nothing with 16k of them; unshadowed transport has none."""
    light, noise = light_of(smooth_sky()), {}
    for samples in (16, 256, 16384):
        subject = subjects_of({"ball": shapes.bumpy_sphere(3)}, BakeSettings("SHADOWED", 16))[0]
        subject = replace(subject, settings=BakeSettings("SHADOWED", samples))
        noise[samples] = sampling([find(subject, light, Effort(64, 16))]).relative_rms.value
    assert 5.0 < noise[16] / noise[256] < 14.0, "16 to the power of 0.6 to 0.95"
    assert noise[16384] < 1e-3 < noise[256] < noise[16] < 0.2
    [open_one] = subjects_of({"ball": shapes.icosphere(3)}, BakeSettings("UNSHADOWED"))
    assert sampling([find(open_one, light, FEW)]).relative_rms.value == 0.0


def interpolation_error(cells, light):
    """On the floor, by brute force: transport of 1024 rays at a fine grid of points, against its bilinear interpolant."""
    fine = 48
    [truth, *_] = subjects_of(floor(fine), BakeSettings("SHADOWED", 1024))
    radiance = np.einsum("nic,ic->nc", truth.transport, light.stored).reshape(fine + 1, fine + 1, 3)
    step = fine // cells
    corner = radiance[::step, ::step]
    s, t = np.meshgrid(np.arange(fine) % step / step, np.arange(fine) % step / step, indexing="ij")
    s, t = s[..., None], t[..., None]
    a, b, d, c = (
        part.repeat(step, axis=0).repeat(step, axis=1)
        for part in (corner[:-1, :-1], corner[1:, :-1], corner[:-1, 1:], corner[1:, 1:])
    )
    upper = a + t * (d - a) + s * (c - d)  # the grid's quads are cut from a to c
    lower = a + s * (b - a) + t * (c - b)
    error = np.where(s > t, lower, upper) - radiance[:-1, :-1]
    return np.sqrt((error**2).mean() / (radiance**2).mean())


def test_coarse_meshes_err_as_much_as_they_do():
    """Within the interval of a brute force comparison; four times as fine, it is a small part; a dense mesh has none."""
    light, errors = light_of(smooth_sky()), {}
    for cells in (4, 16, 64):
        found = [find(subjects_of(floor(cells), BakeSettings("SHADOWED", 256))[0], light, Effort(512, 16))]
        errors[cells] = tessellation(found).relative_rms
    wanted = interpolation_error(4, light)
    assert errors[4].low < wanted < errors[4].high
    assert errors[4].low > 0.05 and errors[16].high < 0.5 * errors[4].low and errors[64].high < 0.1 * errors[4].low


def test_the_object_that_needs_it_is_named():
    """A coarse floor beside a dense ball."""
    parts = {"floor": shapes.grid(3, 4.0), "ball": shapes.icosphere(4)}
    parts["floor"] = (parts["floor"][0] - np.array((0.0, 0.0, 1.3)), parts["floor"][1])
    light = light_of(smooth_sky())
    found = [find(one, light, FEW) for one in subjects_of(parts, BakeSettings("SHADOWED", 64))]
    shares = tessellation(found).shares
    assert shares["floor"] > 0.8 and sum(shares.values()) == pytest.approx(1.0)
    advice = surface_report(found, Lamps(), PARTS)["all"]["advice"]["tessellation"]
    assert advice.startswith("Subdivide 'floor'")


@pytest.mark.parametrize(
    "sky, cells, samples, mode",
    [(sunny_sky, 16, 64, "SHADOWED"), (smooth_sky, 5, 1024, "INTERREFLECTED"), (smooth_sky, 32, 8, "SHADOWED")],
    ids=["truncation", "tessellation", "sampling"],
)
def test_parts_add_up_to_the_whole(sky, cells, samples, mode):
    """Each of them ruling once: the root of the sum of squares is the error that is measured by itself."""
    light = light_of(sky())
    found = [find(subjects_of(floor(cells), BakeSettings(mode, samples))[0], light, Effort(512, 64))]
    parts = [part(found).relative_rms for part in (sampling, truncation, tessellation)]
    whole = total(found).relative_rms
    together = np.sqrt(sum(part.value**2 for part in parts))
    margin = np.sqrt(half(whole) ** 2 + sum((part.value * half(part)) ** 2 for part in parts) / together**2)
    assert abs(together - whole.value) < margin
    assert whole.value > 0.03 and margin < 0.3 * whole.value


def test_own_axes_and_turned_skies():
    """A whole scene turned with its sky, or its light turned into an object's axes: the same numbers."""
    [turn] = random_rotations(1)
    sky, settings = smooth_sky(), BakeSettings("SHADOWED", 256)
    [subject] = subjects_of({"ball": shapes.bumpy_sphere(4)}, settings)
    as_is = total([find(subject, light_of(sky), FEW)]).relative_rms
    assert as_is.value < 0.02
    turned = light_of(sky, turn)
    assert total([find(subject, turned, FEW)]).relative_rms.value < 0.02
    mirrored = axis_angle((1.0, 2.0, 0.5), 0.8) @ np.diag([1.0, 1.0, -1.0])
    assert total([find(replace(subject, axes=mirrored), turned, FEW)]).relative_rms.value < 0.02


def test_what_lies_inside_is_left_out():
    """A ball half sunk into a box: half of it is never seen, and the report says so."""
    vertices, triangles = shapes.icosphere(3)
    parts = {"ball": (0.5 * vertices + np.array((0.0, 0.0, 1.0)), triangles), "box": shapes.box()}
    [ball, _] = subjects_of(parts, BakeSettings("SHADOWED", 64))
    found = find(ball, light_of(smooth_sky()), FEW)
    assert found.inside == pytest.approx(0.5, abs=0.05)
    assert len(found.weights) == pytest.approx(64, abs=7)
    assert found.area == pytest.approx(np.pi * 0.5, rel=0.1)


def test_same_numbers_again_and_others_for_another_seed():
    """Reports can be compared."""
    light, [subject] = (
        light_of(sunny_sky()),
        subjects_of({"ball": shapes.bumpy_sphere(3)}, BakeSettings("SHADOWED", 16)),
    )
    one, again, other = (
        surface_report([find(subject, light, Effort(64, 16, seed))], light.lamps, PARTS) for seed in (0, 0, 1)
    )
    assert one == again != other


def test_heat_map_shows_where():
    """Transport that is halved on one side of a ball: too dark there, right elsewhere."""
    [subject] = subjects_of({"ball": shapes.icosphere(3)}, BakeSettings("SHADOWED", 256))
    spoilt = subject.transport.copy()
    left = subject.group.points[:, 0] < 0.0
    spoilt[left] *= 0.5
    errors = receiver_errors(replace(subject, transport=spoilt), light_of(smooth_sky()), 0)
    assert np.median(errors[left]) < -0.2 and np.abs(np.median(errors[~left])) < 0.01


def test_intervals_hold_the_truth_19_times_in_20():
    """Of squared errors that are themselves noisy, weighed; of the median of a skewed distribution."""
    rng, inside = np.random.default_rng(7), [0, 0]
    for _ in range(400):
        true_error, weights = 0.1 * rng.gamma(2.0, size=(200, 3)), rng.uniform(0.5, 1.5, 200)
        one, other = (true_error + 0.2 * rng.normal(size=true_error.shape) for _ in range(2))
        truth = np.full(200, 1.0)
        found = relative_rms(product(one, other), truth, weights)
        inside[0] += found.low < 0.1 * np.sqrt(6.0) < found.high  # E gamma(2)^2 = 6
        middle = percentile(rng.exponential(size=200), np.ones(200), 0.5)
        inside[1] += middle.low < np.log(2.0) < middle.high
    assert min(inside) > 0.9 * 400 and max(inside) < 0.99 * 400


def test_nothing_to_measure_is_unknown_and_no_error():
    """A black sky, and a surface without area."""
    dark = np.zeros((8, 16, 3), dtype=np.float32)
    [subject] = subjects_of({"ball": shapes.icosphere(2)}, BakeSettings("SHADOWED", 16))
    document = surface_report([find(subject, light_of(dark), FEW)], Lamps(), PARTS)
    assert document["all"]["total"]["relative_rms"]["value"] is None
    assert document["all"]["advice"]["sampling"] == "No light reaches the surface."
    flat = replace(subject, corners=np.zeros_like(subject.corners))
    assert surface_report([find(flat, light_of(smooth_sky()), FEW)], Lamps(), PARTS)["objects"][0]["points"] == 0


def test_advice_on_samples_is_true():
    """The number that is named brings the noise to where it says."""
    parts, light = floor(32), light_of(smooth_sky())
    found = [find(subjects_of(parts, BakeSettings("SHADOWED", 8))[0], light, Effort(512, 16))]
    advice = surface_report(found, Lamps(), PARTS)["all"]["advice"]["sampling"]
    samples = int(advice.split()[2])
    better = sampling([find(subjects_of(parts, BakeSettings("SHADOWED", samples))[0], light, Effort(512, 16))])
    assert better.relative_rms.value < 0.5 * sampling(found).relative_rms.value
    assert better.relative_rms.value < 0.013


def test_percent_has_two_digits():
    """Of any size."""
    assert [percent(x) for x in (0.0312, 0.312, 0.0996, 0.004, float("nan"))] == [
        "3.1%",
        "31%",
        "10%",
        "0.4%",
        "unknown",
    ]
    assert not Estimate(float("nan"), 0.0, 0.0).is_known
