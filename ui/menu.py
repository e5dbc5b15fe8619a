# SPDX-License-Identifier: GPL-3.0-or-later
"""Object > PRT: all operators, which F3 finds because they are in a menu; and File > Export > PRT Web Page."""

from __future__ import annotations

import bpy

from .. import operators
from ..prt_addon.scene.sky.studio import free_icons, icon_of, load_icons, studio_skies

_CHOICES = {"prt.show_light": "kind", "prt.show_transport": "part"}
"""Operators that are menus of what one of their arguments can be."""


class PRT_MT_skies(bpy.types.Menu):
    """The HDRIs that Blender ships, to light the world with"""

    bl_idname = "PRT_MT_skies"
    bl_label = "Choose a Sky"

    def draw(self, _context: bpy.types.Context) -> None:
        for name in studio_skies():
            self.layout.operator("prt.use_sky", text=name.title(), icon_value=icon_of(name)).sky = name


class PRT_MT_object(bpy.types.Menu):
    """Bake, check, relight and remove precomputed radiance transfer"""

    bl_idname = "PRT_MT_object"
    bl_label = "PRT"

    def draw(self, _context: bpy.types.Context) -> None:
        for operator in operators.CLASSES:
            if operator.bl_idname in _CHOICES:
                self.layout.operator_menu_enum(operator.bl_idname, _CHOICES[operator.bl_idname])
            elif operator.bl_idname == "prt.use_sky":
                self.layout.menu(PRT_MT_skies.bl_idname)
            elif "INTERNAL" not in getattr(operator, "bl_options", ()):
                self.layout.operator(operator.bl_idname)


def _draw_entry(self: bpy.types.Menu, _context: bpy.types.Context) -> None:
    self.layout.separator()
    self.layout.menu(PRT_MT_object.bl_idname)


def _draw_export(self: bpy.types.Menu, _context: bpy.types.Context) -> None:
    self.layout.operator("prt.export_web_page", text="PRT Web Page (.html)")


CLASSES = (PRT_MT_skies, PRT_MT_object)


def register() -> None:
    """Append the entries."""
    load_icons()
    bpy.types.VIEW3D_MT_object.append(_draw_entry)
    bpy.types.TOPBAR_MT_file_export.append(_draw_export)


def unregister() -> None:
    """Take them out."""
    bpy.types.TOPBAR_MT_file_export.remove(_draw_export)
    bpy.types.VIEW3D_MT_object.remove(_draw_entry)
    free_icons()
