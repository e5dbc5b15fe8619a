# SPDX-License-Identifier: GPL-3.0-or-later
"""The "PRT Relight" node group: transport from the mesh, light from the world, turned and multiplied in the shader.

The light is turned by the world's Mapping node, and, where the mesh says that its transport is in its object's own
axes, by the object itself.
"""

from __future__ import annotations

from math import sqrt

import bpy

from ...core.layout import BAKED_BELOW, LAYERS, OWN_AXES_BELOW
from ..blender.libraries import is_own
from ..blender.nodes import Graph
from ..blender.versions import refuse_newer, version_of
from ..light.drivers import STRENGTH, TURN
from ..light.light import LIGHT

GROUP = "PRT Relight"
GROUP_VERSION = 3
_VERSION = "prt_version"


def relight_group() -> bpy.types.NodeTree:
    """The node group of this version, built on first use and shared by all materials.

    It takes the place of older ones, and of copies of itself, which appended materials bring along.
    """
    own = [tree for tree in bpy.data.node_groups if is_relight_group(tree) and is_own(tree)]
    current = next((tree for tree in own if _version(tree) == GROUP_VERSION and _is_whole(tree)), None) or _built()
    for tree in own:
        if tree != current and _version(tree) <= GROUP_VERSION:
            tree.user_remap(current)
            bpy.data.node_groups.remove(tree)
    return current


_SOCKETS = {("Base Color", "INPUT"), ("Unbaked", "INPUT"), ("Surface", "OUTPUT"), ("Shading", "OUTPUT")}


def _is_whole(tree: bpy.types.NodeTree) -> bool:
    """Whether a group still has the sockets that it was built with, and feeds them: people may edit it."""
    sockets = {(item.name, item.in_out) for item in tree.interface.items_tree if item.item_type == "SOCKET"}
    output = next((node for node in tree.nodes if node.bl_idname == "NodeGroupOutput"), None)
    return sockets >= _SOCKETS and output is not None and all(entry.is_linked for entry in output.inputs if entry.name)


def is_relight_group(tree: bpy.types.NodeTree | None) -> bool:
    """Whether a node group is ours, of whatever version."""
    return tree is not None and _VERSION in tree


def is_newer(tree: bpy.types.NodeTree) -> bool:
    """Whether one of our node groups is of a newer version, whose sockets may be others."""
    return _version(tree) > GROUP_VERSION


def is_relit_by_newer(material: bpy.types.Material) -> bool:
    """Whether a newer version relights a material."""
    nodes = material.node_tree.nodes if material.node_tree else ()
    return any(
        node.bl_idname == "ShaderNodeGroup" and is_relight_group(node.node_tree) and is_newer(node.node_tree)
        for node in nodes
    )


def remove_unused_group() -> None:
    """Remove our node groups that no material uses any more."""
    trees = [tree for tree in bpy.data.node_groups if is_relight_group(tree) and is_own(tree)]
    bpy.data.batch_remove([tree for tree in trees if not tree.users])


def check_version(material: bpy.types.Material) -> None:
    """Raises VersionError if a newer version relights a material."""
    for node in material.node_tree.nodes if material.node_tree else ():
        if node.bl_idname == "ShaderNodeGroup" and is_relight_group(node.node_tree):
            refuse_newer(f"Material '{material.name}' is relit", _version(node.node_tree), GROUP_VERSION)


def _version(tree: bpy.types.NodeTree) -> int:
    return version_of(tree, _VERSION)


def _built() -> bpy.types.NodeTree:
    tree = bpy.data.node_groups.new(GROUP, "ShaderNodeTree")
    tree[_VERSION] = GROUP_VERSION
    _build(tree)
    return tree


def _build(tree: bpy.types.NodeTree) -> None:
    interface = tree.interface
    base = interface.new_socket("Base Color", in_out="INPUT", socket_type="NodeSocketColor")
    base.default_value = (0.8, 0.8, 0.8, 1.0)
    base.description = "Albedo of the surface, multiplied with the light that reaches it"
    unbaked = interface.new_socket("Unbaked", in_out="INPUT", socket_type="NodeSocketShader")
    unbaked.description = "What meshes without baked transport show"
    surface = interface.new_socket("Surface", in_out="OUTPUT", socket_type="NodeSocketShader")
    surface.description = "The relit surface"
    shading = interface.new_socket("Shading", in_out="OUTPUT", socket_type="NodeSocketColor")
    shading.description = "The light that a white surface would show"

    graph = Graph(tree)
    group_input = graph.add("NodeGroupInput")
    layers = [graph.attribute(name, "GEOMETRY") for name in LAYERS]
    light = [graph.attribute(name, "VIEW_LAYER").outputs["Vector"] for name in LIGHT]
    axes = [graph.attribute(name, "VIEW_LAYER").outputs["Vector"] for name in TURN]
    strength = graph.attribute(STRENGTH, "VIEW_LAYER").outputs["Fac"]

    graph.column()
    baked, own_axes = _marks(graph, layers)
    graph.column()
    axes = [graph.mixed(own_axes, *pair) for pair in zip(axes, _object_axes(graph, axes), strict=True)]
    graph.column()
    turned = [light[0], *_turned_vector(graph, light[1:4], axes), *_turned_form(graph, light[4:9], axes)]
    graph.column()
    radiance = graph.weighted_sum(
        [(layer.outputs["Vector"], value) for layer, value in zip(layers, turned, strict=True)]
    )
    shown = graph.vector("MULTIPLY", _without_negatives(graph, radiance), strength)
    colour = graph.vector("MULTIPLY", shown, group_input.outputs["Base Color"])

    graph.column()
    emission = graph.add("ShaderNodeEmission")
    graph.feed(emission.inputs["Color"], colour)
    mix = graph.add("ShaderNodeMixShader")
    graph.feed(mix.inputs[0], baked)
    graph.feed(mix.inputs[1], group_input.outputs["Unbaked"])
    graph.feed(mix.inputs[2], emission.outputs[0])
    graph.column()
    group_output = graph.add("NodeGroupOutput")
    graph.feed(group_output.inputs["Surface"], mix.outputs[0])
    graph.feed(group_output.inputs["Shading"], shown)


def _marks(graph: Graph, layers: list[bpy.types.Node]) -> tuple[bpy.types.NodeSocket, bpy.types.NodeSocket]:
    """Whether there is transport, and whether it is in the object's own axes: 0 or 1, as `core.layout` has it.

    A bake of version 1 is known by what no geometry without a bake has: alpha 0, and a colour.
    """
    mark, older_mark = (layer.outputs["Alpha"] for layer in layers[:2])
    current = graph.math("LESS_THAN", mark, BAKED_BELOW)
    colour = graph.vector("DOT_PRODUCT", layers[0].outputs["Vector"], (1.0, 1.0, 1.0))
    older = graph.math("MULTIPLY", graph.math("LESS_THAN", mark, 0.5), graph.math("GREATER_THAN", colour, 0.0))
    own = graph.math("LESS_THAN", mark, OWN_AXES_BELOW)
    return graph.math("MAXIMUM", current, older), graph.math(
        "MAXIMUM", own, graph.math("GREATER_THAN", older_mark, 0.5)
    )


def _without_negatives(graph: Graph, radiance: bpy.types.NodeSocket) -> bpy.types.NodeSocket:
    """Clamp after the dot product: a band-limited light may be negative where the sum of all is not.

    A colour with a negative channel goes towards the grey of its mean until none is negative. Clamped one by one, the
    channels that are left would make saturated blotches. Where the mean itself is negative, black is left.
    """
    least = graph.math("MINIMUM", graph.math("MINIMUM", *(parts := graph.components(radiance))[:2]), parts[2])
    mean = graph.math("MULTIPLY", graph.math("ADD", graph.math("ADD", *parts[:2]), parts[2]), 1.0 / 3.0)
    lacking = graph.math("MAXIMUM", graph.math("MULTIPLY", least, -1.0), 0.0)
    room = graph.math("MAXIMUM", graph.math("SUBTRACT", mean, least), 1e-9)
    share = graph.math("MINIMUM", graph.math("DIVIDE", lacking, room), 1.0)
    greyer = graph.vector("MULTIPLY_ADD", graph.vector("SUBTRACT", mean, radiance), share, radiance)
    return graph.vector("MAXIMUM", greyer, (0.0, 0.0, 0.0))


def _object_axes(graph: Graph, axes: list[bpy.types.NodeSocket]) -> list[bpy.types.NodeSocket]:
    """The object's axes o_i instead of the world's e_i, as the world's Mapping turns them: `R o_i = sum_k (o_i)_k R e_k`.

    They need only be orthogonal, not right-handed: a mirrored object's light is mirrored.
    """
    unit = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    components = [graph.components(graph.to_world(direction)) for direction in unit]
    graph.column()
    return [graph.weighted_sum(list(zip(axes, own, strict=True))) for own in components]


def _turned_vector(
    graph: Graph, band: list[bpy.types.NodeSocket], axes: list[bpy.types.NodeSocket]
) -> list[bpy.types.NodeSocket]:
    """Band 1, RGB vectors in the order y, z, x, turned: component i becomes `sum_k band_k (R e_i)_k`."""
    x, y, z = band[2], band[0], band[1]
    turned = []
    for axis in axes:
        weights = graph.components(axis)
        turned.append(graph.weighted_sum(list(zip((x, y, z), weights, strict=True))))
    return [turned[1], turned[2], turned[0]]


def _turned_form(
    graph: Graph, band: list[bpy.types.NodeSocket], axes: list[bpy.types.NodeSocket]
) -> list[bpy.types.NodeSocket]:
    """Band 2 as a symmetric form Q, one RGB vector per entry, turned to R^T Q R and read back.

    The form is scaled by 2 / K_XY, so that its off-diagonal entries are the coefficients themselves.
    """
    xy, yz, zz, zx, xx = band
    root3 = 1.0 / sqrt(3.0)  # 2 K_ZZ / K_XY
    low = graph.vector("MULTIPLY", zz, (-root3,) * 3)
    form = [
        [graph.vector("ADD", low, xx), xy, zx],
        [xy, graph.vector("SUBTRACT", low, xx), yz],
        [zx, yz, graph.vector("MULTIPLY", low, (-2.0,) * 3)],
    ]
    graph.column()
    columns = [graph.components(axis) for axis in axes]
    half = [[graph.weighted_sum(list(zip(row, column, strict=True))) for row in form] for column in columns]
    graph.column()

    def entry(i: int, j: int) -> bpy.types.NodeSocket:
        return graph.weighted_sum(list(zip(half[i], columns[j], strict=True)))

    difference = graph.vector("SUBTRACT", entry(0, 0), entry(1, 1))
    return [
        entry(0, 1),
        entry(1, 2),
        graph.vector("MULTIPLY", entry(2, 2), (0.5 / root3,) * 3),
        entry(0, 2),
        graph.vector("MULTIPLY", difference, (0.5,) * 3),
    ]
