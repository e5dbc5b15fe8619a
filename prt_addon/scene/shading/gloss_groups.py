# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds the node groups that relight shaders whose gloss no one input dims: beside each a copy of the shader is mixed with black.

These are the *Specular BSDF*, EEVEE's own, and a *Metallic BSDF* whose colour follows from physical indices.
"""

from __future__ import annotations

import bpy

from ..blender.nodes import Graph
from .helper_groups import LIGHT_GIVEN, Sockets, part_group, split_sum


def specular_group() -> bpy.types.NodeTree:
    """The diffuse part, what the gloss mirrors of the scene, the glow, and the transparency that a dimmed copy of the BSDF lacks.

    EEVEE adds the two colours up: the diffuse one is not weakened by the specular one.
    """
    colours = ("Base Color", "Specular", "Emissive Color")
    inputs = {**dict.fromkeys(colours, "Color"), "Roughness": "Float", "Transparency": "Float", **LIGHT_GIVEN}
    left = {"Base Color": "Color", "Emissive Color": "Color"}
    return part_group("PRT Specular", inputs, {"Diffuse": "Shader", **left}, _specular)


def conductor_group() -> bpy.types.NodeTree:
    """What a metal of some index of refraction mirrors of the scene."""
    inputs = {"IOR": "Vector", "Extinction": "Vector", **LIGHT_GIVEN}
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
    scale, bias = split_sum(graph, given["Roughness"])
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
