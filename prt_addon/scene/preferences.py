# SPDX-License-Identifier: GPL-3.0-or-later
"""Defines the extension's preferences: what belongs to the user and the machine, and to no file."""

from __future__ import annotations

import bpy
from bpy.props import FloatProperty

from ..worker.job import PATIENCE

_EXTENSION = __package__.rpartition(".prt_addon")[0]
"""Blender's name of the extension."""


class PRT_AP_preferences(bpy.types.AddonPreferences):
    """What Preferences show of the extension"""

    bl_idname = _EXTENSION

    engine_patience: FloatProperty(  # type: ignore[valid-type]
        name="Keep Engine",
        description="How long the engine's process waits for another bake. It holds what the rays of the latest bakes found, up to "
        "1 GiB, so that another colour or number of bounces needs no new rays. At 0 it ends with each bake",
        default=PATIENCE,
        min=0.0,
        soft_max=3600.0,
        step=6000,
        precision=0,
        subtype="TIME_ABSOLUTE",
        unit="TIME_ABSOLUTE",
    )

    def draw(self, _context: bpy.types.Context) -> None:
        """Draw them in Preferences > Add-ons."""
        column = self.layout.column()
        column.use_property_split = True
        column.prop(self, "engine_patience")


def engine_patience(context: bpy.types.Context) -> float:
    """The seconds that the engine's process waits for another job before it ends."""
    addon = context.preferences.addons.get(_EXTENSION)
    return addon.preferences.engine_patience if addon and addon.preferences else PATIENCE


register, unregister = bpy.utils.register_classes_factory((PRT_AP_preferences,))
