# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds the node group "PRT Relight": transport from the mesh, light from the world, turned and multiplied in the shader.

The light is turned by the world's Mapping node, and, where the mesh says that its transport is in its object's own
axes, by the object itself. Where lamps are added, what they show of the sky leaves the direct light; what they send on by bounces stays.

Backs of faces have transport of their own where the mesh has the layers, and the material a group that reads these.

Where there is none, a surface shows itself, save under a sky with lamps: their light adds to EEVEE's own of the sky, which holds
these spots, too. So it is relit there by the light of the open sky without them.

It hands out what the surfaces of a material are relit with: the light on a white one (Shading), whether it is relit
(Relit), how much of what a mirror would see there is sky (Sky Seen; all, while EEVEE traces reflections), and by how much more light
arrives where a normal is bent along an axis of the world (Detail). Base Color, Unbaked and Surface are a matte surface.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import bpy

from ...core.layout import BAKED_BELOW, LAYERS, OWN_AXES_BELOW
from ..blender.libraries import is_local
from ..blender.nodes import Graph
from ..blender.versions import refuse_newer, version_of
from ..light.drivers import STRENGTH, TURN
from ..light.light import LIGHT
from .helper_groups import is_whole, note_links
from .light_nodes import DETAIL, Y_0, less_colour
from .relight_parts import (
    axes_of_transport,
    detail,
    of_this_side,
    received,
    remove_unused_parts,
    sky_seen,
    turned_light,
    unshadowed,
    without_negatives,
)

GROUP = "PRT Relight"
GROUP_VERSION = 8
_VERSION, _SIDES = "prt_version", "prt_sides"
Sides = Literal["NONE", "FRONTS", "BOTH"]
_NAMES: dict[Sides, str] = {"NONE": f"{GROUP} Unbaked", "FRONTS": GROUP, "BOTH": f"{GROUP} Both Sides"}


def relight_group(sides: Sides = "FRONTS") -> bpy.types.NodeTree:
    """The node group of this version, built on first use and shared by all materials.

    It takes the place of older ones, of those that have lost sockets or links, and of copies of itself, which appended materials bring
    along.

    Args:
        sides: whose transport it reads; that of backs takes three more of the attributes that EEVEE has for a material. One that
            reads none has room for all of the user's own, and relights under skies with lamps alone.
    """
    local = [tree for tree in bpy.data.node_groups if is_relight_group(tree) and is_local(tree)]
    local = [tree for tree in local if _sides(tree) == sides]
    whole = (tree for tree in local if _version(tree) == GROUP_VERSION and is_whole(tree, _SOCKETS))
    current = next(whole, None) or _built(sides)
    for tree in local:
        if tree != current and _version(tree) <= GROUP_VERSION:
            tree.user_remap(current)
            bpy.data.node_groups.remove(tree)
    remove_unused_parts()
    return current


_INPUTS = (
    ("Base Color", "Color", "Albedo of a matte surface, multiplied with the light that reaches it"),
    ("Unbaked", "Shader", "What meshes without baked transport show, under a sky without lamps"),
    (
        "Lamps",
        "Float",
        "1 where the light of lamps is added to Shading, which leaves out what they show of the sky then; else 0",
    ),
)
_OUTPUTS = (
    ("Surface", "Shader", "A relit matte surface"),
    ("Shading", "Color", "The light that a white surface would show"),
    ("Relit", "Float", "1 where the mesh has transport, and everywhere under a sky with lamps; else 0"),
    (
        "Sky Seen",
        "Float",
        "How much of what a mirror would see is sky, and not the scene: 0 to 1; 1 if EEVEE traces reflections",
    ),
    *((name, "Color", "How the light grows with that component of the normal") for name in DETAIL),
)
_SOCKETS = {(name, "INPUT") for name, _, _ in _INPUTS} | {(name, "OUTPUT") for name, _, _ in _OUTPUTS}


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
    trees = [tree for tree in bpy.data.node_groups if is_relight_group(tree) and is_local(tree)]
    bpy.data.batch_remove([tree for tree in trees if not tree.users])
    remove_unused_parts()


def check_version(material: bpy.types.Material) -> None:
    """Raises VersionError if a newer version relights a material."""
    for node in material.node_tree.nodes if material.node_tree else ():
        if node.bl_idname == "ShaderNodeGroup" and is_relight_group(node.node_tree):
            refuse_newer(f"Material '{material.name}' is relit", _version(node.node_tree), GROUP_VERSION)


def _version(tree: bpy.types.NodeTree) -> int:
    return version_of(tree, _VERSION)


def _sides(tree: bpy.types.NodeTree) -> str:
    """What a group reads; before version 8 a mark said whether it reads backs."""
    return str(tree.get(_SIDES, "BOTH" if tree.get("prt_backs") else "FRONTS"))


def _built(sides: Sides) -> bpy.types.NodeTree:
    tree = bpy.data.node_groups.new(_NAMES[sides], "ShaderNodeTree")
    tree[_VERSION], tree[_SIDES] = GROUP_VERSION, sides
    _build(tree, sides)
    note_links(tree)
    return tree


@dataclass(frozen=True)
class _Sky:
    """The light of the sky, in the axes of the transport.

    light: nine coefficients of all of it.
    lamps: of what lamps show, before their colour.
    less_colour: that colour, negative; 0 where the light of lamps is not added.
    """

    light: list[bpy.types.NodeSocket]
    lamps: list[bpy.types.NodeSocket]
    less_colour: bpy.types.NodeSocket

    def soft(self, graph: Graph) -> list[bpy.types.NodeSocket]:
        """The light without lamps."""
        pairs = zip(self.lamps, self.light, strict=True)
        return [graph.vector("MULTIPLY_ADD", self.less_colour, *pair) for pair in pairs]


def _build(tree: bpy.types.NodeTree, sides: Sides) -> None:
    _add_sockets(tree)
    graph = Graph(tree)
    entries = graph.add("NodeGroupInput").outputs
    layers = [graph.attribute(name, "GEOMETRY") for name in (LAYERS if sides != "NONE" else ())]
    turn, strength = [graph.attribute(name, "VIEW_LAYER") for name in TURN], graph.attribute(STRENGTH, "VIEW_LAYER")
    graph.column()
    baked, own_axes, older = _marks(graph, layers) if layers else [graph.add("ShaderNodeValue").outputs[0]] * 3
    graph.column()
    axes, object_axes = axes_of_transport(graph, [node.outputs["Vector"] for node in turn], own_axes)
    graph.column()
    sky = _turned_sky(graph, turn, axes, entries["Lamps"])
    soft = sky.soft(graph)
    graph.column()
    open_sky = graph.math("MAXIMUM", graph.math("SUBTRACT", 1.0, baked), older)  # or how open it is is not known
    radiance, seen, share = unshadowed(graph, soft), open_sky, open_sky
    if layers:
        transport, direct = [layer.outputs["Vector"] for layer in layers], _direct(graph, layers, own_axes)
        if sides == "BOTH":
            transport, direct = of_this_side(graph, transport, direct)
        radiance = graph.mixed(baked, radiance, _reflected(graph, sky, transport, direct, older))
        seen = graph.math("MAXIMUM", seen, sky_seen(graph, direct, own_axes, object_axes))
        share = graph.math("MAXIMUM", share, graph.math("MULTIPLY", direct[0], 1.0 / Y_0))
    graph.column()
    shown = graph.vector("MULTIPLY", without_negatives(graph, radiance), strength.outputs["Fac"])
    share = graph.math("MULTIPLY", share, strength.outputs["Fac"])
    relit = graph.math("MAXIMUM", baked, _lamps_are_added(graph, sky, strength))
    details = detail(graph, soft[1:], share, own_axes, object_axes)
    graph.column()
    surface, seen = _matte(graph, entries, shown, relit), graph.math("MAXIMUM", seen, _traced(graph))
    graph.column()
    end = graph.add("NodeGroupOutput")
    results = {"Surface": surface, "Shading": shown, "Relit": relit, "Sky Seen": seen}
    for name, socket in (*results.items(), *zip(DETAIL, details, strict=True)):
        graph.feed(end.inputs[name], socket)


def _turned_sky(
    graph: Graph, turn: list[bpy.types.Node], axes: list[bpy.types.NodeSocket], lamps: bpy.types.NodeSocket
) -> _Sky:
    light = [graph.attribute(name, "VIEW_LAYER").outputs for name in LIGHT]
    graph.column()
    every, of_lamps = (turned_light(graph, [outputs[name] for outputs in light], axes) for name in ("Vector", "Alpha"))
    return _Sky(every, of_lamps, graph.vector("MULTIPLY", less_colour(graph, turn), lamps))


def _reflected(
    graph: Graph,
    sky: _Sky,
    transport: list[bpy.types.NodeSocket],
    direct: list[bpy.types.NodeSocket],
    older: bpy.types.NodeSocket,
) -> bpy.types.NodeSocket:
    """What a white surface sends out. Bakes of version 1 do not know what of it came straight from the lamps: all is taken out."""
    of_lamps = graph.mixed(older, received(graph, direct, sky.lamps), received(graph, transport, sky.lamps))
    return graph.vector("MULTIPLY_ADD", of_lamps, sky.less_colour, received(graph, transport, sky.light))


def _lamps_are_added(graph: Graph, sky: _Sky, strength: bpy.types.Node) -> bpy.types.NodeSocket:
    """Whether the sky has lamps whose light is added. Where there is no light at all, what is read of the turn is no colour."""
    size = graph.math("MULTIPLY", strength.outputs["Alpha"], graph.vector("LENGTH", sky.less_colour))
    return graph.math("GREATER_THAN", graph.math("ABSOLUTE", size), 0.0)


def _add_sockets(tree: bpy.types.NodeTree) -> None:
    for sockets, side in ((_INPUTS, "INPUT"), (_OUTPUTS, "OUTPUT")):
        for name, kind, description in sockets:
            socket = tree.interface.new_socket(name, in_out=side, socket_type=f"NodeSocket{kind}")
            socket.description = description
            if side == "INPUT" and kind == "Color":
                socket.default_value = (0.8, 0.8, 0.8, 1.0)


def _traced(graph: Graph) -> bpy.types.NodeSocket:
    """1 while EEVEE traces reflections in the scene that is drawn: it finds by itself what hides the sky."""
    node = graph.add("ShaderNodeValue", "Raytracing")
    driver = graph.tree.driver_add(f'nodes["{node.name}"].outputs[0].default_value').driver
    driver.type = "SUM"
    variable = driver.variables.new()
    variable.type = "CONTEXT_PROP"
    variable.targets[0].context_property, variable.targets[0].data_path = "ACTIVE_SCENE", "eevee.use_raytracing"
    return node.outputs[0]


def _matte(
    graph: Graph, entries: bpy.types.NodeInputs, shown: bpy.types.NodeSocket, relit: bpy.types.NodeSocket
) -> bpy.types.NodeSocket:
    """A surface that reflects the light alike in all directions; where it is not relit, the user's own."""
    emission = graph.add("ShaderNodeEmission")
    graph.feed(emission.inputs["Color"], graph.vector("MULTIPLY", shown, entries["Base Color"]))
    mix = graph.add("ShaderNodeMixShader")
    graph.feed(mix.inputs[0], relit)
    graph.feed(mix.inputs[1], entries["Unbaked"])
    graph.feed(mix.inputs[2], emission.outputs[0])
    return mix.outputs[0]


def _marks(graph: Graph, layers: list[bpy.types.Node]) -> list[bpy.types.NodeSocket]:
    """Whether there is transport, whether it is in the object's own axes, and whether it is of version 1: 0 or 1, as
    `core.layout` has it.

    A bake of version 1 is known by what no geometry without a bake has: alpha 0, and a colour.
    """
    mark, older_mark = (layer.outputs["Alpha"] for layer in layers[:2])
    current = graph.math("LESS_THAN", mark, BAKED_BELOW)
    colour = graph.vector("DOT_PRODUCT", layers[0].outputs["Vector"], (1.0, 1.0, 1.0))
    unmarked = graph.math("MULTIPLY", graph.math("LESS_THAN", mark, 0.5), graph.math("GREATER_THAN", colour, 0.0))
    older = graph.math("MULTIPLY", unmarked, graph.math("SUBTRACT", 1.0, current))
    own_axes = graph.math("LESS_THAN", mark, OWN_AXES_BELOW)
    older_own_axes = graph.math("MULTIPLY", older, graph.math("GREATER_THAN", older_mark, 0.5))
    return [graph.math("MAXIMUM", current, older), graph.math("MAXIMUM", own_axes, older_own_axes), older]


def _direct(graph: Graph, layers: list[bpy.types.Node], own_axes: bpy.types.NodeSocket) -> list[bpy.types.NodeSocket]:
    """The nine coefficients of direct transport, without the mark in the first, as `core.layout` has it."""
    first = graph.math("ADD", layers[0].outputs["Alpha"], graph.math("ADD", own_axes, 1.0))
    return [first, *(layer.outputs["Alpha"] for layer in layers[1:])]
