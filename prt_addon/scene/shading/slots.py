# SPDX-License-Identifier: GPL-3.0-or-later
"""Counts the attributes of a mesh that a material reads: EEVEE takes 14, and shows the material pink beyond."""

from __future__ import annotations

from collections.abc import Iterator

import bpy

from ...core.layout import BACKS, LAYERS
from ..blender.nodes import PROCEDURAL_TEXTURES, Wiring

MOST = 14
ROOM = MOST - len(LAYERS)
"""What is left beside the layers of transport."""

ROOM_WITH_BACKS = ROOM - len(BACKS)
"""What is left if the layers of backs are read, too."""

_GENERATED = ("generated", ""), ("generated", "size")


def attributes_read(output: bpy.types.Node) -> set[tuple[str, str]]:
    """The attributes that a Material Output's nodes read, each as what it is and its name; groups included.

    A UV map is one, a colour attribute one, a tangent (Normal Map) one, Generated coordinates two.
    """
    found: set[tuple[str, str]] = set()
    wiring, pending, seen = Wiring(), [output], set[int]()
    while pending:
        end = pending.pop()
        if end.as_pointer() in seen:
            continue
        seen.add(end.as_pointer())
        for node in wiring.upstream(end):
            found.update(_read_by(node, wiring))
            tree = getattr(node, "node_tree", None)
            pending += [inner for inner in tree.nodes if inner.bl_idname == "NodeGroupOutput"] if tree else []
    return found


def _read_by(node: bpy.types.Node, wiring: Wiring) -> Iterator[tuple[str, str]]:
    kind = node.bl_idname
    if kind == "ShaderNodeUVMap":
        yield "uv", node.uv_map
    elif kind == "ShaderNodeAttribute" and node.attribute_type == "GEOMETRY":
        yield "layer", node.attribute_name
    elif kind == "ShaderNodeVertexColor":
        yield "layer", node.layer_name
    elif (kind == "ShaderNodeNormalMap" and node.space == "TANGENT") or (
        kind == "ShaderNodeTangent" and node.direction_type == "UV_MAP"
    ):
        yield "tangent", node.uv_map
    elif kind == "ShaderNodeTexCoord":
        if wiring.fed_by(node.outputs["UV"]):
            yield "uv", ""
        if wiring.fed_by(node.outputs["Generated"]):
            yield from _GENERATED
    elif kind == "ShaderNodeTexImage" and not wiring.source(node.inputs["Vector"]):
        yield "uv", ""
    elif kind in PROCEDURAL_TEXTURES and not wiring.source(node.inputs["Vector"]):
        yield from _GENERATED
