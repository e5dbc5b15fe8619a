# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds the "PRT Carrier" node groups, which copy the layers of a carrier onto what a modifier stack makes."""

from __future__ import annotations

from typing import Literal

import bpy

from ...core.layout import BACKS, FROZEN, LAYERS
from ..blender.versions import version_of
from .meshes import Domain

CARRIER_ENTRY = "Carrier"
_VERSION = "prt_carrier_version"
_GROUP_VERSION = 1
_DOMAIN, _BACKS, _LIGHT = "prt_domain", "prt_backs", "prt_light"
LightKind = Literal["", "FLOAT_COLOR", "BYTE_COLOR"]
"""As what a group copies frozen light, too; empty if it copies none."""
_WITH: dict[LightKind, str] = {"": "", "FLOAT_COLOR": ", Light", "BYTE_COLOR": ", Light in Bytes"}
_INTO_FACE = 0.02
"""How far a corner is looked up inside of its face: on a hard edge, the nearest surface may be the other face."""


def is_carrier_group(tree: bpy.types.NodeTree | None) -> bool:
    """Whether a node group is one of these, of whatever version."""
    return tree is not None and _VERSION in tree


def carrier_group(domain: Domain, with_backs: bool = False, light: LightKind = "") -> bpy.types.NodeTree:
    """The group for layers on points or corners, built on first use and shared by all objects of the file.

    Args:
        domain: POINT or CORNER.
        with_backs: whether it copies the layers of backs, too.
        light: whether it copies frozen light with them, and as what.
    """
    for tree in bpy.data.node_groups:
        ours = is_carrier_group(tree) and tree.library is None and version_of(tree, _VERSION) == _GROUP_VERSION
        kind = (tree[_DOMAIN], bool(tree.get(_BACKS, False)), tree.get(_LIGHT, "")) if ours else None
        if kind == (domain, with_backs, light):
            return tree
    backs = ", Backs" if with_backs else ""
    tree = bpy.data.node_groups.new(f"PRT Carrier ({domain.title()}s{backs}{_WITH[light]})", "GeometryNodeTree")
    tree[_VERSION], tree[_DOMAIN], tree[_BACKS], tree[_LIGHT] = _GROUP_VERSION, domain, with_backs, light
    tree.is_modifier = True
    layers = LAYERS + BACKS if with_backs else LAYERS
    _Builder(tree, domain, layers, light).build()
    return tree


class _Builder:
    """Two chains of nodes that each store all layers, and a switch between them by the counts: one alone is evaluated."""

    def __init__(self, tree: bpy.types.NodeTree, domain: Domain, layers: tuple[str, ...], light: LightKind) -> None:
        self._tree, self._domain = tree, domain
        self._stored = [(name, "FLOAT_COLOR") for name in layers] + ([(FROZEN, light)] if light else [])
        self._row = 0

    def build(self) -> None:
        interface = self._tree.interface
        interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
        carrier = interface.new_socket(CARRIER_ENTRY, in_out="INPUT", socket_type="NodeSocketObject")
        carrier.description = "Mesh object that carries the baked transport; Bake PRT makes it"
        interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
        entry, leave = self._node("NodeGroupInput", 0), self._node("NodeGroupOutput", 9)
        info = self._node("GeometryNodeObjectInfo", 1)
        info.transform_space = "ORIGINAL"
        self._link(entry.outputs[1], info.inputs["Object"])
        here, there = entry.outputs[0], info.outputs["Geometry"]
        by_index = self._chain(
            here, there, "GeometryNodeSampleIndex", "Index", self._node("GeometryNodeInputIndex", 2).outputs[0]
        )
        nearest = self._chain(here, there, "GeometryNodeSampleNearestSurface", "Sample Position", self._place())
        switch = self._node("GeometryNodeSwitch", 8)
        switch.input_type = "GEOMETRY"
        self._link(self._same_counts(here, there), switch.inputs["Switch"])
        self._link(nearest, switch.inputs["False"])
        self._link(by_index, switch.inputs["True"])
        self._link(switch.outputs[0], leave.inputs[0])

    def _chain(
        self,
        geometry: bpy.types.NodeSocket,
        carrier: bpy.types.NodeSocket,
        kind: str,
        entry: str,
        where: bpy.types.NodeSocket,
    ) -> bpy.types.NodeSocket:
        """Store each layer on a geometry, sampled from the carrier by a kind of node."""
        for name, stored in self._stored:
            value = self._node("GeometryNodeInputNamedAttribute", 4)
            value.data_type = "FLOAT_COLOR"
            value.inputs["Name"].default_value = name
            sample = self._node(kind, 5)
            sample.data_type = "FLOAT_COLOR"
            if kind == "GeometryNodeSampleIndex":
                sample.domain = self._domain
            self._link(carrier, sample.inputs[0])
            self._link(_colour(value.outputs), _colour(sample.inputs))
            self._link(where, sample.inputs[entry])
            store = self._node("GeometryNodeStoreNamedAttribute", 6)
            store.data_type, store.domain = stored, self._domain
            store.inputs["Name"].default_value = name
            self._link(geometry, store.inputs["Geometry"])
            self._link(_colour(sample.outputs), _colour(store.inputs))
            geometry = store.outputs[0]
        return geometry

    def _place(self) -> bpy.types.NodeSocket:
        """Where a vertex lies, or a corner, a little inside of its face."""
        position = self._node("GeometryNodeInputPosition", 2).outputs[0]
        if self._domain == "POINT":
            return position
        centre = self._node("GeometryNodeFieldOnDomain", 2)
        centre.data_type, centre.domain = "FLOAT_VECTOR", "FACE"
        self._link(position, centre.inputs[0])
        mix = self._node("ShaderNodeMix", 3)
        mix.data_type = "VECTOR"
        sockets = {socket.identifier: socket for socket in mix.inputs}
        sockets["Factor_Float"].default_value = _INTO_FACE
        self._link(position, sockets["A_Vector"])
        self._link(centre.outputs[0], sockets["B_Vector"])
        return next(socket for socket in mix.outputs if socket.identifier == "Result_Vector")

    def _same_counts(self, here: bpy.types.NodeSocket, there: bpy.types.NodeSocket) -> bpy.types.NodeSocket:
        """Whether both have as many points, or face corners."""
        name = "Point Count" if self._domain == "POINT" else "Face Corner Count"
        compare = self._node("FunctionNodeCompare", 7)
        compare.data_type, compare.operation = "INT", "EQUAL"
        entries = [socket for socket in compare.inputs if socket.type == "INT"]
        for geometry, entry in zip((here, there), entries, strict=False):
            size = self._node("GeometryNodeAttributeDomainSize", 3)
            self._link(geometry, size.inputs[0])
            self._link(size.outputs[name], entry)
        return compare.outputs[0]

    def _node(self, kind: str, column: int) -> bpy.types.Node:
        node = self._tree.nodes.new(kind)
        node.location, node.hide = (190.0 * column, -45.0 * self._row), True
        self._row += 1
        return node

    def _link(self, source: bpy.types.NodeSocket, entry: bpy.types.NodeSocket) -> None:
        self._tree.links.new(source, entry)


def _colour(sockets: bpy.types.NodeInputs | bpy.types.NodeOutputs) -> bpy.types.NodeSocket:
    """The colour among the sockets of a node that serves many types."""
    return next(socket for socket in sockets if socket.type == "RGBA" and socket.enabled)
