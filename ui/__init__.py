# SPDX-License-Identifier: GPL-3.0-or-later
"""What is seen: the PRT tab of the 3D View's sidebar. Reads properties and calls operators, nothing else."""

from __future__ import annotations

import bpy

from . import bake, files, light, report, shading

register, unregister = bpy.utils.register_classes_factory(
    (*bake.CLASSES, *light.CLASSES, *shading.CLASSES, *report.CLASSES, *files.CLASSES)
)
