# SPDX-License-Identifier: GPL-3.0-or-later
"""What is seen: the PRT tab of the 3D View's sidebar. Reads properties and calls operators, nothing else."""

from __future__ import annotations

import bpy

from ..prt_addon.scene import light_picture
from . import bake, files, light, preview, shading

register, _unregister_classes = bpy.utils.register_classes_factory(
    (*bake.CLASSES, *light.CLASSES, *preview.CLASSES, *shading.CLASSES, *files.CLASSES)
)


def unregister() -> None:
    _unregister_classes()
    light_picture.unregister()
