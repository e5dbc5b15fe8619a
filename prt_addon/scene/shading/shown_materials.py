# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds the materials that objects show: those of their slots, those that their node modifiers set, and those of their instances."""

from __future__ import annotations

from collections.abc import Iterable

import bpy

from ..blender.instances import has_nodes, instanced_materials


def materials_of(objects: Iterable[bpy.types.Object], instanced: bool = False) -> list[bpy.types.Material]:
    """All materials that objects show, each once, in order.

    Args:
        objects: whose materials they are.
        instanced: also those of their instances.
    """
    return list(first_users(objects, instanced))


def first_users(
    objects: Iterable[bpy.types.Object], instanced: bool = False
) -> dict[bpy.types.Material, bpy.types.Object]:
    """Each material of the objects once, and the first of them that has it."""
    objects, found = list(objects), dict[bpy.types.Material, bpy.types.Object]()
    of_instances = instanced_materials(set(objects)) if instanced else {}
    for ob in objects:
        of_slots = [slot.material for slot in ob.material_slots if slot.material]
        for material in (*of_slots, *set_by_nodes(ob), *of_instances.get(ob, ())):
            found.setdefault(material, ob)
    return found


def set_by_nodes(ob: bpy.types.Object) -> list[bpy.types.Material]:
    """The materials that node modifiers bring: no slot of the object holds them."""
    if not has_nodes(ob):
        return []
    evaluated = ob.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return [material.original for material in getattr(evaluated.data, "materials", ()) if material]
