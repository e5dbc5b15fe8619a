# SPDX-License-Identifier: GPL-3.0-or-later
"""Thin operators, `bpy.ops.prt.*`: read settings, call scene and core, report."""

from __future__ import annotations

import bpy

from . import bake, check, cubemap, interchange, light, probe, remove, shading

register, unregister = bpy.utils.register_classes_factory(
    (
        *bake.CLASSES,
        *check.CLASSES,
        *light.CLASSES,
        *shading.CLASSES,
        *remove.CLASSES,
        *interchange.CLASSES,
        *cubemap.CLASSES,
        *probe.CLASSES,
    )
)
