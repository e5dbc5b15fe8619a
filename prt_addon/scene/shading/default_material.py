# SPDX-License-Identifier: GPL-3.0-or-later
"""Gives objects and slots without a material a plain one, so that there is one to relight, and takes it from them again."""

from __future__ import annotations

import bpy

from ..blender.nodes import turn_nodes
from .our_nodes import our_nodes
from .shown_materials import set_by_nodes

MADE = "prt_made"
"""Custom property of a material that we made for an object that had none."""
_SLOT_ADDED = "prt_slot_added"
"""Custom property of a mesh whose only slot we added."""


def fill_empty_slots(ob: bpy.types.Object) -> None:
    """Put the plain material where an object shows none: into its empty slots, or a new one if it has no slot."""
    if not ob.material_slots and not set_by_nodes(ob):
        ob.data.materials.append(_made_material())
        ob.data[_SLOT_ADDED] = True
    for slot in ob.material_slots:
        if slot.material is None:
            slot.material = _made_material()


def empty_made_slots(ob: bpy.types.Object) -> None:
    """Take the plain material from an object where it is not relit any more, and from the file once nothing shows it."""
    for index in reversed(range(len(ob.material_slots))):
        material = ob.material_slots[index].material
        if material is None or not material.get(MADE) or any(our_nodes(material.node_tree)):
            continue
        if ob.data.get(_SLOT_ADDED):
            _remove_slot(ob, index)
            del ob.data[_SLOT_ADDED]
        else:
            ob.material_slots[index].material = None
        if not material.users:
            bpy.data.materials.remove(material)


def _made_material() -> bpy.types.Material:
    """The plain material for objects that have none; grey like Blender's own default."""
    for material in bpy.data.materials:
        if material.get(MADE) and material.library is None:
            return material
    material = bpy.data.materials.new("PRT Default")
    turn_nodes(material, True)
    material[MADE] = True
    return material


def _remove_slot(ob: bpy.types.Object, index: int) -> None:
    """Taking the material out of the mesh alone would leave an empty slot on the object."""
    if len(ob.material_slots) == 1:
        ob.data.materials.clear()
        return
    active, ob.active_material_index = ob.active_material_index, index
    with bpy.context.temp_override(object=ob):
        bpy.ops.object.material_slot_remove()
    ob.active_material_index = min(active, len(ob.material_slots) - 1)
