# SPDX-License-Identifier: GPL-3.0-or-later
"""Relights what the user's own surface of a material is, whenever that has changed."""

from __future__ import annotations

import bpy

from ..blender.libraries import is_local
from ..blender.nodes import feeding_socket
from ..material.colour_nodes import add_part, remove_parts
from ..material.reading import PART, Constant, MaterialReading, read_material
from .active_output import show_ours
from .our_nodes import our_nodes, our_output
from .relight_group import is_newer
from .surface_nodes import Built, build_surface, follow_numbers, lamps_shine, sockets_of, structure, write
from .viewport_colour import VIEWPORT, follow_viewport_colour

_SURFACE = "prt_surface"
"""Custom property of our group node: the structure of the surface that is relit, or that it is matte."""
_MATTE = "matte"
"""Of a material that is a viewport colour."""
_NONE = "none"
"""Of one whose outputs are gone."""


def follow_surface(material: bpy.types.Material, anew: bool = False) -> None:
    """Relight what the user's own surface now is, if that has changed.

    Textures and nodes are linked and need no following; a plain number cannot be linked, and a driver from a material
    to itself would be a dependency cycle.

    Args:
        material: that may be relit.
        anew: also if it looks the same from here: a group of it was edited.
    """
    groups = (
        node for node in our_nodes(material.node_tree) if node.bl_idname == "ShaderNodeGroup" and PART not in node
    )
    group = next((node for node in groups if not is_newer(node.node_tree)), None)
    if group:
        follow_viewport_colour(material)
        relight_surface(material, group, anew)


def follow_group(tree: bpy.types.NodeTree) -> None:
    """A node group was edited: materials that show what lies inside of it, through a copy, get another."""
    copies = {copy for copy in bpy.data.node_groups if copy.get(PART) == tree.name}
    for material in bpy.data.materials if copies else ():
        if any(getattr(node, "node_tree", None) in copies for node in our_nodes(material.node_tree)):
            follow_surface(material, anew=True)


def relight_surface(material: bpy.types.Material, group: bpy.types.Node, anew: bool = False) -> Built:
    """Have the group relight what the user's own surface now is.

    Args:
        material: that has our nodes.
        group: the node among them that holds the relight group.
        anew: also if the surface is built as the one that is relit.

    Returns:
        What became of the surface, as far as it was built now.
    """
    tree, reading, built = material.node_tree, read_material(material, "EEVEE"), Built()
    wanted = structure(reading.output) if reading.output else _MATTE if reading.colour else _NONE
    if is_local(material) and (group.get(_SURFACE) != wanted or anew):
        group[_SURFACE] = wanted
        group.inputs["Lamps"].default_value = float(reading.output is not None and lamps_shine())
        remove_parts(tree, but=VIEWPORT)
        built = _link_surface(tree, group, reading)
        _lay_out(tree, group)
    if is_local(material):
        show_ours(tree, our_output(tree))
    if not reading.output and isinstance(reading.colour, Constant):
        write(group.inputs["Base Color"], "default_value", (*reading.colour.rgb, 1.0))
    follow_numbers(tree)
    return built


def _link_surface(tree: bpy.types.NodeTree, group: bpy.types.Node, reading: MaterialReading) -> Built:
    """Feed our output with the relit surface, and as the user's own output is fed with all else."""
    ours, built = our_output(tree), Built()
    for entry in ours.inputs:
        _relink(entry, feeding_socket(reading.output.inputs[entry.name]) if reading.output else None)
    if reading.output:
        _relink(group.inputs["Unbaked"], feeding_socket(reading.output.inputs["Surface"]))
        surface, built = _relit_where_baked(reading.output, group)
        _relink(ours.inputs["Surface"], surface)
    elif reading.colour:
        _relink(ours.inputs["Surface"], group.outputs["Surface"])
    return built


def _relink(entry: bpy.types.NodeSocket, source: bpy.types.NodeSocket | None) -> None:
    """Feed an input by an output, or by nothing."""
    for link in list(entry.links):
        entry.id_data.links.remove(link)
    if source:
        entry.id_data.links.new(source, entry)


def _relit_where_baked(output: bpy.types.Node, group: bpy.types.Node) -> tuple[bpy.types.NodeSocket, Built]:
    """The user's surface, relit where there is transport, and what became of it."""
    tree = output.id_data
    mix = add_part(tree, "ShaderNodeMixShader")
    users, (relit, built) = feeding_socket(output.inputs["Surface"]), build_surface(output, sockets_of(group))
    for entry, source in zip(mix.inputs, (group.outputs["Relit"], users, relit), strict=True):
        if source:
            tree.links.new(source, entry)
    return mix.outputs[0], built


def _lay_out(tree: bpy.types.NodeTree, group: bpy.types.Node) -> None:
    """Parts in a staircase below the group, folded."""
    for row, node in enumerate(node for node in tree.nodes if PART in node and VIEWPORT not in node):
        node.location = (group.location.x + 30.0 * row, group.location.y - 220.0 - 40.0 * row)
