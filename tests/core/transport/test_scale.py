# SPDX-License-Identifier: GPL-3.0-or-later
"""Large scenes keep small gaps: a backdrop far away changes nothing about what lies close together."""

import numpy as np
import pytest

from prt_addon.core.problem import BakeSettings, Occluders, ReceiverGroup
from tests.core import shapes
from tests.core.baking import bake

OPEN = np.sqrt(1.0 / (4.0 * np.pi))


def plate_over_floor(gap, away=None, unit=1.0, faces=1):
    """T_0 in the middle of a floor of 2 x 2 under a plate of 1 x 1 in a gap; with a wall of 2 km so far away, if wanted.

    faces: of the wall along each side.
    """
    floor, plate = shapes.grid(16, 2.0), shapes.grid(4, 1.0)
    meshes = [floor, (plate[0] + (0, 0, gap), plate[1])]
    if away is not None:
        wall = shapes.grid(faces, 2000.0)
        meshes.append((wall[0][:, [2, 0, 1]] + (away, 0, 500.0), wall[1]))
    occluders = Occluders(shapes.joined(*meshes)[0] * unit, shapes.joined(*meshes)[1])
    points = floor[0] * unit
    group = ReceiverGroup("Floor", points, np.tile((0.0, 0.0, 1.0), (len(points), 1)), np.sqrt(2.0) * unit)
    [transport] = bake([group], occluders, BakeSettings("SHADOWED", 1024, 1))
    return transport[np.argmin(np.linalg.norm(points, axis=1)), 0] / OPEN


@pytest.mark.parametrize("unit", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("faces", [1, 100])
@pytest.mark.parametrize("gap", [0.003, 0.03])
def test_a_backdrop_far_away_lets_no_light_under_a_plate(gap, faces, unit):
    """The middle of the floor sees the sky beside the plate alone: a share of about (2 gap / side)^2, whatever the unit."""
    alone, with_backdrop = plate_over_floor(gap, None, unit), plate_over_floor(gap, 10_000.0, unit, faces)
    assert alone < 0.01 and abs(with_backdrop - alone) < 2e-3
