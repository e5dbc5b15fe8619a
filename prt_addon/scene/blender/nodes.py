# SPDX-License-Identifier: GPL-3.0-or-later
"""Follows the links of shader node trees, and builds graphs by formula."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping
from typing import Literal

import bpy
import numpy as np
import numpy.typing as npt

PROCEDURAL_TEXTURES = {
    "ShaderNodeTexBrick",
    "ShaderNodeTexChecker",
    "ShaderNodeTexGabor",
    "ShaderNodeTexGradient",
    "ShaderNodeTexMagic",
    "ShaderNodeTexNoise",
    "ShaderNodeTexVoronoi",
    "ShaderNodeTexWave",
}
"""Textures that are laid over Generated coordinates where nothing feeds their Vector: in a world, along the view."""


class Wiring:
    """What feeds what in node trees, for as long as these do not change.

    Links are looked up once a tree: `socket.links` goes through all links of the tree each time. A muted link
    feeds nothing. A muted node hands an input on, as Blender has it. Reroutes are seen through, and lead nowhere in a loop.
    """

    def __init__(self) -> None:
        self._by_input: dict[int, dict[int, bpy.types.NodeSocket]] = {}
        self._by_output: dict[int, dict[int, list[bpy.types.NodeSocket]]] = {}

    def source(self, entry: bpy.types.NodeSocket) -> bpy.types.NodeSocket | None:
        """The output that feeds an input; None if nothing does."""
        links, seen = self._into(entry.id_data), set[int]()
        while (output := links.get(entry.as_pointer())) and output.as_pointer() not in seen:
            seen.add(output.as_pointer())
            passed = _passed_on(output)
            if passed is output:
                return output
            if passed is None:
                return None
            entry = passed
        return None

    def fed_by(self, output: bpy.types.NodeSocket) -> list[bpy.types.NodeSocket]:
        """The inputs that an output feeds."""
        links, seen = self._out_of(output.id_data), set[int]()
        fed, pending = [], [output]
        while pending:
            current = pending.pop()
            if current.as_pointer() in seen:
                continue
            seen.add(current.as_pointer())
            for entry in links.get(current.as_pointer(), ()):
                onward = [one for one in entry.node.outputs if _passed_on(one) == entry]
                pending += onward
                if not onward:
                    fed.append(entry)
        return fed

    def upstream(self, node: bpy.types.Node) -> Iterator[bpy.types.Node]:
        """A node and all that feed it, nearest first, each once."""
        seen, pending, links = {node.as_pointer()}, deque([node]), self._into(node.id_data)
        while pending:
            current = pending.popleft()
            yield current
            for entry in current.inputs:
                source = self.source(entry) if entry.as_pointer() in links else None
                if source and source.node.as_pointer() not in seen:
                    seen.add(source.node.as_pointer())
                    pending.append(source.node)

    def _into(self, tree: bpy.types.NodeTree) -> dict[int, bpy.types.NodeSocket]:
        """The output at the other end of the link into each input of a tree, by the input's pointer."""
        found = self._by_input.get(tree.as_pointer())
        if found is None:
            found = {link.to_socket.as_pointer(): link.from_socket for link in tree.links if not link.is_muted}
            self._by_input[tree.as_pointer()] = found
        return found

    def _out_of(self, tree: bpy.types.NodeTree) -> dict[int, list[bpy.types.NodeSocket]]:
        """The inputs at the other ends of the links out of each output, by the output's pointer."""
        found = self._by_output.get(tree.as_pointer())
        if found is None:
            found = self._by_output[tree.as_pointer()] = {}
            for link in tree.links:
                if not link.is_muted:
                    found.setdefault(link.from_socket.as_pointer(), []).append(link.to_socket)
        return found


def _passed_on(output: bpy.types.NodeSocket) -> bpy.types.NodeSocket | None:
    """The output itself; or the input that a reroute or a muted node hands on there, None if it hands on nothing."""
    node = output.node
    if node.bl_idname == "NodeReroute":
        return node.inputs[0]
    if node.mute:
        return next((link.from_socket for link in node.internal_links if link.to_socket == output), None)
    return output


_PLAIN_MAPPING: dict[str, object] = {
    "vector_type": "POINT",
    "mapping_x": "X",
    "mapping_y": "Y",
    "mapping_z": "Z",
    "use_min": False,
    "use_max": False,
    "translation": (0.0, 0.0, 0.0),
    "rotation": (0.0, 0.0, 0.0),
    "scale": (1.0, 1.0, 1.0),
}


def is_remapped(node: bpy.types.Node) -> bool:
    """Whether a texture node changes coordinates by its own mapping, which only scripts and old files have."""
    mapping = getattr(node, "texture_mapping", None)
    if mapping is None:
        return False
    now = {key: getattr(mapping, key) for key in _PLAIN_MAPPING}
    return any(
        (tuple(now[key]) if isinstance(plain, tuple) else now[key]) != plain for key, plain in _PLAIN_MAPPING.items()
    )


def mapping_matrix(mapping: bpy.types.Node) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """(3, 3) matrix and (3,) offset of a Mapping node whose inputs are numbers: it takes v to `M v + o`.

    As Blender's manual has it: a *Point* is scaled, rotated and moved; *Texture* is the inverse of that; a *Vector* is not
    moved. *Normal*, which is normalised afterwards, is none of these.

    Raises:
        ValueError: for a Normal.
    """
    values = {entry.name: np.array(entry.default_value, dtype=np.float64) for entry in mapping.inputs}
    location, rotation, scale = values.get("Location", np.zeros(3)), values["Rotation"], values["Scale"]
    turn = _euler_matrix(rotation)
    if mapping.vector_type == "TEXTURE":
        with np.errstate(divide="ignore"):
            inverse = np.where(scale != 0.0, 1.0 / np.where(scale != 0.0, scale, 1.0), 0.0)
        matrix = np.diag(inverse) @ turn.T
        return matrix, -matrix @ location
    if mapping.vector_type == "NORMAL":
        raise ValueError("normals are not mapped by a matrix alone")
    return turn @ np.diag(scale), location


def _euler_matrix(angles: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """(3, 3) `Rz Ry Rx`, Blender's XYZ order."""
    (cx, cy, cz), (sx, sy, sz) = np.cos(angles), np.sin(angles)
    about_x = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    about_y = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    about_z = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    matrix: npt.NDArray[np.float64] = about_z @ about_y @ about_x
    return matrix


def has_loop(tree: bpy.types.NodeTree) -> bool:
    """Whether nodes of a tree, or of a group in it, feed each other in a circle: Cycles crashes on such reroutes (4.5, 5.2)."""
    trees, pending = {tree}, [tree]
    while pending:
        current = pending.pop()
        groups = {node.node_tree for node in current.nodes if getattr(node, "node_tree", None)}
        pending += groups - trees
        trees |= groups
    return any(map(_is_circular, trees))


def _is_circular(tree: bpy.types.NodeTree) -> bool:
    """Take away what nothing feeds until nothing is left, or a circle (Kahn 1962)."""
    fed = {node.as_pointer(): 0 for node in tree.nodes}
    feeds: dict[int, list[int]] = {}
    for link in tree.links:
        fed[link.to_node.as_pointer()] += 1
        feeds.setdefault(link.from_node.as_pointer(), []).append(link.to_node.as_pointer())
    free = [node for node, count in fed.items() if not count]
    left = len(fed)
    while free:
        left -= 1
        for node in feeds.get(free.pop(), ()):
            fed[node] -= 1
            if not fed[node]:
                free.append(node)
    return left > 0


def feeding_socket(entry: bpy.types.NodeSocket) -> bpy.types.NodeSocket | None:
    """The output that feeds an input; None if nothing does. For many inputs, keep a `Wiring`."""
    return Wiring().source(entry)


_NODES_ARE_OPTIONAL = bpy.app.version < (5, 0, 0)
"""Since 5.0 materials and worlds always have nodes, and `use_nodes` is deprecated: it goes in 6.0."""


def nodes_are_on(block: bpy.types.Material | bpy.types.World) -> bool:
    """Whether a material or a world is made of nodes."""
    return not _NODES_ARE_OPTIONAL or bool(block.use_nodes)


def turn_nodes(block: bpy.types.Material | bpy.types.World, on: bool) -> None:
    """Switch the nodes of a material or a world on or off, where there is a choice."""
    if _NODES_ARE_OPTIONAL:
        block.use_nodes = on


HAD_NO_NODES = "prt_had_no_nodes"
"""Custom property of a material whose nodes we turned on, to relight it: before 5.0 they can be off."""


def uses_nodes(material: bpy.types.Material) -> bool:
    """Whether the user's material is made of nodes; if not, it is its viewport colour."""
    return nodes_are_on(material) and not material.get(HAD_NO_NODES)


class Graph:
    """Writes formulas into a node tree: each method adds one node and returns its output socket.

    Arguments are sockets to link, or constants. Nodes are laid out in columns, a new one after each `column()`.
    """

    def __init__(self, tree: bpy.types.NodeTree) -> None:
        self.tree = tree
        self._x = 0.0
        self._y = 0.0

    def column(self) -> None:
        """Start a new column to the right: what follows is a new step."""
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
        """Add scalar arithmetic."""
        node = self.add("ShaderNodeMath")
        node.operation = operation
        for entry, value in zip(node.inputs, values, strict=False):
            self.feed(entry, value)
        return node.outputs[0]

    def vector(self, operation: str, *values: object) -> bpy.types.NodeSocket:
        """Add arithmetic on three channels, for all of which a scalar socket counts; or a scalar such as a dot product."""
        node = self.add("ShaderNodeVectorMath")
        node.operation = operation
        for entry, value in zip(node.inputs, values, strict=False):
            self.feed(entry, value)
        return next(output for output in node.outputs if output.enabled)

    def mixed(
        self, factor: object, zero: object, one: object, kind: Literal["Vector", "Float"] = "Vector"
    ) -> bpy.types.NodeSocket:
        """Vector, or number, `zero` where the factor is 0, `one` where it is 1."""
        node = self.add("ShaderNodeMix")
        node.data_type = "VECTOR" if kind == "Vector" else "FLOAT"
        entries = {entry.identifier: entry for entry in node.inputs}
        for name, value in (("Factor_Float", factor), (f"A_{kind}", zero), (f"B_{kind}", one)):
            self.feed(entries[name], value)
        return next(output for output in node.outputs if output.identifier == f"Result_{kind}")

    def group(
        self, tree: bpy.types.NodeTree, inputs: Mapping[str, bpy.types.NodeSocket]
    ) -> dict[str, bpy.types.NodeSocket]:
        """The outputs of a group, by their names, that is fed by the names of its inputs."""
        node = self.add("ShaderNodeGroup")
        node.node_tree = tree
        for name, source in inputs.items():
            self.feed(node.inputs[name], source)
        return {output.name: output for output in node.outputs}

    def to_world(self, direction: object) -> bpy.types.NodeSocket:
        """Unit vector in world axes of a direction in the axes of the object that is shaded."""
        node = self.add("ShaderNodeVectorTransform")
        node.vector_type, node.convert_from, node.convert_to = "VECTOR", "OBJECT", "WORLD"
        self.feed(node.inputs[0], direction)
        return self.vector("NORMALIZE", node.outputs[0])

    def normal_or_surface_normal(self, normal: bpy.types.NodeSocket) -> bpy.types.NodeSocket:
        """A normal that a group is given; the surface's own where nothing feeds it, as it is 0 there."""
        fed = self.vector("DOT_PRODUCT", normal, normal)
        surface_normal = self.add("ShaderNodeNewGeometry").outputs["Normal"]
        return self.mixed(self.math("GREATER_THAN", fed, 0.0), surface_normal, normal)

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
