# SPDX-License-Identifier: GPL-3.0-or-later
"""Means over texels are exact where a sky is rough, and cheap where it is smooth."""

import numpy as np
import pytest

from prt_addon.core.sky import projection as envmap
from prt_addon.core.sky.texel_means import equirect_means
from prt_addon.core.sphere import sh
from tests.core.references import random_directions

SUN = np.radians(0.2725)
"""Half the sun's width."""


def disc(towards, radius, radiance=1e5):
    """A disc on a sky of one, and how often it was looked at; by the sine, as float32 loses small angles' cosines."""
    looks = []

    def look(directions):
        looks.append(len(directions))
        exact = directions.astype(np.float64)
        exact /= np.linalg.norm(exact, axis=1)[:, None]
        inside = (np.linalg.norm(np.cross(exact, towards), axis=1) < np.sin(radius)) & (exact @ towards > 0)
        return np.repeat(np.where(inside, radiance, 1.0)[:, None], 3, axis=1).astype(np.float32)

    return look, looks


@pytest.mark.parametrize("towards", [*random_directions(3), np.array([0.0, 0.0, 1.0])])
@pytest.mark.parametrize("radius", [SUN, np.radians(5.0)])
def test_discs(towards, radius):
    """A sun is as bright, and where, it should be, also at the pole; for not much more than one look per texel."""
    look, looks = disc(towards, radius)
    light = envmap.project_equirect(equirect_means(look))[:, 0]
    height = 1 - np.cos(radius)
    cap = 2 * np.pi * height * np.array([1, (2 - height) / 2, (1 - height) * (2 - height) / 2])  # of P_0, P_1, P_2
    wanted = (1e5 - 1) * sh.basis(towards) * sh.per_coefficient(cap)
    wanted[0] += np.sqrt(4 * np.pi)
    assert np.abs(light - wanted).max() / np.abs(wanted).max() < 5e-4
    assert sum(looks) < (2.0 if abs(towards[2]) < 1 else 5.0) * 512 * 1024


def test_smooth_skies_are_looked_at_once():
    """What does not change between neighbours is not cut."""
    looks = []

    def look(directions):
        looks.append(len(directions))
        return 1.0 + directions

    means = equirect_means(look, height=128)
    assert looks == [128 * 256]
    light = envmap.project_equirect(means)
    assert np.allclose(light[[3, 1, 2]], np.eye(3) * np.sqrt(4 * np.pi / 3), atol=1e-3)


def test_pictures_are_hit_in_the_centres_of_their_texels():
    """Where the picture is as large: nothing is blended, and rows start at the bottom."""
    rows, columns = np.indices((4, 8))

    def look(directions):
        row = ((0.5 + np.arcsin(directions[:, 2]) / np.pi) * 4).astype(int)
        column = ((0.5 - np.arctan2(directions[:, 1], directions[:, 0]) / (2 * np.pi)) * 8).astype(int)
        return np.stack([row, column, 0 * row], axis=-1).astype(np.float32)

    means = equirect_means(look, height=4)
    assert np.allclose(means[..., 0], rows, atol=0.01) and np.allclose(means[..., 1], columns, atol=0.01)


def test_same_bits_again():
    """The places within cells are no dice."""
    look, _ = disc(np.array([0.6, 0.0, 0.8]), SUN)
    assert np.array_equal(equirect_means(look, height=64), equirect_means(look, height=64))
