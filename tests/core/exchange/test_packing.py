# SPDX-License-Identifier: GPL-3.0-or-later
"""Packed transport unpacks to what was packed, and compresses."""

import gzip

import numpy as np

from prt_addon.core.exchange import packing


def unpacked(data, vertices):
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
    numbers[:, :, 0] += numbers[:, :, 1]
    numbers[:, :, 2] += numbers[:, :, 1]
    return numbers


def test_every_number_comes_back():
    """The farthest apart, too."""
    numbers = np.random.default_rng(1).integers(-511, 512, size=(40, 9, 3), dtype=np.int32)
    numbers[3], numbers[4] = 511, -511
    numbers[5, :, 1], numbers[6, :, 1] = -511, 511
    np.testing.assert_array_equal(unpacked(packing.to_bytes(numbers), 40), numbers)


def test_rounding_is_within_half_a_step_of_each_layer():
    transport = np.random.default_rng(2).normal(size=(30, 9, 3)) * np.geomspace(1.0, 1e-3, 9)[:, None]
    transport[:, 4] = 0.0
    numbers, scales = packing.rounded(transport)
    assert np.abs(numbers).max() == packing.STEPS and (scales > 0.0).all()
    steps = np.abs(transport).max(axis=(0, 2)) / packing.STEPS
    assert (np.abs(numbers * scales[:, None] - transport) <= steps[:, None] / 2 + 1e-15).all()


def test_neighbours_that_are_alike_take_little_room():
    """A smooth surface's transport, grey as without bounces: a fraction of the 54 bytes that half floats take."""
    along = np.linspace(0.0, 3.0, 5000)
    transport = np.sin(along[:, None] * (1 + np.arange(9)))[:, :, None] * np.ones(3) * 0.3
    numbers, _ = packing.rounded(transport)
    assert len(gzip.compress(packing.to_bytes(numbers))) < 8 * len(along)
