# SPDX-License-Identifier: GPL-3.0-or-later
"""Relights the materials that objects show, and restores them; other objects may show them, too."""

from __future__ import annotations

from collections.abc import Iterable

import bpy

from ...core.errors import MeshError
from ...core.notices import Notice
from ..blender.libraries import check_local, is_local
from ..light.receivers import follow_receivers
from ..mesh.carrier import transport_mesh
from ..mesh.layers import has_backs, is_baked
from .default_material import empty_made_slots, fill_empty_slots
from .our_nodes import is_relit, our_nodes
from .relight_group import check_version, remove_unused_group
from .relight_material import relight, remove_from_material
from .shown_materials import first_users, materials_of


def relit_materials(objects: Iterable[bpy.types.Object]) -> list[bpy.types.Material]:
    """The materials that objects show, of instances, too, and this version relights."""
    return [material for material in materials_of(objects, instanced=True) if is_relit(material)]


def check_relit_materials(objects: Iterable[bpy.types.Object]) -> None:
    """Raises MeshError or VersionError for the first material that is relit, and cannot be restored."""
    for material, ob in first_users(objects, instanced=True).items():
        if any(our_nodes(material.node_tree)):
            check_local(material, f"Material '{material.name}' of '{ob.name}'", "remove the shading", MeshError)
            check_version(material)


def add_shading(objects: Iterable[bpy.types.Object], anew: bool = True) -> list[Notice]:
    """Relight every material of the objects and of their instances in EEVEE; objects or slots without a material get one.

    EEVEE links lamps to instances as to what instances them: without the nodes these would show the lamps of the sky twice.

    Args:
        objects: whose materials are relit.
        anew: also those that are relit.

    Returns:
        A notice on each material that is not relit, or not as it looks.
    """
    notices = []
    for material, two_sided in to_relight(objects, anew):
        notices += relight(material, two_sided)
    follow_receivers()
    return notices


def to_relight(objects: Iterable[bpy.types.Object], anew: bool) -> list[tuple[bpy.types.Material, bool]]:
    """The materials that `add_shading` relights, for `relight_material.relight`, after it has filled empty slots.

    Returns:
        Them, each with whether meshes that show it have backs with transport of their own.
    """
    objects = list(objects)
    for ob in objects:
        if is_local(ob.data) and is_local(ob):
            fill_empty_slots(ob)
    two_sided, shown = _two_sided(), materials_of(objects, instanced=True)
    return [(material, material in two_sided) for material in shown if anew or not is_relit(material)]


def _two_sided() -> set[bpy.types.Material]:
    """The materials of all objects whose backs have transport of their own."""
    return set(materials_of(ob for ob in bpy.data.objects if ob.type == "MESH" and has_backs(transport_mesh(ob))))


def remove_shading(objects: Iterable[bpy.types.Object]) -> int:
    """Restore the objects' materials, save those that other baked objects still show; how many of them were ours."""
    objects = list(objects)
    others = (ob for ob in bpy.data.objects if ob.type == "MESH" and ob.users and ob not in objects)
    rest = [ob for ob in others if is_baked(transport_mesh(ob))]
    still_used = set(materials_of(rest, instanced=True))
    shown = materials_of(objects, instanced=True)
    return restore([material for material in shown if material not in still_used], objects)


def remove_all_shading() -> int:
    """Restore all materials of the file, those that no object shows any more, too; how many of them were ours."""
    return restore(filter(is_relit, bpy.data.materials), ())


def restore(materials: Iterable[bpy.types.Material], objects: Iterable[bpy.types.Object]) -> int:
    """Take our nodes out of materials, and from objects the materials that we made; how many of the former were ours."""
    removed = sum(map(remove_from_material, materials))
    for ob in objects:
        empty_made_slots(ob)
    follow_receivers()
    if removed:
        remove_unused_group()
    return removed
