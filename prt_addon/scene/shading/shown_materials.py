# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds the materials that objects show: those of their slots, and those that their node modifiers set."""

from __future__ import annotations

from collections.abc import Iterable

import bpy


def materials_of(objects: Iterable[bpy.types.Object]) -> list[bpy.types.Material]:
    """All materials that objects show, each once, in order."""
    return list(first_users(objects))


def first_users(objects: Iterable[bpy.types.Object]) -> dict[bpy.types.Material, bpy.types.Object]:
    """Each material of the objects once, and the first of them that has it."""
    found: dict[bpy.types.Material, bpy.types.Object] = {}
    for ob in objects:
        for material in [slot.material for slot in ob.material_slots] + set_by_nodes(ob):
            if material:
                found.setdefault(material, ob)
    return found


def set_by_nodes(ob: bpy.types.Object) -> list[bpy.types.Material]:
    """The materials that node modifiers bring: no slot of the object holds them."""
    if not any(modifier.type == "NODES" for modifier in ob.modifiers):
        return []
    evaluated = ob.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return [material.original for material in getattr(evaluated.data, "materials", ()) if material]
