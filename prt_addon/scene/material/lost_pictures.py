# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds pictures that a material's colour needs and that are missing: Cycles would show them in pink, and bounce pink
light.
"""

from __future__ import annotations

from collections.abc import Iterator

import bpy

from ..blender.images import missing
from ..blender.nodes import Wiring
from .reading import Colour, Constant, Inside, Mixed, Source, user_output


def why_not_shown(material: bpy.types.Material, colour: Colour | None) -> str:
    """Say what is lost of a colour that was read of a material; of all that its surface needs, if the colour is None.

    Returns:
        To stand after the name of the material and a colon; empty if nothing is lost.
    """
    wiring = Wiring()
    for node in dict.fromkeys(_needed(material, colour, wiring)):
        if node.bl_idname not in {"ShaderNodeTexImage", "ShaderNodeTexEnvironment"}:
            continue
        if node.image is None:
            return f"no image is chosen in '{node.label or node.name}'"
        if node.image.source == "FILE" and not all(node.image.size):  # reading the size loads the file
            return str(missing(node.image)).rstrip(".")
    return ""


def _needed(material: bpy.types.Material, colour: Colour | None, wiring: Wiring) -> Iterator[bpy.types.Node]:
    """All nodes that the value depends on, also those inside groups; some more than once."""
    if colour is None:
        output = user_output(material.node_tree, "CYCLES")
        surface = wiring.source(output.inputs["Surface"]) if output else None
        starts = [surface.node] if surface else []
    else:
        starts = list(_sources(colour))
    for start in starts:
        for node in wiring.upstream(start):
            yield from _with_insides(node)


def _sources(colour: Colour) -> Iterator[bpy.types.Node]:
    """The nodes whose outputs a colour is made of, and the groups that they lie in."""
    if isinstance(colour, Source):
        yield colour.socket.node
    elif isinstance(colour, Inside):
        yield colour.group
    elif isinstance(colour, Mixed):
        for part in (colour.factor, colour.first, colour.second):
            yield from _sources(part)
    elif not isinstance(colour, Constant):
        for part in (colour.first, colour.second):
            yield from _sources(part)


def _with_insides(node: bpy.types.Node) -> Iterator[bpy.types.Node]:
    yield node
    tree = getattr(node, "node_tree", None)
    for inner in tree.nodes if tree else ():
        yield from _with_insides(inner)
