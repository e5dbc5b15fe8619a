# SPDX-License-Identifier: GPL-3.0-or-later
"""The cache of traces saves rays: another colour or number of bounces needs no new ones."""

from dataclasses import replace

import numpy as np
import pytest

from prt_addon.core.bake.cache import TraceCache
from prt_addon.core.bake.run import Run
from prt_addon.core.transport.raycast import RayScene
from tests.core import bouncing
from tests.core.baking import bake


def test_another_colour_or_number_of_bounces_casts_no_ray(monkeypatch):
    """And has the bits of a bake from the start."""
    groups, red = bouncing.corner(6)
    green = bouncing.corner(6, [(0.2, 0.9, 0.2)] * 3)[1]
    caching = Run(traces=TraceCache())
    before = bake(groups, red, bouncing.SETTINGS, caching)
    more = replace(bouncing.SETTINGS, bounces=5)

    def no_rays(*_):
        raise AssertionError("a ray was cast")

    with monkeypatch.context() as patch:
        patch.setattr(RayScene, "hits", no_rays)
        after = bake(groups, green, more, caching)
        with pytest.raises(AssertionError, match="a ray was cast"):
            bake(groups, green, replace(more, samples=65), caching)
    assert all(map(np.array_equal, after, bake(groups, green, more)))
    assert not any(map(np.array_equal, before, after))
