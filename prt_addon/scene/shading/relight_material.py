# SPDX-License-Identifier: GPL-3.0-or-later
"""Hooks the relight group into a material beside the user's own nodes, and takes it out again.

The group feeds a Material Output whose target is EEVEE. The user's own output, links and nodes are not touched:
Cycles still renders them, and removing our two nodes restores the material.
"""

from __future__ import annotations

import bpy

from ...core.notices import Kind, Notice
from ..blender.libraries import is_local
from ..blender.nodes import feeding_socket, nodes_are_on
from ..material.colour_nodes import remove_parts
from ..material.reading import OURS, has_surface, read_material, user_output
from .follow_surface import relight_surface
from .our_nodes import main_outputs, our_nodes
from .relight_group import Sides, is_relit_by_newer, relight_group
from .slots import ROOM, ROOM_WITH_BACKS, attributes_read
from .viewport_colour import show_viewport_colour, turn_nodes_off_again

OUTPUT = "PRT Output"
"""Name of the Material Output that we add."""

_FOREIGN = Kind(
    "Material {name} is linked from a library, or overrides it, and is not relit: make it local to relight it.",
    "{count} materials are linked from libraries, or override them, and are not relit: make them local to relight them: {names}.",
)
_NEWER = Kind(
    "Material {name} is relit by a newer version of PRT Relight, and stays as it is: use a newer version of the extension here.",
    "{count} materials are relit by a newer version of PRT Relight, and stay as they are: {names}.",
)
_LIGHTLESS = Kind(
    "Material {name} reflects no light: EEVEE goes on showing it as it is.",
    "{count} materials reflect no light: EEVEE goes on showing them as they are: {names}.",
    "INFO",
)
_GLOWS = Kind(
    "Material {name} emits light: it glows, but lights nothing around it in the bake. Put lamps where it shines.",
    "{count} materials emit light: they glow, but light nothing around them in the bake. Put lamps where they shine: {names}.",
    "INFO",
)
_TOO_MANY_ATTRIBUTES = Kind(
    "Material {name} reads {count} attributes of the mesh (UV maps, colours, tangents). EEVEE takes 14 in all, and the "
    "transport needs nine: it does not show the bake. Let it read {most} at most.",
    "{count} materials read more attributes of their meshes (UV maps, colours, tangents) than EEVEE takes beside the "
    "transport's nine, and do not show the bake: {names}.",
)
_NO_BACKS = Kind(
    "Material {name} reads {count} attributes of the mesh (UV maps, colours, tangents), which leaves EEVEE no room for the three of "
    "backs: these show the light of the fronts. Let it read {most} at most.",
    "{count} materials read too many attributes of their meshes (UV maps, colours, tangents) beside the three of backs, which show "
    "the light of the fronts: {names}.",
    "INFO",
)
_GREY = Kind(
    "Material {name}: {why}; it is relit in grey.",
    "{count} materials have surfaces that cannot be read, and are relit in grey: {names}.",
)


def relight(material: bpy.types.Material, two_sided: bool) -> list[Notice]:
    """Relight a material in EEVEE, again if it is; returns a notice if it is not, or not as it looks."""
    if not is_local(material):
        return [Notice(_FOREIGN, material.name)]
    if is_relit_by_newer(material):
        return [Notice(_NEWER, material.name)]
    remove_from_material(material)
    return _add_to_material(material, two_sided)


def remove_from_material(material: bpy.types.Material) -> bool:
    """Take our nodes out of a material and restore which output was active; True if there were any."""
    tree = material.node_tree
    ours = list(our_nodes(tree))
    were_active = {name for node in ours for name in node.get(OURS, "").split("\n")}
    if tree:
        remove_parts(tree)
    for node in list(our_nodes(tree)):
        tree.nodes.remove(node)
    if ours:
        for output in main_outputs(tree):
            output.is_active_output = output.name in were_active
    turn_nodes_off_again(material)
    return bool(ours)


def _add_to_material(material: bpy.types.Material, two_sided: bool) -> list[Notice]:
    """Add our nodes; returns what there is to say about it.

    Args:
        material: that has none of our nodes.
        two_sided: whether meshes that show it have backs with transport of their own.
    """
    if not has_surface(material):
        return []
    reading = read_material(material, "EEVEE")
    said = [Notice(_GLOWS, material.name)] if reading.emits else []
    if reading.colour is None and not reading.why_not:
        return [*said, Notice(_LIGHTLESS, material.name)]
    count = len(attributes_read(reading.output)) if reading.output else 0
    sides: Sides = "BOTH" if two_sided else "FRONTS"
    if count > ROOM:
        sides = "NONE"
        said.append(Notice(_TOO_MANY_ATTRIBUTES, material.name, {"count": str(count), "most": str(ROOM)}))
    elif two_sided and count > ROOM_WITH_BACKS:
        sides = "FRONTS"
        said.append(Notice(_NO_BACKS, material.name, {"count": str(count), "most": str(ROOM_WITH_BACKS)}))
    _hook(material, sides)
    return said + ([Notice(_GREY, material.name, {"why": reading.why_not})] if reading.why_not else [])


def _hook(material: bpy.types.Material, sides: Sides) -> None:
    """Add the relight group and an output for EEVEE, and feed them as the user's own output is fed."""
    plain = None if nodes_are_on(material) else show_viewport_colour(material)
    tree = material.node_tree
    output, group = user_output(tree, "EEVEE"), tree.nodes.new("ShaderNodeGroup")
    group.node_tree, group.width = relight_group(sides), 200.0
    group.name = group.label = "PRT Relight"
    ours = _add_output(tree)
    if plain:
        tree.links.new(plain, group.inputs["Unbaked"])
    elif output:
        _share_links(tree, output, ours, group)
    for node in (group, ours):
        node.select = False
    ours.is_active_output = True
    relight_surface(material, group)


def _add_output(tree: bpy.types.NodeTree) -> bpy.types.Node:
    """A Material Output for EEVEE that remembers which outputs were active before it."""
    active = [node.name for node in main_outputs(tree) if node.is_active_output]
    ours = tree.nodes.new("ShaderNodeOutputMaterial")
    ours.target, ours.name, ours.label = "EEVEE", OUTPUT, "PRT (EEVEE)"
    ours[OURS] = "\n".join(active)
    return ours


def _share_links(tree: bpy.types.NodeTree, output: bpy.types.Node, ours: bpy.types.Node, group: bpy.types.Node) -> None:
    """Feed the user's surface to unbaked meshes, and the user's displacement and volume to our output."""
    group.location = (output.location.x, output.location.y - 260.0)
    ours.location = (output.location.x + 240.0, output.location.y - 260.0)
    for entry in output.inputs:
        source = feeding_socket(entry)
        if source:
            tree.links.new(source, group.inputs["Unbaked"] if entry.name == "Surface" else ours.inputs[entry.name])
