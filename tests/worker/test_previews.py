# SPDX-License-Identifier: GPL-3.0-or-later
"""Previews arrive in their order, hold nothing up, and change no bit of the result."""

import os
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from prt_addon.core.problem import BakeSettings
from prt_addon.session import session
from tests.core import baking
from tests.core.bouncing import Scene
from tests.worker.jobs import SETTINGS, bake, pid


def tiled(group, times):
    """The same receivers, many times."""
    return replace(group, points=np.tile(group.points, (times, 1)), normals=np.tile(group.normals, (times, 1)))


def unheard(scene, settings):
    """A job with previews that the engine has and Blender has heard nothing of."""
    one = bake(scene, settings, previews=True)
    one.start()
    while not (session.engine._ready and session.engine._sent):
        one.wait(0.001)
    assert one.take_shown() is None
    return one


def spent(process):
    """Processor seconds that it has used so far."""
    ticks = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[11:13]
    return sum(map(int, ticks)) / os.sysconf("SC_CLK_TCK")


def test_previews_arrive_before_the_result(scene: Scene):
    """In their order, and the result has the bits of one without them."""
    settings, seen = replace(SETTINGS, samples=4096), []
    one = bake(scene, settings, previews=True)
    one.start()
    while one.running:
        one.wait(0.01)
        if shown := one.take_shown():
            assert one.done.rays < one.work.rays and one.take_shown() is None
            seen.append(shown.settings.samples)
    assert seen and seen == sorted(seen) and seen[-1] == 256
    assert all(map(np.array_equal, one.result().transport, baking.bake(*scene, settings)))


def test_a_preview_that_nobody_takes_holds_up_nothing(scene):
    """Blender may be away: the engine works on beside a preview larger than what a pipe holds, and its end arrives whole."""
    groups, occluders = scene
    many = [tiled(groups[0], 400)]
    settings = BakeSettings("SHADOWED", 160)
    one = unheard((many, occluders), settings)
    seconds = [spent(pid())]
    while (
        len(seconds) < 6 or seconds[-1] > seconds[-6]
    ):  # until half a second goes by without work: all is done but its answer
        time.sleep(0.1)
        seconds.append(spent(pid()))
    assert one.running and not one.done.rays
    one.wait()
    assert one.take_shown().samples == 160
    assert all(map(np.array_equal, one.result().transport, baking.bake(many, occluders, settings)))
    assert spent(pid()) - seconds[-1] < 0.2 * (seconds[-1] - seconds[0])


def test_of_previews_that_wait_the_latest_comes(scene):
    """Blender has been away for three of them: it gets the first, which was on its way, and then the third."""
    groups, occluders = scene
    one = unheard(([tiled(groups[0], 200)], occluders), BakeSettings("SHADOWED", 1 << 13))
    begun = spent(pid())
    while spent(pid()) < begun + 4.0:  # the three take one
        time.sleep(0.1)
    seen: list[int] = []
    while len(seen) < 2:
        one.wait(0.001)
        if shown := one.take_shown():
            seen.append(shown.settings.samples)
    assert one.running and seen == [16, 256]
