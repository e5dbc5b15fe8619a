# SPDX-License-Identifier: GPL-3.0-or-later
"""Packed transport unpacks to what was packed, and compresses."""

import gzip

import numpy as np
import pytest

from prt_addon.core.exchange import packing


def unpacked(data, vertices, tints):
    """The reverse, number by number."""
    numbers = np.zeros((vertices, 27), dtype=int)
    for number in range(27):
        value = 0
        for vertex in range(vertices):
            at = number * vertices + vertex
            code = data[at] + 256 * data[27 * vertices + at]
            value += -(code + 1) // 2 if code % 2 else code // 2
            numbers[vertex, number] = value
    numbers = numbers.reshape(vertices, 9, 3)
    for channel, tint in zip((0, 2), tints, strict=True):
        numbers[:, :, channel] += np.floor(numbers[:, :, 1] * tint / 256 + 0.5).astype(int)
    return numbers


@pytest.mark.parametrize("tints", [[256, 256], [0, 700], [-131, 77]])
def test_every_number_comes_back(tints):
    """The farthest apart, too, whatever is foretold."""
    numbers = np.random.default_rng(1).integers(-255, 256, size=(40, 9, 3), dtype=np.int32)
    numbers[3], numbers[4] = 255, -255
    numbers[5, :, 1], numbers[6, :, 1] = -255, 255
    np.testing.assert_array_equal(unpacked(packing.to_bytes(numbers, tints), 40, tints), numbers)


def test_what_is_in_proportion_to_green_takes_no_room():
    """Bounces off one colour: red twice as strong, blue a third."""
    green = np.random.default_rng(4).integers(-120, 121, size=(500, 9), dtype=np.int32)
    numbers = np.stack([2 * green, green, green // 3], axis=-1)
    tints = packing.tints_of(numbers)
    assert tints[0] == 512 and abs(tints[1] - 85) <= 1
    alone = len(gzip.compress(packing.to_bytes(np.repeat(green[..., None], 3, axis=-1), [256, 256])))
    assert len(gzip.compress(packing.to_bytes(numbers, tints))) < 1.25 * alone
    assert packing.tints_of(np.zeros((3, 9, 3), dtype=np.int32)) == [256, 256]


def test_bounces_and_direct_part_add_up():
    """Bounces and the direct part, whose marks are taken off beforehand; grey ones without bounces take no room for colours."""
    layers = np.random.default_rng(3).normal(size=(500, 9, 4))
    separated = packing.separated(layers)
    np.testing.assert_array_equal(separated[..., 3], layers[..., 3])
    np.testing.assert_allclose(separated[..., :3] + separated[..., 3:], layers[..., :3])
    layers[..., :3] = layers[..., 3:]
    sizes = [len(gzip.compress(packed_whole(parts))) for parts in (packing.separated(layers), layers[..., :3])]
    assert sizes[0] < 1.02 * sizes[1]


def packed_whole(parts):
    numbers, _ = packing.rounded(parts)
    return packing.to_bytes(numbers, packing.tints_of(numbers))


def test_rounding_is_within_half_a_step():
    transport = np.random.default_rng(2).normal(size=(30, 9, 3)) * np.geomspace(1.0, 1e-3, 9)[:, None]
    transport[:, 4] = 0.0
    numbers, scale = packing.rounded(transport)
    assert np.abs(numbers).max() == packing.STEPS and scale > 0.0
    assert np.abs(numbers * scale - transport).max() <= np.abs(transport).max() / packing.STEPS / 2 + 1e-15
    assert packing.rounded(np.zeros((2, 9, 3)))[1] == 1.0


def test_neighbours_that_are_alike_take_little_room():
    """A smooth surface's transport, grey as without bounces: a fraction of the 54 bytes that half floats take."""
    along = np.linspace(0.0, 3.0, 5000)
    transport = np.sin(along[:, None] * (1 + np.arange(9)))[:, :, None] * np.ones(3) * 0.3
    assert len(gzip.compress(packed_whole(transport))) < 8 * len(along)


def test_backs_come_within_half_a_step():
    """Nine numbers, then red and green of their colour, and the direct share if that is wanted; noise beyond what colours are is cut off."""
    generator = np.random.default_rng(5)
    layers = generator.normal(size=(40, 3, 4)) * 0.2
    layers[:, :, 3] = generator.uniform(0.0, 1.5, size=(40, 3))
    layers[:, 0, 0] -= 1.0
    layers[7, 0, 3], layers[8, 1, 3] = -5.0, 9.0
    numbers, scale = packing.backs_rounded(layers, direct=True)
    transport = layers[:, :, :3].reshape(40, 9) + np.eye(9)[0]
    assert np.abs(numbers[:, :9] * scale - transport).max() <= np.abs(transport).max() / packing.STEPS / 2 + 1e-12
    shares = np.clip(layers[:, [1, 2, 0], 3], 0.0, 3.0)
    assert np.abs(numbers[:, 9:] / packing.SHARES - shares).max() <= 0.5 / packing.SHARES + 1e-12
    np.testing.assert_array_equal(packing.backs_rounded(layers, direct=False)[0], numbers[:, :11])
