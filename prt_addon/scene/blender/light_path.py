# SPDX-License-Identifier: GPL-3.0-or-later
"""Answers Light Path nodes as for light that left a matte surface: worlds and materials may show the camera something
else.
"""

from __future__ import annotations

import bpy

DIFFUSE_RAY = {"Is Diffuse Ray": 1.0, "Is Reflection Ray": 1.0, "Ray Depth": 1.0, "Diffuse Depth": 1.0}
"""What Light Path says of such a ray; 0 for all else."""


def answer_light_path(tree: bpy.types.NodeTree, groups: list[bpy.types.NodeTree]) -> None:
    """Replace Light Path nodes of a tree by numbers, in copies of the groups too that hold some.

    Args:
        tree: of a material or a world; it is changed.
        groups: the copies are added to it: they are to be removed with the tree.
    """
    for node in list(tree.nodes):
        group = getattr(node, "node_tree", None)
        if group and reads_light_path(group):
            node.node_tree = group.copy()
            groups.append(node.node_tree)
            answer_light_path(node.node_tree, groups)
        if node.bl_idname == "ShaderNodeLightPath":
            for output in node.outputs:
                for link in list(output.links):
                    value = tree.nodes.new("ShaderNodeValue").outputs[0]
                    value.default_value = DIFFUSE_RAY.get(output.name, 0.0)
                    tree.links.new(value, link.to_socket)


def reads_light_path(tree: bpy.types.NodeTree) -> bool:
    """Whether a tree, or a group in it, has a Light Path node."""
    return any(
        node.bl_idname == "ShaderNodeLightPath"
        or (getattr(node, "node_tree", None) and reads_light_path(node.node_tree))
        for node in tree.nodes
    )
