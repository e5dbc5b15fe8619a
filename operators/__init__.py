# SPDX-License-Identifier: GPL-3.0-or-later
"""Thin operators, `bpy.ops.prt.*`: read settings, call scene and core, report."""

from __future__ import annotations

import bpy

from . import bake, check, interchange, light, remove, report, shading

register, unregister = bpy.utils.register_classes_factory(
    (
        *bake.CLASSES,
        *check.CLASSES,
        *light.CLASSES,
        *shading.CLASSES,
        *remove.CLASSES,
        *report.CLASSES,
        *interchange.CLASSES,
    )
)
