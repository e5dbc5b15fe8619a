# SPDX-License-Identifier: GPL-3.0-or-later
"""Shows the user's own surfaces in place of relit ones, for a while, to what reads materials as their active outputs have them."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import bpy

from ..blender.libraries import is_local
from ..material.reading import OURS
from .our_nodes import our_nodes
from .viewport_colour import VIEWPORT


@contextmanager
def own_surfaces_active() -> Iterator[None]:
    """Inside, the outputs that were active before ours are active again in all relit materials: for those who look there."""
    before: list[tuple[bpy.types.Node, bool]] = []
    for material in filter(is_local, bpy.data.materials):
        ours = next((node for node in our_nodes(material.node_tree) if OURS in node), None)
        if ours is None:
            continue
        names = ours[OURS].split("\n")
        outputs = [node for node in material.node_tree.nodes if node.bl_idname == "ShaderNodeOutputMaterial"]
        before += [(node, node.is_active_output) for node in outputs]
        for node in outputs:
            node.is_active_output = node.name in names or VIEWPORT in node
    try:
        yield
    finally:
        for node, active in before:
            node.is_active_output = active
