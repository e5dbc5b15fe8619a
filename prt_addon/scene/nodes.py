# SPDX-License-Identifier: GPL-3.0-or-later
"""Finding one's way in shader node trees: what feeds a socket, and building graphs by formula."""

from __future__ import annotations

from collections.abc import Iterator

import bpy


def feeding_socket(socket: bpy.types.NodeSocket) -> bpy.types.NodeSocket | None:
    """The output that feeds an input, seen through reroutes; None if nothing does."""
    while socket.is_linked:
        source = socket.links[0].from_socket
        if source.node.bl_idname != "NodeReroute":
            return source
        socket = source.node.inputs[0]
    return None


def upstream(node: bpy.types.Node) -> Iterator[bpy.types.Node]:
    """A node and all that feed it, nearest first, each once."""
    seen, pending = set(), [node]
    while pending:
        current = pending.pop(0)
        if current.name in seen:
            continue
        seen.add(current.name)
        yield current
        pending.extend(source.node for entry in current.inputs if (source := feeding_socket(entry)))


_NODES_ARE_OPTIONAL = bpy.app.version < (5, 0, 0)
"""Since 5.0 materials and worlds always have nodes, and `use_nodes` is deprecated: it goes in 6.0."""


def nodes_are_on(block: bpy.types.Material | bpy.types.World) -> bool:
    """Whether a material or a world is made of nodes."""
    return not _NODES_ARE_OPTIONAL or bool(block.use_nodes)


def turn_nodes(block: bpy.types.Material | bpy.types.World, on: bool) -> None:
    """Have a material or a world made of nodes, or not, where there is a choice."""
    if _NODES_ARE_OPTIONAL:
        block.use_nodes = on


HAD_NO_NODES = "prt_had_no_nodes"
"""Custom property of a material whose nodes we turned on, to relight it: before 5.0 they can be off."""


def uses_nodes(material: bpy.types.Material) -> bool:
    """Whether the person's material is made of nodes; if not, it is its viewport colour."""
    return nodes_are_on(material) and not material.get(HAD_NO_NODES)


_DIFFUSE_INPUT = {
    "ShaderNodeBsdfPrincipled": "Base Color",
    "ShaderNodeBsdfDiffuse": "Color",
    "ShaderNodeEeveeSpecular": "Base Color",
    "ShaderNodeSubsurfaceScattering": "Color",
}


def diffuse_colour(output: bpy.types.Node | None) -> bpy.types.NodeSocket | None:
    """The colour input of the diffuse-like shader nearest to a Material Output; None if there is none."""
    for node in upstream(output) if output else ():
        if node.bl_idname in _DIFFUSE_INPUT:
            return node.inputs[_DIFFUSE_INPUT[node.bl_idname]]
    return None


class Graph:
    """Writes formulas into a node tree: each method adds one node and returns its output socket.

    Arguments are sockets to link, or constants. Nodes are laid out in columns, a new one after each `column()`.
    """

    def __init__(self, tree: bpy.types.NodeTree) -> None:
        self.tree = tree
        self._x = 0.0
        self._y = 0.0

    def column(self) -> None:
        """Go on to the right: what follows is a new step."""
        self._x += 190.0
        self._y = 0.0

    def add(self, kind: str, label: str = "") -> bpy.types.Node:
        """A node of a type, folded, in the current column."""
        node = self.tree.nodes.new(kind)
        node.location = (self._x, self._y)
        node.label = label
        node.hide = True
        self._y -= 45.0
        return node

    def feed(self, entry: bpy.types.NodeSocket, value: object) -> None:
        """Link a socket to an input, or set its constant."""
        if isinstance(value, bpy.types.NodeSocket):
            self.tree.links.new(value, entry)
        else:
            entry.default_value = value

    def attribute(self, name: str, source: str) -> bpy.types.Node:
        """An Attribute node; `source` is GEOMETRY, or VIEW_LAYER for properties of scene and world."""
        node = self.add("ShaderNodeAttribute", name)
        node.attribute_name, node.attribute_type = name, source
        return node

    def math(self, operation: str, *values: object) -> bpy.types.NodeSocket:
        """Scalar arithmetic."""
        node = self.add("ShaderNodeMath")
        node.operation = operation
        for entry, value in zip(node.inputs, values, strict=False):
            self.feed(entry, value)
        return node.outputs[0]

    def vector(self, operation: str, *values: object) -> bpy.types.NodeSocket:
        """Arithmetic on three channels at once; a scalar socket counts for all three."""
        node = self.add("ShaderNodeVectorMath")
        node.operation = operation
        for entry, value in zip(node.inputs, values, strict=False):
            self.feed(entry, value)
        return node.outputs["Vector"]

    def mixed(self, factor: object, zero: object, one: object) -> bpy.types.NodeSocket:
        """Vector `zero` where the factor is 0, `one` where it is 1."""
        node = self.add("ShaderNodeMix")
        node.data_type = "VECTOR"
        entries = {entry.identifier: entry for entry in node.inputs}
        for name, value in (("Factor_Float", factor), ("A_Vector", zero), ("B_Vector", one)):
            self.feed(entries[name], value)
        return next(output for output in node.outputs if output.identifier == "Result_Vector")

    def to_world(self, direction: object) -> bpy.types.NodeSocket:
        """Unit vector in world axes of a direction in the axes of the object that is shaded."""
        node = self.add("ShaderNodeVectorTransform")
        node.vector_type, node.convert_from, node.convert_to = "VECTOR", "OBJECT", "WORLD"
        self.feed(node.inputs[0], direction)
        return self.vector("NORMALIZE", node.outputs[0])

    def components(self, vector: bpy.types.NodeSocket) -> list[bpy.types.NodeSocket]:
        """x, y and z of a vector."""
        node = self.add("ShaderNodeSeparateXYZ")
        self.feed(node.inputs[0], vector)
        return list(node.outputs)

    def weighted_sum(
        self, terms: list[tuple[bpy.types.NodeSocket, bpy.types.NodeSocket | tuple[float, float, float]]]
    ) -> bpy.types.NodeSocket:
        """Sum of products, channel by channel, as a chain of multiply-adds."""
        (first, weight), *rest = terms
        total = self.vector("MULTIPLY", first, weight)
        for value, weight in rest:
            total = self.vector("MULTIPLY_ADD", value, weight, total)
        return total
