# SPDX-License-Identifier: GPL-3.0-or-later
"""Says what objects show by instances: of collections, by geometry nodes, particles, vertices or faces."""

from __future__ import annotations

from collections.abc import Collection

import bpy


def may_instance(ob: bpy.types.Object) -> bool:
    """Whether an object may show instances."""
    return ob.is_instancer or has_nodes(ob) or bool(ob.particle_systems)


def has_nodes(ob: bpy.types.Object) -> bool:
    """Whether an object has a modifier of geometry nodes."""
    return any(modifier.type == "NODES" for modifier in ob.modifiers)


def instanced_materials(
    objects: Collection[bpy.types.Object], depsgraph: bpy.types.Depsgraph | None = None
) -> dict[bpy.types.Object, list[bpy.types.Material]]:
    """The materials that objects show by instances.

    Args:
        objects: that may show instances.
        depsgraph: of the scene that shows them; without one, that of the context.

    Returns:
        For each of them that shows any, its instances' materials, each once.
    """
    if not any(map(may_instance, objects)):
        return {}  # evaluating a scene takes long, and it may show a hundred thousand instances
    found: dict[bpy.types.Object, dict[bpy.types.Material, None]] = {}
    for instance in (depsgraph or bpy.context.evaluated_depsgraph_get()).object_instances:
        if not instance.is_instance or instance.parent.original not in objects:
            continue
        shown = [slot.material for slot in instance.object.material_slots]
        found.setdefault(instance.parent.original, {}).update({one.original: None for one in shown if one})
    return {ob: list(materials) for ob, materials in found.items()}
