# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the directions of rays: low-discrepancy sets, tangent frames, and a random turn for each receiver."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ..arrays import Float64

GOLDEN_ANGLE = np.pi * (3.0 - np.sqrt(5.0))


def fibonacci_sphere(count: int) -> Float64:
    """(count, 3) unit vectors spread evenly over the sphere (Swinbank & Purser 2006)."""
    index = np.arange(count)
    z = 1.0 - (2.0 * index + 1.0) / count
    return _spiral(index, z)


def cosine_fibonacci(count: int) -> Float64:
    """(count, 3) unit vectors over the hemisphere z > 0, their density proportional to the cosine.

    Under this density every ray weighs the same: the cosine and the 1/pi of a Lambertian receiver cancel
    against the probability `cos / pi`, so that `T_i = mean(V Y_i)`. cos**2 is uniform, hence the square root.
    """
    index = np.arange(count)
    return _spiral(index, np.sqrt(1.0 - (index + 0.5) / count))


def _spiral(index: npt.NDArray[np.int_], z: Float64) -> Float64:
    radius = np.sqrt(np.maximum(0.0, 1.0 - z * z))
    azimuth = GOLDEN_ANGLE * index
    return np.stack([radius * np.cos(azimuth), radius * np.sin(azimuth), z], axis=-1)


def random_azimuths(ids: npt.NDArray[np.int64], seed: int) -> Float64:
    """One angle in [0, 2pi) per receiver, a function of (seed, id) and of nothing else.

    It depends neither on the chunk, the thread nor the other receivers, so that bakes can be split and merged.
    The hash is the finaliser of SplitMix64 (Steele, Lea & Flood 2014), run twice.
    """
    with np.errstate(over="ignore"):
        start = _mix(np.uint64(seed % (1 << 64)) + np.uint64(0x9E3779B97F4A7C15))
        bits = _mix(ids.astype(np.uint64) * np.uint64(0x9E3779B97F4A7C15) + start)
    return _fraction(bits) * (2.0 * np.pi)


def hash_fraction(codes: npt.NDArray[np.uint64]) -> Float64:
    """(N,) a number in [0, 1) for each code (N,) uint64, by the same hash, run once."""
    with np.errstate(over="ignore"):
        return _fraction(_mix(codes * np.uint64(0x9E3779B97F4A7C15)))


def _fraction(bits: npt.NDArray[np.uint64]) -> Float64:
    return (bits >> np.uint64(11)).astype(np.float64) / (1 << 53)


def _mix(bits: npt.NDArray[np.uint64] | np.uint64) -> npt.NDArray[np.uint64]:
    z = np.asarray(bits)
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return z ^ (z >> np.uint64(31))


def tangent_frames(normals: Float64, azimuths: Float64) -> Float64:
    """Right-handed frames about unit normals, turned by an azimuth.

    Duff et al. 2017, "Building an Orthonormal Basis, Revisited", listing 3.

    Args:
        normals: (N, 3) unit vectors.
        azimuths: (N,) radians.

    Returns:
        (N, 3, 3) float64; rows are tangent, bitangent, normal, so `world = local @ frame`.
    """
    x, y, z = normals.T
    sign = np.where(z < 0.0, -1.0, 1.0)
    a = -1.0 / (sign + z)
    b = x * y * a
    tangent = np.stack([1.0 + sign * x * x * a, sign * b, -sign * x], axis=-1)
    bitangent = np.stack([b, sign + y * y * a, -y], axis=-1)
    cos, sin = np.cos(azimuths)[:, None], np.sin(azimuths)[:, None]
    return np.stack([cos * tangent + sin * bitangent, cos * bitangent - sin * tangent, normals], axis=1)
