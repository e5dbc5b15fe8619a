# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds formulas of the SH light as shader nodes: its bands, turned, the functions of band 2 along a direction, the colour of its lamps."""

from __future__ import annotations

from math import pi, sqrt

import bpy

from ...core.sphere import sh
from ..blender.nodes import Graph

Y_0, Y_1 = sqrt(1.0 / (4.0 * pi)), sqrt(3.0 / (4.0 * pi))
"""Factors of bands 0 and 1."""

DETAIL = ("Detail X", "Detail Y", "Detail Z")
"""Sockets: how the light grows with each component of a normal, along the world's axes."""


def turned_vector(
    graph: Graph, band: list[bpy.types.NodeSocket], axes: list[bpy.types.NodeSocket]
) -> list[bpy.types.NodeSocket]:
    """Band 1, RGB vectors in the order y, z, x, turned: component i becomes `sum_k band_k (R e_i)_k`."""
    x, y, z = band[2], band[0], band[1]
    turned = []
    for axis in axes:
        weights = graph.components(axis)
        turned.append(graph.weighted_sum(list(zip((x, y, z), weights, strict=True))))
    return [turned[1], turned[2], turned[0]]


def turned_form(
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


def second_band(graph: Graph, *direction: bpy.types.NodeSocket) -> list[bpy.types.NodeSocket]:
    """The five functions of band 2 along a unit vector, in the order of `core.sphere.sh`."""
    x, y, z = direction
    products = [graph.math("MULTIPLY", *pair) for pair in ((x, y), (y, z), (z, x))]
    xy, yz, zx = (graph.math("MULTIPLY", product, sh.K_XY) for product in products)
    zz = graph.math("MULTIPLY_ADD", graph.math("MULTIPLY", z, z), 3.0 * sh.K_ZZ, -sh.K_ZZ)
    difference = graph.math("SUBTRACT", graph.math("MULTIPLY", x, x), graph.math("MULTIPLY", y, y))
    return [xy, yz, zz, zx, graph.math("MULTIPLY", difference, 0.5 * sh.K_XY)]


def less_colour(graph: Graph, turn: list[bpy.types.Node]) -> bpy.types.NodeSocket:
    """The colour of the sky's lamps, negative: it is what the last of the turn's floats exceed 1 by."""
    colour = graph.add("ShaderNodeCombineXYZ")
    for entry, node in zip(colour.inputs, turn, strict=True):
        graph.feed(entry, graph.math("SUBTRACT", 1.0, node.outputs["Alpha"]))
    return colour.outputs[0]
