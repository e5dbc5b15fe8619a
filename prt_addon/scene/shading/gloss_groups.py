# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds the node groups that relight shaders whose gloss no one input dims: beside each a copy of the shader is mixed with black.

These are the *Specular BSDF*, EEVEE's own, and a *Metallic BSDF* whose colour follows from physical indices.
"""

from __future__ import annotations

import bpy

from ..blender.nodes import Graph
from .helper_groups import Sockets, part_group

_LIGHT = {"Shading": "Color", "Lamps": "Color", "Sky Seen": "Float"}
_SLOPE, _START = (-1.0, -0.0275, -0.572, 0.022), (1.0, 0.0425, 1.04, -0.04)


def specular_group() -> bpy.types.NodeTree:
    """The diffuse part, what the gloss mirrors of the scene, the glow, and the transparency that a dimmed copy of the BSDF lacks.

    EEVEE adds the two colours up: the diffuse one is not weakened by the specular one.
    """
    colours = ("Base Color", "Specular", "Emissive Color")
    inputs = {**dict.fromkeys(colours, "Color"), "Roughness": "Float", "Transparency": "Float", **_LIGHT}
    left = {"Base Color": "Color", "Emissive Color": "Color"}
    return part_group("PRT Specular", inputs, {"Diffuse": "Shader", **left}, _specular)


def conductor_group() -> bpy.types.NodeTree:
    """What a metal of some index of refraction mirrors of the scene."""
    inputs = {"IOR": "Vector", "Extinction": "Vector", **_LIGHT}
    return part_group("PRT Conductor", inputs, {"Diffuse": "Shader"}, _conductor)


def _conductor(graph: Graph, given: Sockets) -> Sockets:
    """Its colour is Fresnel's, seen straight on: `((n - 1)^2 + k^2) / ((n + 1)^2 + k^2)`."""
    one, squares = (1.0, 1.0, 1.0), graph.vector("MULTIPLY", given["Extinction"], given["Extinction"])
    less, more = (graph.vector(operation, given["IOR"], one) for operation in ("SUBTRACT", "ADD"))
    low, high = (graph.vector("MULTIPLY_ADD", index, index, squares) for index in (less, more))
    graph.column()
    hidden = graph.math("SUBTRACT", 1.0, given["Sky Seen"])
    arriving = graph.vector("ADD", given["Shading"], given["Lamps"])
    mirrored = graph.vector("MULTIPLY", graph.vector("DIVIDE", low, high), arriving)
    emission = graph.add("ShaderNodeEmission")
    graph.feed(emission.inputs["Color"], graph.vector("MULTIPLY", mirrored, hidden))
    return {"Diffuse": emission.outputs[0]}


def _specular(graph: Graph, given: Sockets) -> Sockets:
    """Gloss as in `helper_groups`: what is not sky sends as much light as arrives at the surface on average."""
    hidden = graph.math("SUBTRACT", 1.0, given["Sky Seen"])
    opaque = graph.math("SUBTRACT", 1.0, given["Transparency"])
    scale, bias = _split_sum(graph, given["Roughness"])
    graph.column()
    gloss = graph.vector("MULTIPLY_ADD", given["Specular"], scale, bias)
    both = graph.vector("MULTIPLY_ADD", gloss, hidden, given["Base Color"])
    light = graph.vector("MULTIPLY", both, graph.vector("ADD", given["Shading"], given["Lamps"]))
    glow = graph.vector("MULTIPLY_ADD", light, opaque, given["Emissive Color"])
    graph.column()
    emission, clear, sum_ = (graph.add(f"ShaderNode{kind}") for kind in ("Emission", "BsdfTransparent", "AddShader"))
    graph.feed(emission.inputs["Color"], glow)
    graph.feed(clear.inputs["Color"], graph.math("MULTIPLY", given["Transparency"], hidden))
    for entry, shader in zip(sum_.inputs, (emission, clear), strict=True):
        graph.feed(entry, shader.outputs[0])
    black = graph.vector("MULTIPLY", given["Base Color"], (0.0, 0.0, 0.0))
    return {"Diffuse": sum_.outputs[0], "Base Color": black, "Emissive Color": black}


def _split_sum(graph: Graph, roughness: bpy.types.NodeSocket) -> list[bpy.types.NodeSocket]:
    """What of the gloss goes with the colour seen straight on, and what is white: the fit of Karis 2014 to the split sum of GGX."""
    geometry = graph.add("ShaderNodeNewGeometry").outputs
    cosine = graph.math("ABSOLUTE", graph.vector("DOT_PRODUCT", geometry["Normal"], geometry["Incoming"]))
    x, y, z, w = (graph.math("MULTIPLY_ADD", roughness, *pair) for pair in zip(_SLOPE, _START, strict=True))
    falling = graph.math("POWER", 2.0, graph.math("MULTIPLY", cosine, -9.28))
    grazing = graph.math("MULTIPLY_ADD", graph.math("MINIMUM", graph.math("MULTIPLY", x, x), falling), x, y)
    return [graph.math("MULTIPLY_ADD", grazing, *pair) for pair in ((-1.04, z), (1.04, w))]
