# SPDX-License-Identifier: GPL-3.0-or-later
"""Shows the user's own surfaces in place of relit ones, for a while, to what reads materials as their active outputs have them."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import bpy

from ..blender.libraries import is_local
from ..material.reading import active_output
from .our_nodes import our_nodes
from .viewport_colour import VIEWPORT


@contextmanager
def own_surfaces_active() -> Iterator[None]:
    """Inside, the user's own outputs are active in all relit materials, where ours were: for those who look there."""
    before: list[bpy.types.Node] = []
    for material in filter(is_local, bpy.data.materials):
        tree = material.node_tree
        if not any(our_nodes(tree)):
            continue
        shown = next((node for node in tree.nodes if VIEWPORT in node), None) or active_output(tree)
        if shown and not shown.is_active_output:
            before += [node for node in tree.nodes if getattr(node, "is_active_output", False)]
            shown.is_active_output = True
    try:
        yield
    finally:
        for node in before:
            node.is_active_output = True
