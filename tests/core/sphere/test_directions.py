# SPDX-License-Identifier: GPL-3.0-or-later
"""Directions of rays have the density that is claimed, and each receiver turns them by a chance of its own."""

import numpy as np
import pytest

from prt_addon.core.sphere import directions as sampling
from tests.core.references import random_directions


@pytest.mark.parametrize("count", [1, 2, 64, 4096])
@pytest.mark.parametrize("points", [sampling.fibonacci_sphere, sampling.cosine_fibonacci])
def test_unit_vectors(points, count):
    """Ray lengths are measured in directions: they must be units."""
    assert points(count).shape == (count, 3)
    assert np.allclose(np.linalg.norm(points(count), axis=1), 1, rtol=0, atol=1e-14)


def test_sphere_moments():
    """Even over the sphere: no mean, and a third of the second moment along each axis."""
    points = sampling.fibonacci_sphere(4096)
    assert np.allclose(points.mean(axis=0), 0, atol=1e-4)
    assert np.allclose(points.T @ points / len(points), np.eye(3) / 3, atol=1e-4)


def test_sphere_spreads():
    """The nearest neighbour is never close: random points would come to 2 % of this distance."""
    points = sampling.fibonacci_sphere(1000)
    cosine = points @ points.T - 2 * np.eye(1000)
    assert np.arccos(cosine.max()) > 0.8 * np.sqrt(4 * np.pi / 1000)


def test_cosine_density_moments():
    """E[z**k] = 2 / (k + 2) under the density cos/pi, and a quarter of x**2: uniform rays would give 1 / (k + 1)."""
    x, y, z = sampling.cosine_fibonacci(4096).T
    assert (z > 0).all()
    for power in range(1, 7):
        assert np.isclose(np.mean(z**power), 2 / (power + 2), rtol=0, atol=2e-4), power
    for odd in (x, y, x * y, x * z, y * z, x**3):
        assert np.isclose(odd.mean(), 0, atol=5e-4)
    assert np.allclose([np.mean(x * x), np.mean(y * y)], 0.25, rtol=0, atol=2e-4)


def test_azimuths_depend_on_seed_and_id_alone():
    """A farm may split a bake anywhere: neighbours and order must not matter."""
    ids = np.arange(1000)
    whole = sampling.random_azimuths(ids, 7)
    shuffled = np.random.default_rng(9).permutation(ids)
    assert np.array_equal(sampling.random_azimuths(shuffled, 7), whole[shuffled])
    assert np.array_equal(sampling.random_azimuths(ids[500:501], 7), whole[500:501])
    assert np.array_equal(sampling.random_azimuths(ids, 7), whole)


def test_azimuths_are_pinned():
    """A saved bake can be made again by a later version: SplitMix64's finaliser, run by hand in Python's integers."""

    def mix(z):
        z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9 % 2**64
        z = (z ^ z >> 27) * 0x94D049BB133111EB % 2**64
        return z ^ z >> 31

    golden = 0x9E3779B97F4A7C15
    for seed in (0, 12345, -1):
        start = mix((seed + golden) % 2**64)
        by_hand = [(mix((i * golden + start) % 2**64) >> 11) * 2 * np.pi / 2**53 for i in range(5)]
        assert np.allclose(sampling.random_azimuths(np.arange(5), seed), by_hand, rtol=1e-15, atol=0)


@pytest.mark.parametrize("seed", [0, 1, 2**31 - 1])
def test_azimuths_are_uniform(seed):
    """64 bins of 1000 each: chi-square of 63 degrees stays below 120 but for one seed in 50 000."""
    angles = sampling.random_azimuths(np.arange(64_000), seed)
    assert angles.min() >= 0 and angles.max() < 2 * np.pi
    histogram = np.histogram(angles, bins=64, range=(0, 2 * np.pi))[0]
    assert np.sum((histogram - 1000.0) ** 2 / 1000) < 120


def test_azimuths_are_independent():
    """Neither neighbouring receivers nor neighbouring seeds may turn alike: that would show as bands."""
    ids = np.arange(64_000)
    turns = np.exp(1j * sampling.random_azimuths(ids, 0))
    next_seed = np.exp(1j * sampling.random_azimuths(ids, 1))
    assert abs(np.mean(turns[1:] * turns[:-1].conj())) < 0.016  # 4 sigma
    assert abs(np.mean(turns * next_seed.conj())) < 0.016
    assert abs(np.mean(turns[1:] * next_seed[:-1].conj())) < 0.016  # seed + 1 must not be id + 1


def test_frames_are_right_handed_and_orthonormal():
    """At the poles and just beside them too, where frames built by a cross product break."""
    poles = [(0, 0, 1), (0, 0, -1), (-0.0, -0.0, -1), (1e-9, 0, -1), (0, 1e-5, -1), (1, 0, 0), (1, 0, -1e-17)]
    normals = np.concatenate([np.array(poles, dtype=float), random_directions(200)])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    frames = sampling.tangent_frames(normals, np.linspace(0, 6, len(normals)))
    assert np.allclose(frames @ frames.transpose(0, 2, 1), np.eye(3), rtol=0, atol=1e-14)
    assert np.allclose(np.linalg.det(frames), 1, rtol=0, atol=1e-14)
    assert np.array_equal(frames[:, 2], normals)


def test_azimuth_turns_the_frame_about_its_normal():
    """By that angle, counter-clockwise: else the random turn of each receiver would not be uniform."""
    normals = random_directions(50)
    angles = np.linspace(0, 6, 50)
    start, turned = sampling.tangent_frames(normals, np.zeros(50)), sampling.tangent_frames(normals, angles)
    assert np.allclose(np.sum(turned[:, 0] * start[:, 0], axis=1), np.cos(angles), rtol=0, atol=1e-14)
    assert np.allclose(np.sum(turned[:, 0] * start[:, 1], axis=1), np.sin(angles), rtol=0, atol=1e-14)
