# SPDX-License-Identifier: GPL-3.0-or-later
"""Tells our nodes in a material's tree from the user's own."""

from __future__ import annotations

from collections.abc import Iterator

import bpy

from ..blender.libraries import is_local
from ..material.reading import OURS, PART
from .relight_group import is_relight_group, is_relit_by_newer


def our_nodes(tree: bpy.types.NodeTree | None) -> Iterator[bpy.types.Node]:
    """The nodes we added to a material's tree."""
    for node in tree.nodes if tree else ():
        is_group = node.bl_idname == "ShaderNodeGroup" and is_relight_group(node.node_tree)
        if is_group or OURS in node or PART in node:
            yield node


def our_output(tree: bpy.types.NodeTree) -> bpy.types.Node:
    """The Material Output that we added to a tree."""
    return next(node for node in our_nodes(tree) if OURS in node)


def is_relit(material: bpy.types.Material) -> bool:
    """Whether this version relights a material, and may restore it."""
    return is_local(material) and any(our_nodes(material.node_tree)) and not is_relit_by_newer(material)
