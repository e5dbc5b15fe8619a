# SPDX-License-Identifier: GPL-3.0-or-later
"""Offers presets of the bake's settings, by Blender's own facility: Draft, Good, Final, and those that people add."""

from __future__ import annotations

from pathlib import Path

import bpy
from bl_operators.presets import AddPresetBase
from bl_ui.utils import PresetPanel

from ..prt_addon.scene.settings import BakeProperties

FOLDER = "prt/bake"
_OURS = str(Path(__file__).parent.parent)
"""Holds `presets`, and in that what is shipped."""


class PRT_PT_bake_presets(PresetPanel, bpy.types.Panel):
    """Sets of bake settings to choose from, and to add one's own to"""

    bl_label = "Bake Presets"
    preset_subdir = FOLDER
    preset_operator = "script.execute_preset"
    preset_add_operator = "prt.bake_preset_add"


class PRT_OT_bake_preset_add(AddPresetBase, bpy.types.Operator):
    """Keep the bake settings of this scene as a preset, or remove a preset"""

    bl_idname = "prt.bake_preset_add"
    bl_label = "Add Bake Preset"
    preset_menu = "PRT_PT_bake_presets"
    preset_subdir = FOLDER
    preset_defines = ("settings = bpy.context.scene.prt",)
    preset_values = tuple(f"settings.{name}" for name in BakeProperties.__annotations__)


CLASSES = (PRT_PT_bake_presets, PRT_OT_bake_preset_add)


def register() -> None:
    """Let Blender find what is shipped."""
    bpy.utils.register_preset_path(_OURS)


def unregister() -> None:
    """Undo `register`."""
    bpy.utils.unregister_preset_path(_OURS)
