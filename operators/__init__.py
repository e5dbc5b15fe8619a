# SPDX-License-Identifier: GPL-3.0-or-later
"""Thin operators, `bpy.ops.prt.*`: read settings, call scene and core, report."""

from __future__ import annotations

import bpy

from . import bake, check, interchange, light, remove, shading

CLASSES = (
    *bake.CLASSES,
    *check.CLASSES,
    *light.CLASSES,
    *shading.CLASSES,
    *remove.CLASSES,
    *interchange.CLASSES,
)
"""In the order of the menu."""
register, unregister = bpy.utils.register_classes_factory(CLASSES)
