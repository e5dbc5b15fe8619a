# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds the animation curves of data-blocks, as Blender keeps them since 4.4, and makes them linear."""

from __future__ import annotations

from typing import Any

import bpy


def channels(block: bpy.types.ID) -> Any:
    """The animation curves of a data-block; None if it has none."""
    data = block.animation_data
    if not data or not data.action or not data.action.layers:
        return None
    bag = data.action.layers[0].strips[0].channelbag(data.action_slot)
    return bag.fcurves if bag else None


def interpolate_linearly(block: bpy.types.ID, paths: set[str] | None = None) -> None:
    """Make the keyframes of a data-block interpolate linearly.

    Args:
        block: the data-block.
        paths: of what; all that is animated if None.
    """
    for curve in channels(block) or ():
        if paths is None or curve.data_path in paths:
            for point in curve.keyframe_points:
                point.interpolation = "LINEAR"
