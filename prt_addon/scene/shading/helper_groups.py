# SPDX-License-Identifier: GPL-3.0-or-later
"""Node groups that relight single shaders, beside "PRT Relight": the light of lamps, and the diffuse part of each BSDF.

Their inputs are called as the BSDF calls its own, so that a group node is fed as the BSDF is.
"""

from __future__ import annotations

from collections.abc import Callable

import bpy

from ..blender.libraries import is_own
from ..blender.nodes import Graph
from ..material.reading import PART

_VERSION = "prt_helper_version"
_CURRENT = 1


_Sockets = dict[str, bpy.types.NodeSocket]
_Kinds = dict[str, str]
_LIGHT = {"Shading": "Color", "Lamps": "Color", "Sky Seen": "Float"}


def lamps_group() -> bpy.types.NodeTree:
    """The light of lamps on a white diffuse surface, with their shadows.

    EEVEE adds its own light of the sky to that of lamps, and a shader cannot have the one without the other. But the sky's is a
    constant and a part that is linear in the normal: what the two sides of a surface get of it adds up to a constant, Ambient,
    whatever the normal. What is left is what lamps send to both sides; those that shine on the back are shadowed by the
    object itself.
    """
    return _group("PRT Lamps", {"Normal": "Vector", "Ambient": "Color"}, {"Lamps": "Color"}, _lamps)


def diffuse_group() -> bpy.types.NodeTree:
    """What reflects all light alike in all directions."""
    return _group("PRT Diffuse", {"Color": "Color", **_LIGHT}, {"Diffuse": "Shader"}, _diffuse)


def glossy_group(colour: str = "Color") -> bpy.types.NodeTree:
    """What a glossy BSDF mirrors of the scene, and the colour it is left with for the sky.

    Args:
        colour: how the BSDF calls its own.
    """
    results = {"Diffuse": "Shader", colour: "Color"}
    return _group(f"PRT Glossy {colour}", {colour: "Color", **_LIGHT}, results, _glossy)


def principled_group() -> bpy.types.NodeTree:
    """The diffuse part of a Principled BSDF with what its gloss mirrors of the scene, and what the rest is fed with."""
    numbers = ("Metallic", "Roughness", "IOR", "Alpha", "Specular IOR Level", "Transmission Weight", "Coat Weight")
    inputs = {"Base Color": "Color", **dict.fromkeys(numbers, "Float"), **_LIGHT}
    results = {"Diffuse": "Shader", "Base Color": "Color", "Specular IOR Level": "Float", "Coat Weight": "Float"}
    return _group("PRT Principled", inputs, results, _principled)


def _group(
    name: str, inputs: _Kinds, outputs: _Kinds, build: Callable[[Graph, _Sockets], _Sockets]
) -> bpy.types.NodeTree:
    """The group of a name, built on first use and shared by all materials. Marked as a part, it goes with its last user.

    It takes the place of copies of itself, which appended materials bring along.
    """
    own = [tree for tree in bpy.data.node_groups if tree.get(PART) == name and _VERSION in tree and is_own(tree)]
    current = [tree for tree in own if tree[_VERSION] == _CURRENT]
    if current:
        for copy in current[1:]:
            copy.user_remap(current[0])
            bpy.data.node_groups.remove(copy)
        return current[0]
    tree = bpy.data.node_groups.new(name, "ShaderNodeTree")
    tree[PART], tree[_VERSION] = name, _CURRENT
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
    return tree


def _lamps(graph: Graph, given: _Sockets) -> _Sockets:
    fed = graph.vector("DOT_PRODUCT", given["Normal"], given["Normal"])  # 0 where nothing is linked to it
    own = graph.add("ShaderNodeNewGeometry").outputs["Normal"]
    normal = graph.mixed(graph.math("GREATER_THAN", fed, 0.0), own, given["Normal"])
    sides = []
    for sign in (1.0, -1.0):
        diffuse, light = graph.add("ShaderNodeBsdfDiffuse"), graph.add("ShaderNodeShaderToRGB")
        diffuse.inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
        graph.feed(diffuse.inputs["Normal"], graph.vector("MULTIPLY", normal, (sign,) * 3))
        graph.feed(light.inputs[0], diffuse.outputs[0])
        sides.append(light.outputs["Color"])
    graph.column()
    lamps = graph.vector("SUBTRACT", graph.vector("ADD", *sides), given["Ambient"])
    return {"Lamps": graph.vector("MAXIMUM", lamps, (0.0, 0.0, 0.0))}


def _diffuse(graph: Graph, given: _Sockets) -> _Sockets:
    light = graph.vector("ADD", given["Shading"], given["Lamps"])
    return {"Diffuse": _emission(graph, graph.vector("MULTIPLY", light, given["Color"]))}


def _glossy(graph: Graph, given: _Sockets) -> _Sockets:
    """EEVEE's gloss mirrors the sky as if nothing stood before it.

    So it is dimmed to the share of sky that is seen there. What stands in the sky's place is taken to send as much light as what
    arrives at the surface does on average.
    """
    name, colour = next(iter(given.items()))
    hidden = graph.math("SUBTRACT", 1.0, given["Sky Seen"])
    scene = graph.vector("MULTIPLY", graph.vector("MULTIPLY", given["Shading"], colour), hidden)
    return {"Diffuse": _emission(graph, scene), name: graph.vector("MULTIPLY", colour, given["Sky Seen"])}


def _principled(graph: Graph, given: _Sockets) -> _Sockets:
    """Diffuse: `base (1 - E)`, of what is neither metal nor transmits. Gloss as in `_glossy`."""
    base, metallic, seen = given["Base Color"], given["Metallic"], given["Sky Seen"]
    opaque = graph.math("SUBTRACT", 1.0, given["Transmission Weight"])
    diffuse = graph.math("MULTIPLY", graph.math("SUBTRACT", 1.0, metallic), opaque)
    gloss = _specular_albedo(graph, given)
    graph.column()
    matte = graph.vector("MULTIPLY", base, graph.math("MULTIPLY", diffuse, graph.math("SUBTRACT", 1.0, gloss)))
    hidden = graph.math("MULTIPLY", graph.math("SUBTRACT", 1.0, seen), opaque)
    both = graph.vector("MULTIPLY_ADD", graph.mixed(metallic, gloss, base), hidden, matte)
    lamps = graph.vector("MULTIPLY", matte, given["Lamps"])
    light = graph.vector("MULTIPLY_ADD", both, given["Shading"], lamps)
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


_KARIS_SLOPE, _KARIS_START = (-1.0, -0.0275, -0.572, 0.022), (1.0, 0.0425, 1.04, -0.04)


def _specular_albedo(graph: Graph, given: _Sockets) -> bpy.types.NodeSocket:
    """How much of the light a dielectric's gloss reflects in all, E, as seen from the camera.

    The fit of Karis 2014, "Physically Based Shading on Mobile", to the split sum of GGX.
    """
    ior = given["IOR"]
    ratio = graph.math("DIVIDE", graph.math("SUBTRACT", ior, 1.0), graph.math("ADD", ior, 1.0))
    level = graph.math("MULTIPLY", given["Specular IOR Level"], 2.0)
    straight = graph.math("MULTIPLY", graph.math("MULTIPLY", ratio, ratio), level)
    geometry = graph.add("ShaderNodeNewGeometry").outputs
    cosine = graph.math("ABSOLUTE", graph.vector("DOT_PRODUCT", geometry["Normal"], geometry["Incoming"]))
    graph.column()
    x, y, z, w = (
        graph.math("MULTIPLY_ADD", given["Roughness"], *pair) for pair in zip(_KARIS_SLOPE, _KARIS_START, strict=True)
    )
    falling = graph.math("POWER", 2.0, graph.math("MULTIPLY", cosine, -9.28))
    grazing = graph.math("MULTIPLY_ADD", graph.math("MINIMUM", graph.math("MULTIPLY", x, x), falling), x, y)
    scale, bias = graph.math("MULTIPLY_ADD", grazing, -1.04, z), graph.math("MULTIPLY_ADD", grazing, 1.04, w)
    some = graph.math("MINIMUM", graph.math("MULTIPLY", straight, 50.0), 1.0)  # none: not at grazing angles, either
    return graph.math("MULTIPLY_ADD", straight, scale, graph.math("MULTIPLY", bias, some))
