# SPDX-License-Identifier: GPL-3.0-or-later
"""Hooking the relight group into materials, beside the user's own nodes, and taking it out again.

The group feeds a Material Output whose target is EEVEE. The user's own output, links and nodes are not touched:
Cycles still renders them, and removing our two nodes restores the material.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import bpy

from ..core.errors import MeshError
from .libraries import check_own
from .nodes import HAD_NO_NODES, diffuse_colour, feeding_socket, nodes_are_on, turn_nodes, uses_nodes
from .relight_group import check_version, is_newer, is_relight_group, relight_group
from .transport_layers import is_baked

OUTPUT = "PRT Output"
MADE = "prt_made"
"""Custom property of a material that we made for an object that had none."""
_ADD = "add the shading"
_WERE_ACTIVE = "prt_were_active"
_SLOT_ADDED = "prt_slot_added"


def materials_of(objects: Iterable[bpy.types.Object]) -> list[bpy.types.Material]:
    """All materials in the objects' slots, each once, in order."""
    return [material for material, _ in _first_users(objects)]


def check_materials(objects: Iterable[bpy.types.Object]) -> None:
    """Raises MeshError for the first material, or mesh that lacks one, that cannot be changed; VersionError for the
    first that a newer version relights.
    """
    objects = list(objects)
    for ob in objects:
        if not ob.material_slots or any(slot.material is None for slot in ob.material_slots):
            check_own(ob.data, f"Mesh '{ob.data.name}' of '{ob.name}' needs a material, but", _ADD, MeshError)
    for material, ob in _first_users(objects):
        _check_material(material, ob, _ADD)


def check_relit_materials(objects: Iterable[bpy.types.Object]) -> None:
    """The same for the first material that is relit, and cannot be restored."""
    for material, ob in _first_users(objects):
        if any(our_nodes(material.node_tree)):
            _check_material(material, ob, "remove the shading")


def _first_users(objects: Iterable[bpy.types.Object]) -> list[tuple[bpy.types.Material, bpy.types.Object]]:
    """Each material of the objects once, and the first of them that has it."""
    found: dict[bpy.types.Material, bpy.types.Object] = {}
    for ob in objects:
        for slot in ob.material_slots:
            if slot.material:
                found.setdefault(slot.material, ob)
    return list(found.items())


def _check_material(material: bpy.types.Material, ob: bpy.types.Object, then: str) -> None:
    check_own(material, f"Material '{material.name}' of '{ob.name}'", then, MeshError)
    check_version(material)


def add_shading(objects: Iterable[bpy.types.Object]) -> list[str]:
    """Relight every material of the objects in EEVEE; objects or slots without a material get one.

    Returns:
        Warnings, one sentence each.
    """
    objects = list(objects)
    for ob in objects:
        _fill_empty_slots(ob)
    warnings = []
    for material in materials_of(objects):
        remove_from_material(material)
        if not _add_to_material(material):
            warnings.append(
                f"Material '{material.name}' has no Principled or Diffuse BSDF whose colour could be used: it is relit in grey."
            )
    return warnings


def remove_shading(objects: Iterable[bpy.types.Object]) -> bool:
    """Restore the objects' materials, save those that other baked objects still show; True if any was ours."""
    objects = list(objects)
    rest = {ob for ob in bpy.data.objects if ob.type == "MESH" and ob not in objects and is_baked(ob.data)}
    still_used = set(materials_of(rest))
    removed = False
    for material in materials_of(objects):
        if material not in still_used:
            removed |= remove_from_material(material)
    for ob in objects:
        _empty_made_slots(ob)
    return removed


def our_nodes(tree: bpy.types.NodeTree | None) -> Iterator[bpy.types.Node]:
    """The nodes we added to a material's tree."""
    for node in tree.nodes if tree else ():
        is_group = node.bl_idname == "ShaderNodeGroup" and is_relight_group(node.node_tree)
        if is_group or _WERE_ACTIVE in node:
            yield node


def remove_from_material(material: bpy.types.Material) -> bool:
    """Take our nodes out of a material and restore which output was active; True if there were any."""
    tree = material.node_tree
    ours = list(our_nodes(tree))
    were_active = {name for node in ours for name in node.get(_WERE_ACTIVE, "").split("\n")}
    for node in ours:
        tree.nodes.remove(node)
    if ours:
        for output in _outputs(tree):
            output.is_active_output = output.name in were_active
    if material.get(HAD_NO_NODES):
        turn_nodes(material, False)
        del material[HAD_NO_NODES]
    return bool(ours)


def follow_base_colour(material: bpy.types.Material) -> None:
    """Feed the relit surface with what the user's own shader now has for a base colour, if it has changed.

    Textures and nodes are linked and need no following; a plain number cannot be linked, and a driver from a material
    to itself would be a dependency cycle.
    """
    groups = (node for node in our_nodes(material.node_tree) if node.bl_idname == "ShaderNodeGroup")
    group = next((node for node in groups if not is_newer(node.node_tree)), None)
    albedo = diffuse_colour(material.node_tree.get_output_node("CYCLES")) if group else None
    if albedo and uses_nodes(material):
        _feed_base_colour(material.node_tree, group, albedo)


def _feed_base_colour(tree: bpy.types.NodeTree, group: bpy.types.Node, albedo: bpy.types.NodeSocket) -> None:
    entry, source = group.inputs["Base Color"], feeding_socket(albedo)
    if source != feeding_socket(entry):
        for link in list(entry.links):
            tree.links.remove(link)
        if source:
            tree.links.new(source, entry)
    if not source and tuple(entry.default_value) != tuple(albedo.default_value):
        entry.default_value = albedo.default_value


def _add_to_material(material: bpy.types.Material) -> bool:
    """Add our two nodes; False if no base colour was found for them."""
    plain = not nodes_are_on(material)
    if plain:
        material[HAD_NO_NODES] = True
        turn_nodes(material, True)
    tree = material.node_tree
    output = tree.get_output_node("EEVEE")

    group = tree.nodes.new("ShaderNodeGroup")
    group.node_tree, group.name, group.label, group.width = relight_group(), "PRT Relight", "PRT Relight", 200.0
    active = [node.name for node in _outputs(tree) if node.is_active_output]
    ours = tree.nodes.new("ShaderNodeOutputMaterial")
    ours.target, ours.name, ours.label = "EEVEE", OUTPUT, "PRT (EEVEE)"
    ours[_WERE_ACTIVE] = "\n".join(active)
    tree.links.new(group.outputs["Surface"], ours.inputs["Surface"])
    if output:
        _share_links(tree, output, ours, group)
    for node in (group, ours):
        node.select = False
    ours.is_active_output = True

    albedo = diffuse_colour(output)
    if plain:
        group.inputs["Base Color"].default_value = material.diffuse_color
    elif albedo:
        _feed_base_colour(tree, group, albedo)
    return plain or albedo is not None


def _outputs(tree: bpy.types.NodeTree) -> list[bpy.types.Node]:
    return [node for node in tree.nodes if node.bl_idname == "ShaderNodeOutputMaterial"]


def _share_links(tree: bpy.types.NodeTree, output: bpy.types.Node, ours: bpy.types.Node, group: bpy.types.Node) -> None:
    """Feed the user's surface to unbaked meshes, and the user's displacement and volume to our output."""
    group.location = (output.location.x, output.location.y - 260.0)
    ours.location = (output.location.x + 240.0, output.location.y - 260.0)
    for entry in output.inputs:
        source = feeding_socket(entry)
        if source:
            tree.links.new(source, group.inputs["Unbaked"] if entry.name == "Surface" else ours.inputs[entry.name])


def _fill_empty_slots(ob: bpy.types.Object) -> None:
    if not ob.material_slots:
        ob.data.materials.append(_made_material())
        ob.data[_SLOT_ADDED] = True
    for slot in ob.material_slots:
        if slot.material is None:
            slot.material = _made_material()


def _made_material() -> bpy.types.Material:
    """The plain material for objects that have none; grey like Blender's own default."""
    for material in bpy.data.materials:
        if material.get(MADE) and material.library is None:
            return material
    material = bpy.data.materials.new("PRT Default")
    turn_nodes(material, True)
    material[MADE] = True
    return material


def _empty_made_slots(ob: bpy.types.Object) -> None:
    for index in reversed(range(len(ob.material_slots))):
        material = ob.material_slots[index].material
        if material is None or not material.get(MADE) or any(our_nodes(material.node_tree)):
            continue
        if ob.data.get(_SLOT_ADDED):
            ob.data.materials.pop(index=index)
            del ob.data[_SLOT_ADDED]
        else:
            ob.material_slots[index].material = None
        if not material.users:
            bpy.data.materials.remove(material)
