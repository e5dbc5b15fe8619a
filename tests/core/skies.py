# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes skies with a sun, and computes what convex surfaces lose of them in few bands, by no code of the engine."""

import numpy as np
from numpy.polynomial import Legendre
from numpy.polynomial.legendre import leggauss, legval

AROUND = 0.5
"""Radiance of a grey sky around its sun."""


def texels(height):
    """(H, 2 H, 3) directions of the middles of a panorama's texels, and (H, 1) their solid angles."""
    edges = np.sin(np.pi * (np.arange(height + 1) / height - 0.5))
    middles = directions(np.arange(height)[:, None] + 0.5, np.arange(2 * height) + 0.5, height)
    return middles, np.pi / height * np.diff(edges)[:, None]


def directions(rows, columns, height):
    """(..., 3) unit vectors to places in a panorama, in texels from its lower left corner."""
    azimuth, elevation = np.pi - np.pi * columns / height, np.pi * rows / height - np.pi / 2.0
    parts = np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)
    return np.stack(np.broadcast_arrays(*parts), axis=-1)


def with_disc(height, towards, radius, times, around=AROUND):
    """(H, 2 H, 3) a grey sky, and in it a disc of so many radians that is so many times as bright; its rim is blended."""
    towards = np.asarray(towards) / np.linalg.norm(towards)
    middles, _ = texels(height)
    row, column = np.nonzero(middles @ towards > np.cos(radius + 2.0 * np.pi / height))
    places = (np.arange(64) + 0.5) / 64
    inside = directions(row[:, None, None] + places[:, None], column[:, None, None] + places, height)
    area = np.sqrt(1.0 - inside[..., 2] ** 2)
    covered = (area * (inside @ towards > np.cos(radius))).sum(axis=(1, 2)) / area.sum(axis=(1, 2))
    picture = np.full((height, 2 * height, 3), around)
    picture[row, column] *= 1.0 + (times - 1.0) * covered[:, None]
    return picture.astype(np.float32)


def share_of_disc(radius, times):
    """Of all light of such a sky: the cap's solid angle is `2 pi (1 - cos radius)`."""
    cap = 2.0 * np.pi * (1.0 - np.cos(radius))
    return times * cap / (times * cap + 4.0 * np.pi - cap)


def mean(picture):
    """Radiance of a panorama all around, over the channels."""
    _, area = texels(len(picture))
    return float((picture.astype(float) * area[..., None]).sum() / (4.0 * np.pi * 3))


def with_band(picture, band, amount):
    """A panorama times `1 + amount P_band(z)`."""
    middles, _ = texels(len(picture))
    return (picture * (1.0 + amount * Legendre.basis(band)(middles[..., 2:]))).astype(np.float32)


def losses(shown, whole, orders, normals=2000):
    """What convex surfaces that face all ways lose of a sky beyond each order: RMS, as a share of that of all light.

    Irradiance is the sum over all texels, weighed by the cosine: cut off after a band, by that much of its Legendre series.
    Shaders show nothing below 0.

    Args:
        shown: (H, W, 3) what is cut off after a band.
        whole: (H, W, 3) what the share is of.
        orders: last bands that are kept.
        normals: how many, on a spiral.
    """
    z = 1.0 - (2.0 * np.arange(normals) + 1.0) / normals
    turn = np.pi * (1.0 + np.sqrt(5.0)) * np.arange(normals)
    spiral = np.stack([np.sqrt(1.0 - z * z) * np.cos(turn), np.sqrt(1.0 - z * z) * np.sin(turn), z], axis=-1)
    middles, area = texels(len(shown))
    cosines = spiral @ middles.reshape(-1, 3).T
    exact = np.maximum(cosines, 0.0)
    flux, all_flux = ((picture.astype(float) * area[..., None]).reshape(-1, 3) for picture in (shown, whole))
    everything = np.sqrt(((exact @ all_flux) ** 2).mean())
    lost = {}
    for order in orders:
        kept = legval(cosines, [(2 * band + 1) / 2.0 * _of_the_cosine(band) for band in range(order + 1)])
        lost[order] = np.sqrt(((np.maximum(kept @ flux, 0.0) - exact @ flux) ** 2).mean()) / everything
    return lost


def _of_the_cosine(band):
    """Integral of `max(t, 0) P_band(t)` over t, which is a polynomial where it is not 0."""
    t, weight = leggauss(16)
    t, weight = (t + 1.0) / 2.0, weight / 2.0
    return float((weight * t * Legendre.basis(band)(t)).sum())
