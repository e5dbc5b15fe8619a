# SPDX-License-Identifier: GPL-3.0-or-later
"""Hooks the relight group into a material beside the user's own nodes, and takes it out again.

The group feeds a Material Output whose target is EEVEE. The user's own output, links and nodes are not touched, save which output is
active (`active_output`): Cycles still renders them, and removing our nodes restores the material.
"""

from __future__ import annotations

import bpy

from ...core.notices import Kind, Notice
from ..blender.libraries import is_local
from ..blender.nodes import nodes_are_on
from ..material.colour_nodes import remove_parts
from ..material.reading import OURS, has_surface, read_material, user_output
from .active_output import activate_users, mark_active
from .follow_surface import relight_surface
from .our_nodes import our_nodes
from .relight_group import Sides, is_relit_by_newer, relight_group
from .slots import ROOM, ROOM_WITH_BACKS, attributes_read
from .surface_nodes import Built
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
_UNKNOWN = Kind(
    "Material {name}: {shaders} cannot be relit, and EEVEE goes on showing it as it is.",
    "{count} materials have shaders that cannot be relit, and EEVEE goes on showing these as they are: {names}.",
)
_EEVEES_LIGHT = Kind(
    "Material {name} makes colours of EEVEE's own light (Shader to RGB): they stay as EEVEE shows them, and the bake does not light them. "
    "Cycles has no such node.",
    "{count} materials make colours of EEVEE's own light (Shader to RGB): they stay as EEVEE shows them, and the bake does not light "
    "them. Cycles has no such node ({names}).",
    "INFO",
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
    """Take our nodes out of a material, and have the user's output active that was; True if there were any."""
    tree = material.node_tree
    ours = any(our_nodes(tree))
    if ours:
        activate_users(tree)
    if tree:
        remove_parts(tree)
    for node in list(our_nodes(tree)):
        tree.nodes.remove(node)
    turn_nodes_off_again(material)
    return ours


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
    if reading.eevees_light:
        said.append(Notice(_EEVEES_LIGHT, material.name))
    if reading.colour is None and not reading.why_not:
        return said if reading.eevees_light else [*said, Notice(_LIGHTLESS, material.name)]
    sides, no_room = _sides(material, reading.output, two_sided)
    built = _hook(material, sides)
    unknown = [Notice(_UNKNOWN, material.name, {"shaders": ", ".join(built.unknown)})] if built.unknown else []
    if unknown and not built.relit:
        remove_from_material(material)  # lamps of the sky light what has our nodes: it would show their light twice
        return said + unknown
    return said + no_room + unknown


def _sides(material: bpy.types.Material, output: bpy.types.Node | None, two_sided: bool) -> tuple[Sides, list[Notice]]:
    """Whose transport there is room for beside the attributes that a material reads itself, and what there is to say about it."""
    count = len(attributes_read(output)) if output else 0
    if count > ROOM:
        return "NONE", [Notice(_TOO_MANY_ATTRIBUTES, material.name, {"count": str(count), "most": str(ROOM)})]
    if two_sided and count > ROOM_WITH_BACKS:
        return "FRONTS", [Notice(_NO_BACKS, material.name, {"count": str(count), "most": str(ROOM_WITH_BACKS)})]
    return "BOTH" if two_sided else "FRONTS", []


def _hook(material: bpy.types.Material, sides: Sides) -> Built:
    """Add the relight group and an output for EEVEE, and feed them as the user's own output is fed."""
    plain = None if nodes_are_on(material) else _with_nodes(material)
    tree = material.node_tree
    output, group = user_output(tree, "EEVEE"), tree.nodes.new("ShaderNodeGroup")
    group.node_tree, group.width = relight_group(sides), 200.0
    group.name = group.label = "PRT Relight"
    ours = _add_output(tree)
    if output:
        group.location = (output.location.x, output.location.y - 260.0)
        ours.location = (output.location.x + 240.0, output.location.y - 260.0)
    if plain:
        tree.links.new(plain, group.inputs["Unbaked"])
    for node in (group, ours):
        node.select = False
    return relight_surface(material, group)


def _with_nodes(material: bpy.types.Material) -> bpy.types.NodeSocket:
    """The surface of a material that had no nodes. What these once showed, before they were turned off, is kept."""
    if material.node_tree:
        mark_active(material.node_tree)
    return show_viewport_colour(material)


def _add_output(tree: bpy.types.NodeTree) -> bpy.types.Node:
    """A Material Output for EEVEE."""
    ours = tree.nodes.new("ShaderNodeOutputMaterial")
    ours.target, ours.name, ours.label = "EEVEE", OUTPUT, "PRT (EEVEE)"
    ours[OURS] = ""
    return ours
