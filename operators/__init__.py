# SPDX-License-Identifier: GPL-3.0-or-later
"""Defines `bpy.ops.prt.*`: thin operators that read settings, call scene and core, and report."""

from __future__ import annotations

import bpy

from . import (
    bake,
    check,
    cubemap,
    energy,
    freeze,
    info,
    interchange,
    job,
    light,
    notices,
    probe,
    refine,
    reflections,
    remove,
    report,
    shading,
    shards,
    sky,
    transport,
    web_page,
)

CLASSES = (
    *bake.CLASSES,
    *job.CLASSES,
    *shards.CLASSES,
    *refine.CLASSES,
    *notices.CLASSES,
    *check.CLASSES,
    *light.CLASSES,
    *sky.CLASSES,
    *probe.CLASSES,
    *shading.CLASSES,
    *reflections.CLASSES,
    *energy.CLASSES,
    *report.CLASSES,
    *transport.CLASSES,
    *remove.CLASSES,
    *cubemap.CLASSES,
    *freeze.CLASSES,
    *interchange.CLASSES,
    *web_page.CLASSES,
    *info.CLASSES,
)
register, _unregister = bpy.utils.register_classes_factory(CLASSES)


def unregister() -> None:
    """Blender drops an operator that watches a bake without a word to it."""
    job.stop_watching(bpy.context)
    _unregister()
