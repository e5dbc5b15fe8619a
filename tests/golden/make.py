# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the golden numbers: what the engine and the web's code must both give, by textbook formulas and plain quadrature; lamps of
skies, which are a matter of choice, are the engine's own.

cd tests && PYTHONPATH=.. python golden/make.py
"""

import base64
import json
from pathlib import Path

import numpy as np

from prt_addon.core.sky.find_lamps import ENOUGH, find_lamps
from prt_addon.core.sky.projection import project_equirect
from prt_addon.core.sky.truncation import truncation
from prt_addon.core.sphere.equirect import texel_directions
from tests.core.references import axis_angle, order2, random_directions, random_rotations, sphere_quadrature

HERE = Path(__file__).resolve().parent


def sphere():
    """The harmonics along directions, and a light before and after some turns: what is seen along w was along R w."""
    directions, rotations = (
        random_directions(12, seed=5),
        [axis_angle((0, 0, 1), np.pi / 2), *random_rotations(3, seed=6)],
    )
    light = np.random.default_rng(7).normal(size=(9, 3))
    points, weights = sphere_quadrature(8)
    turned = [(order2(points) * weights[:, None]).T @ (order2(points @ turn.T) @ light) for turn in rotations]
    normals = random_directions(6, seed=8)
    lobes = np.array([1.0, *[2 / 3] * 3, *[1 / 4] * 5])
    return {
        "directions": directions,
        "basis": order2(directions),
        "light": light,
        "rotations": rotations,
        "turned": turned,
        "normals": normals,
        "unshadowed": (order2(normals) * lobes) @ light,
    }


def shading():
    """Sums of transport and light, some with negative channels, and what is shown of them; the sRGB curve."""
    rng = np.random.default_rng(9)
    transport, light = rng.normal(size=(16, 9, 3)) * 0.2, rng.normal(size=(9, 3))
    light[0] += 4.0
    transport[:, 0] = np.abs(transport[:, 0])
    transport[-1] *= -1.0
    linear = np.array([-1.0, 0.0, 0.002, 0.0031308, 0.18, 0.5, 1.0, 3.0])
    return {
        "transport": transport,
        "light": light,
        "shown": [_without_negatives(sum(t * light)) for t in transport],
        "linear": linear,
        "srgb": [_srgb(min(max(value, 0.0), 1.0)) for value in linear],
    }


def sky():
    """A small picture, the top row first, and its projection: cell by cell between the centres of texels."""
    height, width = 6, 12
    picture = np.random.default_rng(10).gamma(0.5, size=(height, width, 3)).astype(np.float32)
    nodes, weights = np.polynomial.legendre.leggauss(10)
    nodes, weights = (nodes + 1) / 2, weights / 2
    light = np.zeros((9, 3))
    for row in range(-1, height):
        above, below = max(row, 0), min(row + 1, height - 1)
        for column in range(width):
            beside = (column + 1) % width
            for t, share in _half_cells(row, height, nodes, weights):
                elevation = np.pi * (0.5 - (row + 0.5 + t) / height)
                azimuth = 2 * np.pi * (0.5 - (column + 0.5 + nodes) / width)
                upper = np.outer(1 - nodes, picture[above, column]) + np.outer(nodes, picture[above, beside])
                lower = np.outer(1 - nodes, picture[below, column]) + np.outer(nodes, picture[below, beside])
                ring = np.cos(elevation)
                seen = np.stack(
                    [ring * np.cos(azimuth), ring * np.sin(azimuth), np.full(len(nodes), np.sin(elevation))], -1
                )
                area = share * weights * (np.pi / height) * (2 * np.pi / width) * ring
                light += (order2(seen) * area[:, None]).T @ ((1 - t) * upper + t * lower)
    return {"picture": picture, "light": light}


def _glowing():
    """A dim sky, a sun in the midst of its glow, and a window; the lamps in it: one is sharp, two are wide."""
    height, background, discs = (
        64,
        0.2,
        [[0.6, 0.0, 0.8, 2.0, 400.0], [0.6, 0.0, 0.8, 15.0, 1.5], [-0.6, 0.64, 0.48, 17.0, 2.0]],
    )
    directions, picture = texel_directions(height), np.full((height, 2 * height, 3), background, dtype=np.float32)
    for x, y, z, radius, radiance in discs:
        picture[directions @ (x, y, z) > np.cos(np.radians(radius))] += np.float32(radiance)
    found = find_lamps(picture, 4, ENOUGH)
    return {
        "glow_height": height,
        "glow_background": background,
        "glow_discs": discs,
        "glow_directions": [lamp.direction for lamp in found.lamps],
        "glow_irradiances": [lamp.irradiance for lamp in found.lamps],
        "glow_radii": [lamp.radius for lamp in found.lamps],
    }


def lamps():
    """A sky of one colour with five spots of bright texels, the top row first, and the lamps that the engine takes out of it."""
    height, texels, spots = 160, [], []
    rng = np.random.default_rng(12)
    for spot, (row, column, reach, rgb) in enumerate(
        [
            (40, 100, 4, (600, 500, 300)),
            (70, 250, 3, (300, 300, 200)),
            (43, 110, 1, (200, 150, 90)),
            (120, 0, 2, (80, 90, 100)),
            (10, 30, 1, (400, 300, 200)),
        ]
    ):
        places = [
            (row + y, (column + x) % (2 * height)) for y in range(-reach, reach + 1) for x in range(-reach, reach + 1)
        ]
        texels += [[*place, *(np.array(rgb) * rng.uniform(0.5, 1.5)).round(3)] for place in places]
        spots += [spot] * len(places)
    background = np.array([0.2, 0.3, 0.5])
    picture = _spotted(height, background, texels)
    found, one = (find_lamps(picture[::-1], most) for most in (4, 1))
    return {
        "height": height,
        "background": background,
        "texels": texels,
        "spots": spots,
        "most": 4,
        "directions": [lamp.direction for lamp in found.lamps],
        "irradiances": [lamp.irradiance for lamp in found.lamps],
        "radii": [lamp.radius for lamp in found.lamps],
        "colour": found.colour,
        "light": np.multiply.outer(found.light(), found.colour),
        "one": one.lamps[0].direction,
        **_glowing(),
        **_fewest(height, background, np.array(texels), np.array(spots)),
    }


STRENGTHS = np.array(
    [
        [0.0, 0.0, 0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0, 0.01, 0.01],
        [1.0, 1.0, 0.0, 0.0, 0.0],
        [0.2, 0.5, 5.0, 3.0, 0.0],
        [0.2, 0.4, 1.0, 3.0, 50.0],
    ]
)
"""Of the five spots, in skies that want no lamp, one, two, three and four."""


def _fewest(height, background, texels, spots):
    """How many lamps *Automatic* takes out of skies with these spots at several strengths, and what the skies lose without lamps."""
    counts, lost = [], []
    for strengths in STRENGTHS:
        lit = texels.copy()
        lit[:, 2:] *= strengths[spots][:, None]
        picture = _spotted(height, background, lit[strengths[spots] > 0.0])[::-1]
        counts.append(len(find_lamps(picture, 4, ENOUGH).lamps))
        lost.append(truncation(project_equirect(picture, 8)))
    return {"strengths": STRENGTHS, "enough": ENOUGH, "counts": counts, "truncations": lost}


def _spotted(height, background, texels):
    picture = np.tile(background, (height, 2 * height, 1)).astype(np.float32)
    for row, column, *rgb in texels:
        picture[int(row), int(column)] = rgb
    return picture


def radiance():
    """One picture as two .hdr files, without and with run lengths, and its numbers."""
    rng = np.random.default_rng(11)
    texels = rng.integers(0, 256, size=(3, 12, 4), dtype=np.uint8)
    texels[..., 3] = rng.integers(120, 140, size=(3, 12))
    texels[1, 2:9] = texels[1, 2]
    texels[0, 0] = (9, 9, 9, 0)
    header = b"#?RADIANCE\n# by hand\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=1.0\n\n-Y 3 +X 12\n"
    packed = b"".join(bytes([2, 2, 0, 12]) + b"".join(_run_lengths(row[:, k]) for k in range(4)) for row in texels)
    scale = np.where(texels[..., 3:] > 0, 2.0 ** (texels[..., 3:].astype(float) - 136), 0.0)
    return {
        "flat": base64.b64encode(header + texels.tobytes()).decode(),
        "packed": base64.b64encode(header + packed).decode(),
        "pixels": texels[..., :3] * scale,
    }


def _half_cells(row, height, nodes, weights):
    """Where a cell between two rows is looked up, in rows from the upper centre; at the poles half of it lies in the picture."""
    low, high = (0.5 if row < 0 else 0.0), (0.5 if row == height - 1 else 1.0)
    return zip(low + nodes * (high - low), weights * (high - low), strict=True)


def _run_lengths(values):
    out, at = b"", 0
    while at < len(values):
        run = 1
        while at + run < len(values) and values[at + run] == values[at]:
            run += 1
        out += bytes([128 + run, values[at]]) if run > 2 else bytes([1, values[at]]) * run
        at += run
    return out


def _without_negatives(colour):
    least, mean = min(colour), sum(colour) / 3
    if least >= 0:
        return colour
    if mean <= 0:
        return np.zeros(3)
    return colour + (mean - colour) * least / (least - mean)


def _srgb(value):
    return 12.92 * value if value <= 0.0031308 else 1.055 * value ** (1 / 2.4) - 0.055


GOLDEN = {"sphere": sphere, "shading": shading, "sky": sky, "lamps": lamps, "radiance": radiance}


def plain(numbers):
    """Arrays as lists, as JSON has them."""
    return {key: np.asarray(value).tolist() for key, value in numbers.items()}


if __name__ == "__main__":
    for name, make in GOLDEN.items():
        (HERE / f"{name}.json").write_text(json.dumps(plain(make())) + "\n")
