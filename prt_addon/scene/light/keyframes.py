# SPDX-License-Identifier: GPL-3.0-or-later
"""Projects skies frame by frame, and keyframes their light, where they change in what no driver can follow."""

from __future__ import annotations

from collections.abc import Generator, Iterator
from contextlib import contextmanager

import bpy

from ...core.errors import LightError
from ..sky.projection import LightSettings, project
from ..sky.sky import read_sky
from .lamps import keyframe_lamps
from .light import keyframe_light, mark_keyframed, unmark_keyframed, write_light


def keyframes(first: int, last: int, step: int) -> list[int]:
    """The frames to keyframe: every step-th of a range, and the last.

    Raises:
        LightError: if the range is empty.
    """
    if last < first:
        raise LightError(f"There are no frames from {first} to {last}: let the end follow the start.")
    return sorted({*range(first, last + 1, step), last})


def keyframe(scene: bpy.types.Scene, frames: list[int], settings: LightSettings) -> Generator[None]:
    """Project the scene's world at some frames, ascending, and keyframe its light there; the scene stays at its frame.

    Rotation and strength are followed live, as always.

    Args:
        scene: whose world is projected.
        frames: at least one.
        settings: of the projection.

    Yields:
        After each frame is projected. After the last of them it writes. Closed before that,
        nothing was changed.

    Raises:
        LightError, PictureError: if the world cannot be projected at one of the frames; nothing was changed.
    """
    projections = []
    with _browsing(scene, frames[0], frames[-1]):
        for frame in frames:
            scene.frame_set(frame)
            projections.append(project(read_sky(scene), settings))
            yield
    write_light(read_sky(scene), projections[0])
    sky = read_sky(scene)  # with the Mapping node that may have been inserted
    mark_keyframed(scene.world, frames[0], frames[-1])
    keyframe_light(scene.world, frames, projections)
    keyframe_lamps(sky, frames, [projection.lamps for projection in projections])
    scene.frame_set(scene.frame_current, subframe=scene.frame_subframe)  # the light of this frame


@contextmanager
def _browsing(scene: bpy.types.Scene, first: int, last: int) -> Iterator[None]:
    """Inside, frames may be changed, and no light follows them by itself; the scene returns to its frame."""
    now, world = (scene.frame_current, scene.frame_subframe), read_sky(scene).holder
    marked = mark_keyframed(world, first, last)
    try:
        yield
    finally:
        if marked:
            unmark_keyframed(world)
        scene.frame_set(now[0], subframe=now[1])
