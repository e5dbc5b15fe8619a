# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds the node group "PRT Energy Compensation", and puts it before Glossy BSDFs of type GGX, which lose light.

Rough mirrors lose what meets more than one of them. The group brightens the colour of a Glossy BSDF by what is lost, as
Cycles' *Multiscatter GGX* does (Turquin 2019, "Practical multiple scattering compensation for microfacet models"), with the
colour of further bounces as `core.microfacet.compensation.bounce_colour` has it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from functools import reduce

import bpy

from ...core.microfacet import fit
from ..blender.libraries import is_local
from ..blender.nodes import Graph, feeding_socket
from ..material.reading import PART

GROUP = "PRT Energy Compensation"
_MARK = "prt_energy_compensation"
"""Custom property of the group: its version."""
_VERSION = 1
_HANDED_ON = ("Color", "Roughness")


def energy_group() -> bpy.types.NodeTree:
    """The group, built on first use and shared by all materials."""
    found = next((tree for tree in bpy.data.node_groups if tree.get(_MARK) == _VERSION and is_local(tree)), None)
    return found or _built()


def glossy_nodes(material: bpy.types.Material) -> Iterator[bpy.types.Node]:
    """Glossy BSDFs of type GGX among a material's own nodes; those that this extension adds are copies of them."""
    for node in material.node_tree.nodes if material.node_tree else ():
        if node.bl_idname == "ShaderNodeBsdfAnisotropic" and node.distribution == "GGX" and PART not in node:
            yield node


def compensate(materials: Iterable[bpy.types.Material]) -> int:
    """Put the group before each Glossy BSDF that has none; how many got one."""
    nodes = [node for material in materials for node in glossy_nodes(material) if _group_before(node) is None]
    for node in nodes:
        _insert(node)
    return len(nodes)


def take_out(materials: Iterable[bpy.types.Material]) -> int:
    """Take all groups out again; their inputs feed the Glossy BSDFs. How many there were."""
    nodes = [node for material in materials if material.node_tree for node in material.node_tree.nodes]
    groups = [node for node in nodes if _is_energy_group(node)]
    for node in groups:
        _remove(node)
    tree = next((tree for tree in bpy.data.node_groups if _MARK in tree and is_local(tree) and not tree.users), None)
    if tree:
        bpy.data.node_groups.remove(tree)
    return len(groups)


def _is_energy_group(node: bpy.types.Node) -> bool:
    return node.bl_idname == "ShaderNodeGroup" and node.node_tree is not None and _MARK in node.node_tree


def _group_before(glossy: bpy.types.Node) -> bpy.types.Node | None:
    source = feeding_socket(glossy.inputs["Color"])
    return source.node if source and _is_energy_group(source.node) else None


def _insert(glossy: bpy.types.Node) -> None:
    tree = glossy.id_data
    group = tree.nodes.new("ShaderNodeGroup")
    group.node_tree, group.name, group.label, group.width = energy_group(), GROUP, GROUP, 200.0
    group.location = (glossy.location.x - 240.0, glossy.location.y)
    for name in (*_HANDED_ON, "Normal"):
        _move(tree, glossy.inputs[name], group.inputs[name])
    for name in _HANDED_ON:
        tree.links.new(group.outputs[name], glossy.inputs[name])


def _remove(group: bpy.types.Node) -> None:
    tree = group.id_data
    for name in _HANDED_ON:
        for link in list(group.outputs[name].links):
            entry = link.to_socket
            tree.links.remove(link)
            _move(tree, group.inputs[name], entry)
    tree.nodes.remove(group)


def _move(tree: bpy.types.NodeTree, source: bpy.types.NodeSocket, target: bpy.types.NodeSocket) -> None:
    """Have one input be what another is, its number and what feeds it."""
    if source.type == target.type and not source.hide_value:
        target.default_value = source.default_value
    if source.is_linked:
        tree.links.new(source.links[0].from_socket, target)


def _built() -> bpy.types.NodeTree:
    tree = bpy.data.node_groups.new(GROUP, "ShaderNodeTree")
    tree[_MARK] = _VERSION
    for name, kind, description in (
        ("Color", "Color", "Of the metal"),
        ("Roughness", "Float", "As the Glossy BSDF has it"),
        ("Normal", "Vector", "As the Glossy BSDF has it, if it has one"),
    ):
        entry = tree.interface.new_socket(
            name, in_out="INPUT", socket_type=f"NodeSocket{kind}", description=description
        )
        entry.hide_value = name == "Normal"
    tree.interface.new_socket(
        "Color",
        in_out="OUTPUT",
        socket_type="NodeSocketColor",
        description="For the Glossy BSDF: brighter by what it loses",
    )
    tree.interface.new_socket(
        "Roughness", in_out="OUTPUT", socket_type="NodeSocketFloat", description="For the Glossy BSDF, as it is"
    )
    graph = Graph(tree)
    given = graph.add("NodeGroupInput").outputs
    graph.column()
    cosine = graph.math(
        "ABSOLUTE", graph.vector("DOT_PRODUCT", graph.normal_or_surface_normal(given["Normal"]), _incoming(graph))
    )
    roughness = graph.math("MINIMUM", graph.math("MAXIMUM", given["Roughness"], 0.0), 1.0)
    spread = graph.math("MULTIPLY_ADD", roughness, roughness, graph.math("MAXIMUM", cosine, 1e-3))
    x = graph.math("DIVIDE", cosine, spread)
    graph.column()
    albedo = _polynomial(graph, x, [_polynomial(graph, roughness, row) for row in fit.ALBEDO])
    lost = graph.math("SUBTRACT", graph.math("DIVIDE", 1.0, albedo), 1.0)
    graph.column()
    colour = _brightened(graph, given["Color"], _polynomial(graph, roughness, fit.AVERAGE), lost)
    graph.column()
    end = graph.add("NodeGroupOutput")
    graph.feed(end.inputs["Color"], colour)
    graph.feed(end.inputs["Roughness"], given["Roughness"])
    return tree


def _incoming(graph: Graph) -> bpy.types.NodeSocket:
    return graph.add("ShaderNodeNewGeometry").outputs["Incoming"]


def _polynomial(
    graph: Graph, x: bpy.types.NodeSocket, coefficients: Sequence[float | bpy.types.NodeSocket]
) -> bpy.types.NodeSocket:
    """`c0 + c1 x + c2 x**2 ...`, by Horner's rule."""
    *rest, last = coefficients
    return reduce(lambda value, c: graph.math("MULTIPLY_ADD", value, x, c), reversed(rest), last)


def _brightened(
    graph: Graph, colour: bpy.types.NodeSocket, average: bpy.types.NodeSocket, lost: bpy.types.NodeSocket
) -> bpy.types.NodeSocket:
    """`F + F**2 E_avg / (1 - F (1 - E_avg)) lost`, with lost = (1 - E) / E."""
    kept = graph.math("SUBTRACT", average, 1.0)
    leaving = graph.vector("MULTIPLY_ADD", colour, kept, (1.0, 1.0, 1.0))
    bounces = graph.vector(
        "DIVIDE", graph.vector("MULTIPLY", graph.vector("MULTIPLY", colour, colour), average), leaving
    )
    return graph.vector("MULTIPLY_ADD", bounces, lost, colour)
