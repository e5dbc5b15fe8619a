# SPDX-License-Identifier: GPL-3.0-or-later
"""Turns a material without nodes, which is its viewport colour alone, into nodes that show the same, and back; only before Blender 5.0."""

from __future__ import annotations

import bpy

from ..blender.nodes import HAD_NO_NODES, turn_nodes
from ..material.colour_nodes import add_part

VIEWPORT = "prt_viewport_colour"
"""Custom property of the output that we add for Cycles to a material that had no nodes."""


def show_viewport_colour(material: bpy.types.Material) -> bpy.types.NodeSocket:
    """Turn the nodes of a material on that has none, and show in Cycles what it shows without: a matte surface of its viewport colour.

    Returns:
        The surface.
    """
    material[HAD_NO_NODES] = True
    turn_nodes(material, True)
    tree = material.node_tree
    shader = add_part(tree, "ShaderNodeBsdfDiffuse")
    shader.inputs["Color"].default_value = material.diffuse_color
    output = add_part(tree, "ShaderNodeOutputMaterial")
    output.target, output.is_active_output = "CYCLES", True
    output[VIEWPORT] = True
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    return shader.outputs[0]


def follow_viewport_colour(material: bpy.types.Material) -> None:
    """Take a new viewport colour over to the nodes that show it, if we turned them on."""
    for node in material.node_tree.nodes if material.get(HAD_NO_NODES) else ():
        if VIEWPORT in node and node.inputs["Surface"].is_linked:
            entry = node.inputs["Surface"].links[0].from_node.inputs["Color"]
            if tuple(entry.default_value) != tuple(material.diffuse_color):
                entry.default_value = material.diffuse_color


def turn_nodes_off_again(material: bpy.types.Material) -> None:
    """Have a material without nodes again, if we turned them on."""
    if material.get(HAD_NO_NODES):
        turn_nodes(material, False)
        del material[HAD_NO_NODES]
