# SPDX-License-Identifier: GPL-3.0-or-later
"""Adds Object > PRT with all operators, which F3 finds because they are in a menu, and File > Export > PRT Web Page."""

from __future__ import annotations

import bpy

from ..prt_addon.scene.sky.studio import free_icons, icon_of, load_icons, studio_skies

GROUPS = (
    (
        ("prt.bake", "RENDER_STILL"),
        ("prt.check", "CHECKMARK"),
        ("prt.bake_stale", "FILE_REFRESH"),
        ("prt.refine", "MOD_SUBSURF"),
        ("prt.report", "VIEWZOOM"),
        ("prt.show_transport", "COLOR"),
        ("prt.hide_transport", "X"),
    ),
    (
        ("prt.project_light", "WORLD"),
        ("PRT_MT_skies", "LIGHT_SUN"),
        ("prt.keyframe_light", "KEYTYPE_KEYFRAME_VEC"),
        ("prt.show_light", "SHADING_RENDERED"),
    ),
    (
        ("prt.add_shading", "ADD"),
        ("prt.remove_shading", "REMOVE"),
        ("prt.add_reflections", "MOD_MIRROR"),
        ("prt.remove_reflections", "X"),
        ("prt.add_energy_compensation", "NODE_MATERIAL"),
        ("prt.remove_energy_compensation", "X"),
        ("prt.freeze", "FREEZE"),
    ),
    (
        ("prt.bake_shard", "NETWORK_DRIVE"),
        ("prt.merge_shards", "FILE_TICK"),
    ),
    (
        ("prt.import_cubemap", "IMPORT"),
        ("prt.import_games202", "IMPORT"),
        ("prt.export_games202", "EXPORT"),
        ("prt.export_web_page", "EXPORT"),
    ),
    (("prt.copy_info", "COPYDOWN"), ("prt.remove", "TRASH")),
)
"""Operators, and a menu, with their icons: bake, light, surfaces, farms, files, help and the way back."""
_CHOICES = {"prt.show_light": "kind", "prt.show_transport": "part"}
"""Operators that open a submenu of one of their properties."""


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
        for number, group in enumerate(GROUPS):
            if number:
                self.layout.separator()
            for name, icon in group:
                if name in _CHOICES:
                    self.layout.operator_menu_enum(name, _CHOICES[name], icon=icon)
                elif name == PRT_MT_skies.bl_idname:
                    self.layout.menu(name, icon=icon)
                else:
                    self.layout.operator(name, icon=icon)


def _draw_entry(self: bpy.types.Menu, _context: bpy.types.Context) -> None:
    self.layout.separator()
    self.layout.menu(PRT_MT_object.bl_idname)


CLASSES = (PRT_MT_skies, PRT_MT_object)


def register() -> None:
    """Append the entries."""
    load_icons()
    bpy.types.VIEW3D_MT_object.append(_draw_entry)


def unregister() -> None:
    """Remove the entries."""
    bpy.types.VIEW3D_MT_object.remove(_draw_entry)
    free_icons()
