# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds node groups that relight single shaders, beside "PRT Relight": the light of lamps, normal detail, the diffuse part of each BSDF.

Their inputs are called as the BSDF calls its own, so that a group node is fed as the BSDF is.
"""

from __future__ import annotations

from collections.abc import Callable

import bpy

from ..blender.libraries import is_local
from ..blender.nodes import Graph
from ..blender.versions import version_of
from ..light.drivers import STRENGTH, TURN
from ..light.light import LIGHT
from ..material.reading import PART
from .light_nodes import DETAIL, Y_0, Y_1, less_colour, turned_vector

_VERSION, _FOR_LENGTH, _LINKS = "prt_helper_version", "prt_limits_length", "prt_links"
"""Custom properties of a group: our version of it; whether it was built for a Blender that limits length; with how many links."""
_LIMITS_LENGTH = bpy.app.version >= (5, 1, 0)
"""What EEVEE limits of the light of the sky: see `_ambient`."""
_CURRENT = 6
"""Versions 4 and 5 stood for one of ours, on a Blender before 5.1 and since."""

Sockets = dict[str, bpy.types.NodeSocket]
Kinds = dict[str, str]
LIGHT_GIVEN = {"Shading": "Color", "Lamps": "Color", "Sky Seen": "Float"}
"""What all groups that relight a shader are given."""


def lamps_group() -> bpy.types.NodeTree:
    """The light of lamps on a white diffuse surface, with their shadows.

    EEVEE adds its own light of the sky to that of lamps, and a shader cannot have the one without the other. But its own is known:
    bands 0 and 1 of the SH light, the second weakened until it does not outdo the first.
    """
    return part_group("PRT Lamps", {"Normal": "Vector"}, {"Lamps": "Color"}, _lamps)


def renew_lamps_group() -> None:
    """Replace the group of a file that another version of Blender saved, whose EEVEE has another light of the sky."""
    if _replaceable("PRT Lamps"):
        lamps_group()


def detail_group() -> bpy.types.NodeTree:
    """The baked light at a normal that a map or a bump bends away from the surface's own."""
    inputs = {"Normal": "Vector", "Shading": "Color", **dict.fromkeys(DETAIL, "Color")}
    return part_group("PRT Detail", inputs, {"Shading": "Color"}, _detail)


def diffuse_group() -> bpy.types.NodeTree:
    """What reflects all light alike in all directions."""
    return part_group("PRT Diffuse", {"Color": "Color", **LIGHT_GIVEN}, {"Diffuse": "Shader"}, _diffuse)


def glossy_group(colour: str = "Color") -> bpy.types.NodeTree:
    """What a glossy BSDF mirrors of the scene, and the colour it is left with for the sky.

    Args:
        colour: how the BSDF calls its own.
    """
    results = {"Diffuse": "Shader", colour: "Color"}
    return part_group(f"PRT Glossy {colour}", {colour: "Color", **LIGHT_GIVEN}, results, _glossy)


def principled_group() -> bpy.types.NodeTree:
    """The diffuse part of a Principled BSDF with what its gloss mirrors of the scene, and what the rest is fed with."""
    numbers = ("Metallic", "Roughness", "IOR", "Alpha", "Specular IOR Level", "Transmission Weight", "Coat Weight")
    inputs = {"Base Color": "Color", **dict.fromkeys(numbers, "Float"), **LIGHT_GIVEN}
    results = {"Diffuse": "Shader", "Base Color": "Color", "Specular IOR Level": "Float", "Coat Weight": "Float"}
    return part_group("PRT Principled", inputs, results, _principled)


def part_group(
    name: str, inputs: Kinds, outputs: Kinds, build: Callable[[Graph, Sockets], Sockets]
) -> bpy.types.NodeTree:
    """The group of a name, built on first use and shared by all materials. Marked as a part, it goes with its last user.

    It takes the place of others of that name: those of older versions or for another Blender, those that have lost sockets or links, and
    copies of itself, which appended materials bring along.

    Args:
        name: of the group.
        inputs: kinds of its sockets by their names.
        outputs: likewise.
        build: adds the nodes between them; given the inputs, it returns what feeds the outputs.
    """
    sockets = {(label, "INPUT") for label in inputs} | {(label, "OUTPUT") for label in outputs}
    found = _replaceable(name)
    usable = (tree for tree in found if _is_current(tree) and is_whole(tree, sockets))
    current = next(usable, None) or _built(name, inputs, outputs, build)
    for tree in found:
        if tree != current:
            tree.user_remap(current)
            bpy.data.node_groups.remove(tree)
    return current


def _replaceable(name: str) -> list[bpy.types.NodeTree]:
    """The groups of a name that this version may replace: not those of newer ones, nor of libraries."""
    named = [tree for tree in bpy.data.node_groups if tree.get(PART) == name and _VERSION in tree and is_local(tree)]
    return [tree for tree in named if version_of(tree, _VERSION) <= _CURRENT]


def _is_current(tree: bpy.types.NodeTree) -> bool:
    return version_of(tree, _VERSION) == _CURRENT and bool(tree.get(_FOR_LENGTH)) == _LIMITS_LENGTH


def is_whole(tree: bpy.types.NodeTree, sockets: set[tuple[str, str]]) -> bool:
    """Whether a group of ours still works: people may edit it. What they add, or set otherwise, may stay.

    Args:
        tree: the group.
        sockets: names and sides ("INPUT", "OUTPUT") of those that it must have.
    """
    found = {(item.name, item.in_out) for item in tree.interface.items_tree if item.item_type == "SOCKET"}
    output = next((node for node in tree.nodes if node.bl_idname == "NodeGroupOutput"), None)
    is_fed = output is not None and all(entry.is_linked for entry in output.inputs if entry.name)
    return found >= sockets and is_fed and _keeps_links(tree)


def _keeps_links(tree: bpy.types.NodeTree) -> bool:
    """Whether a group, and those inside of it, have no fewer links than they were built with."""
    inside = [node.node_tree for node in tree.nodes if node.bl_idname == "ShaderNodeGroup"]
    return len(tree.links) >= version_of(tree, _LINKS) and all(group and _keeps_links(group) for group in inside)


def note_links(tree: bpy.types.NodeTree) -> None:
    """Note with how many links a group was built: see `is_whole`."""
    tree[_LINKS] = len(tree.links)


def _built(name: str, inputs: Kinds, outputs: Kinds, build: Callable[[Graph, Sockets], Sockets]) -> bpy.types.NodeTree:
    tree = bpy.data.node_groups.new(name, "ShaderNodeTree")
    tree[PART], tree[_VERSION], tree[_FOR_LENGTH] = name, _CURRENT, _LIMITS_LENGTH
    for sockets, side in ((inputs, "INPUT"), (outputs, "OUTPUT")):
        for label, kind in sockets.items():
            tree.interface.new_socket(label, in_out=side, socket_type=f"NodeSocket{kind}")
    graph = Graph(tree)
    entries = graph.add("NodeGroupInput").outputs
    graph.column()
    results = build(graph, {entry.name: entry for entry in entries})
    graph.column()
    end = graph.add("NodeGroupOutput")
    for label, socket in results.items():
        graph.feed(end.inputs[label], socket)
    note_links(tree)
    return tree


def _lamps(graph: Graph, given: Sockets) -> Sockets:
    normal = graph.normal_or_surface_normal(given["Normal"])
    diffuse, light = graph.add("ShaderNodeBsdfDiffuse"), graph.add("ShaderNodeShaderToRGB")
    diffuse.inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    graph.feed(diffuse.inputs["Normal"], normal)
    graph.feed(light.inputs[0], diffuse.outputs[0])
    graph.column()
    strength = graph.attribute(STRENGTH, "VIEW_LAYER")
    ambient = graph.vector("MULTIPLY", _ambient(graph, normal, strength.outputs["Alpha"]), strength.outputs["Fac"])
    lamps = graph.vector("SUBTRACT", light.outputs["Color"], ambient)
    allowed = graph.math("GREATER_THAN", graph.math("ABSOLUTE", strength.outputs["Alpha"]), 0.0)
    return {"Lamps": graph.vector("MULTIPLY", graph.vector("MAXIMUM", lamps, (0.0, 0.0, 0.0)), allowed)}


def _ambient(graph: Graph, normal: bpy.types.NodeSocket, lamps: bpy.types.NodeSocket) -> bpy.types.NodeSocket:
    """What EEVEE lights a white diffuse surface with where no lamp shines: `Y_0 L_0 + 2/3 w Y_1 L_1`.

    The weight w is 1, or by what EEVEE scales band 1 so that of no channel it exceeds band 0: before 5.1 by its largest coefficient in the
    world's axes, `Y_1 |L_1m| <= Y_0 L_0`; since then by its length, `|L_1| <= 3/4 L_0`. Measured on eight skies, to 1 %.

    Args:
        graph: of the group.
        normal: of the surface.
        lamps: the last of the strength, see `light.drivers`.
    """
    turn, light = ([graph.attribute(name, "VIEW_LAYER") for name in names] for names in (TURN, LIGHT[:4]))
    axes = [node.outputs["Vector"] for node in turn]
    graph.column()
    unseen = graph.vector("MULTIPLY", less_colour(graph, turn), graph.math("LESS_THAN", lamps, 0.0))
    mean, *band = (
        graph.vector("MULTIPLY_ADD", unseen, node.outputs["Alpha"], node.outputs["Vector"]) for node in light
    )
    graph.column()
    unwindowed = graph.math("ABSOLUTE", lamps)
    y, z, x = (graph.vector("MULTIPLY", one, unwindowed) for one in turned_vector(graph, band, axes))
    graph.column()
    most = _length(graph, x, y, z) if _LIMITS_LENGTH else _largest(graph, x, y, z)
    room = graph.components(graph.vector("DIVIDE", mean, graph.vector("MAXIMUM", most, (1e-8,) * 3)))
    least = graph.math("MINIMUM", graph.math("MINIMUM", *room[:2]), room[2])
    weight = graph.math("MINIMUM", graph.math("MULTIPLY", least, 0.75 if _LIMITS_LENGTH else Y_0 / Y_1), 1.0)
    graph.column()
    directed = graph.weighted_sum(list(zip((x, y, z), graph.components(normal), strict=True)))
    directed = graph.vector("MULTIPLY", directed, graph.math("MULTIPLY", weight, Y_1 * 2.0 / 3.0))
    return graph.vector("MULTIPLY_ADD", mean, (Y_0,) * 3, directed)


def _length(graph: Graph, *vectors: bpy.types.NodeSocket) -> bpy.types.NodeSocket:
    """Root of the sum of squares, channel by channel."""
    squares = graph.weighted_sum([(one, one) for one in vectors])
    return graph.vector("POWER", squares, (0.5,) * 3)


def _largest(graph: Graph, *vectors: bpy.types.NodeSocket) -> bpy.types.NodeSocket:
    """Largest absolute value, channel by channel."""
    first, second, third = (graph.vector("ABSOLUTE", one) for one in vectors)
    return graph.vector("MAXIMUM", graph.vector("MAXIMUM", first, second), third)


def _detail(graph: Graph, given: Sockets) -> Sockets:
    """Adds the gradient of the light times what the normal is bent by."""
    own = graph.add("ShaderNodeNewGeometry").outputs["Normal"]
    bent = graph.components(graph.vector("SUBTRACT", given["Normal"], own))
    more = graph.weighted_sum([(given[name], by) for name, by in zip(DETAIL, bent, strict=True)])
    return {"Shading": graph.vector("MAXIMUM", graph.vector("ADD", given["Shading"], more), (0.0, 0.0, 0.0))}


def _diffuse(graph: Graph, given: Sockets) -> Sockets:
    light = graph.vector("ADD", given["Shading"], given["Lamps"])
    return {"Diffuse": _emission(graph, graph.vector("MULTIPLY", light, given["Color"]))}


def _glossy(graph: Graph, given: Sockets) -> Sockets:
    """EEVEE's gloss mirrors the sky as if nothing stood before it.

    So it is dimmed to the share of sky that is seen there. What stands in the sky's place is taken to send as much light as what
    arrives at the surface does on average.
    """
    name, colour = next(iter(given.items()))
    hidden = graph.math("SUBTRACT", 1.0, given["Sky Seen"])
    arriving = graph.vector("ADD", given["Shading"], given["Lamps"])
    scene = graph.vector("MULTIPLY", graph.vector("MULTIPLY", arriving, colour), hidden)
    return {"Diffuse": _emission(graph, scene), name: graph.vector("MULTIPLY", colour, given["Sky Seen"])}


def _principled(graph: Graph, given: Sockets) -> Sockets:
    """Diffuse: `base (1 - E)`, of what is neither metal nor transmits. Gloss as in `_glossy`."""
    base, metallic, seen = given["Base Color"], given["Metallic"], given["Sky Seen"]
    opaque = graph.math("SUBTRACT", 1.0, given["Transmission Weight"])
    diffuse = graph.math("MULTIPLY", graph.math("SUBTRACT", 1.0, metallic), opaque)
    gloss = _specular_albedo(graph, given)
    graph.column()
    matte = graph.vector("MULTIPLY", base, graph.math("MULTIPLY", diffuse, graph.math("SUBTRACT", 1.0, gloss)))
    hidden = graph.math("MULTIPLY", graph.math("SUBTRACT", 1.0, seen), opaque)
    both = graph.vector("MULTIPLY_ADD", graph.mixed(metallic, gloss, base), hidden, matte)
    light = graph.vector("MULTIPLY", both, graph.vector("ADD", given["Shading"], given["Lamps"]))
    graph.column()
    left = graph.math("SUBTRACT", 1.0, diffuse)
    dimmed = graph.math("MULTIPLY", left, graph.math("MULTIPLY_ADD", metallic, graph.math("SUBTRACT", seen, 1.0), 1.0))
    return {
        "Diffuse": _emission(graph, light, given["Alpha"]),
        "Base Color": graph.vector("MULTIPLY", base, dimmed),
        **{name: graph.math("MULTIPLY", given[name], seen) for name in ("Specular IOR Level", "Coat Weight")},
    }


def _emission(graph: Graph, colour: bpy.types.NodeSocket, strength: object = 1.0) -> bpy.types.NodeSocket:
    emission = graph.add("ShaderNodeEmission")
    graph.feed(emission.inputs["Color"], colour)
    graph.feed(emission.inputs["Strength"], strength)
    return emission.outputs[0]


def _specular_albedo(graph: Graph, given: Sockets) -> bpy.types.NodeSocket:
    """How much of the light a dielectric's gloss reflects in all, E, as seen from the camera."""
    ior = given["IOR"]
    ratio = graph.math("DIVIDE", graph.math("SUBTRACT", ior, 1.0), graph.math("ADD", ior, 1.0))
    level = graph.math("MULTIPLY", given["Specular IOR Level"], 2.0)
    straight = graph.math("MULTIPLY", graph.math("MULTIPLY", ratio, ratio), level)
    scale, bias = split_sum(graph, given["Roughness"])
    some = graph.math("MINIMUM", graph.math("MULTIPLY", straight, 50.0), 1.0)  # none: not at grazing angles, either
    return graph.math("MULTIPLY_ADD", straight, scale, graph.math("MULTIPLY", bias, some))


_KARIS_SLOPE, _KARIS_START = (-1.0, -0.0275, -0.572, 0.022), (1.0, 0.0425, 1.04, -0.04)


def split_sum(graph: Graph, roughness: bpy.types.NodeSocket) -> list[bpy.types.NodeSocket]:
    """What of the gloss that the camera sees goes with the colour seen straight on, and what is white.

    The fit of Karis 2014, "Physically Based Shading on Mobile", to the split sum of GGX.
    """
    geometry = graph.add("ShaderNodeNewGeometry").outputs
    cosine = graph.math("ABSOLUTE", graph.vector("DOT_PRODUCT", geometry["Normal"], geometry["Incoming"]))
    graph.column()
    x, y, z, w = (graph.math("MULTIPLY_ADD", roughness, *pair) for pair in zip(_KARIS_SLOPE, _KARIS_START, strict=True))
    falling = graph.math("POWER", 2.0, graph.math("MULTIPLY", cosine, -9.28))
    grazing = graph.math("MULTIPLY_ADD", graph.math("MINIMUM", graph.math("MULTIPLY", x, x), falling), x, y)
    return [graph.math("MULTIPLY_ADD", grazing, *pair) for pair in ((-1.04, z), (1.04, w))]
