# SPDX-License-Identifier: GPL-3.0-or-later
"""Links the lamps of skies to what is relit, by Blender's light linking: all else gets EEVEE's own light of the sky, with all its spots.

A collection that is in no scene holds what is linked. Blender keeps what a collection holds, so that deleted objects are let go.
EEVEE lights an instance as its instancer is linked, so that instancers of what is relit are linked, too.
"""

from __future__ import annotations

import bpy

from ..blender.instances import has_nodes, instanced_materials, may_instance
from ..blender.libraries import is_local
from ..material.reading import OURS
from ..mesh.carrier import is_carrier, transport_mesh
from ..mesh.layers import is_baked

_RECEIVERS = "PRT Lamp Receivers"
"""Name of the collection, and its mark as a custom property."""


def receivers() -> bpy.types.Collection | None:
    """The collection of what lamps of skies light; None if there is none."""
    return next((one for one in bpy.data.collections if _RECEIVERS in one and is_local(one)), None)


def receivers_with(always: bpy.types.Object) -> bpy.types.Collection:
    """The collection, made if there is none.

    Args:
        always: an object that it holds whatever is relit: lamps that are linked to an empty collection light everything.
    """
    collection = receivers()
    if collection is None:
        collection = bpy.data.collections.new(_RECEIVERS)
        collection[_RECEIVERS] = True
    if always.name not in collection.objects:
        collection.objects.link(always)
    return collection


def remove_unused_receivers() -> None:
    """Remove the collection, once no lamp is linked to it."""
    collection = receivers()
    if collection and not collection.users:
        bpy.data.collections.remove(collection)


def follow_receivers(depsgraph: bpy.types.Depsgraph | None = None) -> None:
    """Link all lamps of skies to what is relit now, and to nothing else.

    Args:
        depsgraph: that says what instances its scene shows; without one, that of the context.
    """
    collection = receivers()
    if collection is None:
        return
    wanted = _wanted(collection, depsgraph)
    linked = {ob for ob in collection.objects if ob.type != "EMPTY" or ob.is_instancer}
    for ob in linked - wanted:
        collection.objects.unlink(ob)
    for ob in wanted - linked:
        collection.objects.link(ob)


def _wanted(collection: bpy.types.Collection, depsgraph: bpy.types.Depsgraph | None) -> set[bpy.types.Object]:
    """All objects of scenes that show what is relit."""
    materials = {material for material in bpy.data.materials if _is_relit(material)}
    in_scenes = {ob for scene in bpy.data.scenes for ob in scene.objects}
    relit = {ob for ob in in_scenes if ob.type == "MESH" and not is_carrier(ob) and _shows(ob, materials)}
    here = set((depsgraph or bpy.context).scene.objects)
    instancers = {ob for ob, shown in instanced_materials(here, depsgraph).items() if not materials.isdisjoint(shown)}
    elsewhere = {ob for ob in collection.objects if ob in in_scenes - here and may_instance(ob)}
    return relit | instancers | elsewhere


def _is_relit(material: bpy.types.Material) -> bool:
    return material.node_tree is not None and any(OURS in node for node in material.node_tree.nodes)


def _shows(ob: bpy.types.Object, materials: set[bpy.types.Material]) -> bool:
    """Whether an object shows one of the materials: in a slot, or, if it is baked, by the nodes of a modifier."""
    if any(slot.material in materials for slot in ob.material_slots):
        return True
    return has_nodes(ob) and is_baked(transport_mesh(ob)) and bool(materials)
