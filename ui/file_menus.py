# SPDX-License-Identifier: GPL-3.0-or-later
"""Adds other programs' files to File > Import and File > Export, where Blender's users look for them."""

from __future__ import annotations

import bpy

IMPORTS = (
    ("prt.import_cubemap", "Cube Map as World (PRT)"),
    ("prt.import_games202", "GAMES202 Transport (light.txt, transport.txt)"),
)
EXPORTS = (
    ("prt.export_games202", "GAMES202 Transport (light.txt, transport.txt)"),
    ("prt.export_web_page", "PRT Web Page (.html)"),
)


def _draw_imports(self: bpy.types.Menu, _context: bpy.types.Context) -> None:
    for name, text in IMPORTS:
        self.layout.operator(name, text=text)


def _draw_exports(self: bpy.types.Menu, _context: bpy.types.Context) -> None:
    for name, text in EXPORTS:
        self.layout.operator(name, text=text)


def register() -> None:
    """Append the entries."""
    bpy.types.TOPBAR_MT_file_import.append(_draw_imports)
    bpy.types.TOPBAR_MT_file_export.append(_draw_exports)


def unregister() -> None:
    """Remove the entries."""
    bpy.types.TOPBAR_MT_file_import.remove(_draw_imports)
    bpy.types.TOPBAR_MT_file_export.remove(_draw_exports)
