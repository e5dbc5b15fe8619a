# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws the 3D View's PRT tab, panels in Properties, and menus: reads properties and calls operators, nothing else."""

from __future__ import annotations

import bpy

from ..prt_addon.scene.light import picture as light_picture
from . import (
    bake,
    file_menus,
    files,
    gltf,
    light,
    menu,
    notices,
    presets,
    preview,
    properties,
    report,
    shading,
    stale,
    transport,
)

CLASSES = (
    *bake.CLASSES,
    *notices.CLASSES,
    *stale.CLASSES,
    *presets.CLASSES,
    *light.CLASSES,
    *preview.CLASSES,
    *shading.CLASSES,
    *report.CLASSES,
    *transport.CLASSES,
    *files.CLASSES,
    *gltf.CLASSES,
    *properties.CLASSES,
    *menu.CLASSES,
)
_register_classes, _unregister_classes = bpy.utils.register_classes_factory(CLASSES)
_ENTRIES = (presets, menu, file_menus)
"""Modules that put something into Blender's own interface."""


def register() -> None:
    """Add panels and menus, and the entries in Blender's own."""
    _register_classes()
    for module in _ENTRIES:
        module.register()


def unregister() -> None:
    """Remove them, and the small pictures that they drew."""
    for module in reversed(_ENTRIES):
        module.unregister()
    _unregister_classes()
    light_picture.unregister()
