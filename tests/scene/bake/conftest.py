# SPDX-License-Identifier: GPL-3.0-or-later
"""Puts a ground that is selected, and a floor that is not, under a sky of six colours."""

import pytest


@pytest.fixture
def ground(scene, stage):
    stage.environment(stage.picture("Sky", stage.six_coloured_sky(16)))
    ob = stage.object_of("Ground", stage.grid(2, 0.5))
    ob.select_set(True)
    return ob


@pytest.fixture
def floor(scene, stage):
    """A floor at the origin that sees all of the sky."""
    stage.environment(stage.picture("Sky", stage.six_coloured_sky(16)))
    return stage.object_of("Floor", stage.grid(4, 0.5))
