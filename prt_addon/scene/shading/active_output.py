# SPDX-License-Identifier: GPL-3.0-or-later
"""Has EEVEE show our output of a material, and all else the user's own that is active.

Only one output of a tree is active, and an engine takes the active one of those that are made for it, or of those for all if none is.
So ours need not be active where it is the only one for EEVEE, and the user's stays so: Cycles shows it, and what the user makes active
shows in both. Beside one for EEVEE of the user's own ours must be, and the user's is marked.
"""

from __future__ import annotations

import bpy

from ..material.reading import WAS_ACTIVE, active_output, user_outputs


def show_ours(tree: bpy.types.NodeTree, ours: bpy.types.Node) -> None:
    """Have EEVEE show our output, also after outputs were added, or others made active."""
    if any(node.target == "EEVEE" for node in user_outputs(tree)):
        mark_active(tree)
        _activate(ours)
    elif ours.is_active_output:
        activate_users(tree)


def mark_active(tree: bpy.types.NodeTree) -> None:
    """Mark the user's output that is active, or was before ours: to be called before another is made active."""
    active = active_output(tree)
    for node in user_outputs(tree):
        if node == active and WAS_ACTIVE not in node:
            node[WAS_ACTIVE] = True
        elif node != active and WAS_ACTIVE in node:
            del node[WAS_ACTIVE]


def activate_users(tree: bpy.types.NodeTree) -> None:
    """Have the user's output active that is, or was before ours, without marks."""
    active = active_output(tree)
    for node in user_outputs(tree):
        if WAS_ACTIVE in node:
            del node[WAS_ACTIVE]
    if active:
        _activate(active)


def _activate(output: bpy.types.Node) -> None:
    if not output.is_active_output:  # Blender would take it for an edit
        output.is_active_output = True
