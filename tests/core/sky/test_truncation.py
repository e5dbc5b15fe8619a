# SPDX-License-Identifier: GPL-3.0-or-later
"""What nine coefficients lose of a light, against a sum over turns of the sky."""

import numpy as np

from prt_addon.core.sky.truncation import truncation
from prt_addon.core.sphere.directions import fibonacci_sphere
from prt_addon.core.sphere.rotation import rotation_matrix
from prt_addon.core.sphere.sh import basis


def test_truncation_is_that_at_the_foot_of_a_wall():
    """Against a sum over turns of the sky, without the sum over bands."""
    directions = fibonacci_sphere(20000)
    harmonics = basis(directions, 8)
    seen = np.where(directions[:, 0] > 0.0, np.maximum(directions[:, 2], 0.0), 0.0) / np.pi
    transport = 4.0 * np.pi * (seen @ harmonics) / len(directions)
    light = np.random.default_rng(1).normal(size=(81, 1))
    turns = fibonacci_sphere(300)
    shown = []
    for turn in turns:
        x = np.cross(turn, (0.3, 0.5, 0.8))
        for sign in (1.0, -1.0):
            axes = np.stack([sign * x / np.linalg.norm(x), np.cross(turn, sign * x / np.linalg.norm(x)), turn])
            turned = rotation_matrix(axes, 8) @ light[:, 0]
            shown.append([(transport * turned)[9:].sum(), (transport * turned).sum()])
    lost, whole = np.sqrt((np.array(shown) ** 2).mean(axis=0))
    assert abs(truncation(light) / (lost / whole) - 1.0) < 0.25  # 600 turns of all
