# SPDX-License-Identifier: GPL-3.0-or-later
"""Links the colour that was read of a material as nodes: where it lies in the material's tree, or mixed as it is mixed.

What lies inside a group cannot be linked from outside. A copy of the group hands it out, and is fed as the group is.
"""

from __future__ import annotations

import bpy

from ..blender.nodes import Wiring
from .reading import PART, RGB, Colour, Constant, Inside, Mixed, Source


def build(tree: bpy.types.NodeTree, colour: Colour) -> bpy.types.NodeSocket | RGB:
    """Make the socket that gives a colour in a tree, with new nodes if it takes some.

    Args:
        tree: that the colour was read in, or a copy of it.
        colour: that was read of a material.

    Returns:
        An output to link, or a constant.
    """
    if isinstance(colour, Constant):
        return colour.rgb
    if isinstance(colour, Source):
        return _output(tree.nodes[colour.socket.node.name], colour.socket.identifier)
    if isinstance(colour, Inside):
        return _handed_out(tree, colour)
    if isinstance(colour, Mixed):
        return _mix(tree, "MIX", build(tree, colour.factor), build(tree, colour.first), build(tree, colour.second))
    return _mix(tree, "ADD", (1.0, 1.0, 1.0), build(tree, colour.first), build(tree, colour.second))


def connect(tree: bpy.types.NodeTree, colour: Colour, entry: bpy.types.NodeSocket) -> None:
    """Feed an input with a colour."""
    _feed(tree, entry, build(tree, colour))


def remove_parts(tree: bpy.types.NodeTree, but: str = "") -> None:
    """Take out all nodes that `build` and `add_part` added, and the copies of groups that nothing uses any more.

    Args:
        tree: of a material.
        but: a custom property: outputs that have it, and what feeds them, stay.
    """
    kept = {node for output in tree.nodes if but and but in output for node in Wiring().upstream(output)}
    for node in [node for node in tree.nodes if PART in node and node not in kept]:
        group = getattr(node, "node_tree", None)
        tree.nodes.remove(node)
        if group and PART in group and not group.users:
            remove_parts(group)
            bpy.data.node_groups.remove(group)


def _mix(tree: bpy.types.NodeTree, how: str, factor: object, first: object, second: object) -> bpy.types.NodeSocket:
    node = add_part(tree, "ShaderNodeMix")
    node.data_type, node.blend_type = "RGBA", how
    entries = {entry.identifier: entry for entry in node.inputs}
    for name, value in (("Factor_Float", factor), ("A_Color", first), ("B_Color", second)):
        _feed(tree, entries[name], value)
    return _output(node, "Result_Color")


def _handed_out(tree: bpy.types.NodeTree, inside: Inside) -> bpy.types.NodeSocket:
    """An output of a copy of a group that gives what lies inside."""
    group, wiring = tree.nodes[inside.group.name], Wiring()
    copy = group.node_tree.copy()
    copy.name, copy[PART] = f"PRT {group.node_tree.name}", group.node_tree.name
    inner = build(copy, inside.colour)
    result = copy.interface.new_socket("PRT Colour", in_out="OUTPUT", socket_type="NodeSocketColor")
    output = next(node for node in copy.nodes if node.bl_idname == "NodeGroupOutput" and node.is_active_output)
    _feed(copy, next(entry for entry in output.inputs if entry.identifier == result.identifier), inner)
    node = add_part(tree, "ShaderNodeGroup")
    node.node_tree = copy
    for entry, original in zip(node.inputs, group.inputs, strict=True):
        source = wiring.source(original)
        if source:
            tree.links.new(source, entry)
        elif hasattr(original, "default_value"):
            entry.default_value = original.default_value
    return _output(node, result.identifier)


def add_part(tree: bpy.types.NodeTree, kind: str) -> bpy.types.Node:
    """Add a node of ours, which `remove_parts` takes out."""
    node = tree.nodes.new(kind)
    node[PART], node.label, node.hide, node.select = True, "PRT", True, False
    return node


def _output(node: bpy.types.Node, identifier: str) -> bpy.types.NodeSocket:
    return next(output for output in node.outputs if output.identifier == identifier)


def _feed(tree: bpy.types.NodeTree, entry: bpy.types.NodeSocket, value: object) -> None:
    """Link an input, or set its constant."""
    if isinstance(value, bpy.types.NodeSocket):
        tree.links.new(value, entry)
        return
    assert isinstance(value, tuple)
    entry.default_value = value[0] if entry.type == "VALUE" else (*value, 1.0)
