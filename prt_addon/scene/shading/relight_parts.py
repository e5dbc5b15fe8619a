# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds the node groups inside of "PRT Relight", one for each step of what it reckons.

They are groups of their own because each node that is added to a tree, and each link, takes Blender time by the size of the tree.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import pi

import bpy

from ...core.layout import BACKS, BAKED_BELOW, LAYERS
from ...core.sphere import sh
from ..blender.libraries import is_local
from ..blender.nodes import Graph
from ..material.reading import PART
from .helper_groups import Kinds, Sockets, part_group
from .light_nodes import DETAIL, Y_0, Y_1, second_band, turned_form, turned_vector

_PREFIX = "PRT Relight: "

_TRANSPORT = tuple(f"Transport {i}" for i in range(len(LAYERS)))
_DIRECT = tuple(f"Direct {i}" for i in range(len(LAYERS)))
_LIGHT = tuple(f"Light {i}" for i in range(len(LAYERS)))
_AXES = ("X Axis", "Y Axis", "Z Axis")
_OBJECT_AXES = tuple(f"Object {name}" for name in _AXES)

_BANDS_SEEN = (1.0, 1.0, 0.75)
"""Weights of the bands in what a mirror sees: order 2 rings less with the last one damped."""


def remove_unused_parts() -> None:
    """Remove the groups that no "PRT Relight" holds any more."""
    parts = [tree for tree in bpy.data.node_groups if str(tree.get(PART, "")).startswith(_PREFIX) and is_local(tree)]
    bpy.data.batch_remove([tree for tree in parts if not tree.users])


def _made(
    graph: Graph,
    name: str,
    given: Kinds,
    fed: Sequence[bpy.types.NodeSocket],
    results: Kinds,
    build: Callable[[Graph, Sockets], Sockets],
) -> list[bpy.types.NodeSocket]:
    """What a group of a name makes of sockets: see `part_group`."""
    outputs = graph.group(part_group(_PREFIX + name, given, results, build), dict(zip(given, fed, strict=True)))
    return [outputs[label] for label in results]


def axes_of_transport(
    graph: Graph, axes: Sequence[bpy.types.NodeSocket], own_axes: bpy.types.NodeSocket
) -> tuple[list[bpy.types.NodeSocket], list[bpy.types.NodeSocket]]:
    """The axes of the transport as the world's Mapping turns them, `R e_i`, or `R o_i` where they are the object's own; and these, o_i.

    `R o_i = sum_k (o_i)_k R e_k`. They need only be orthogonal, not right-handed: a mirrored object's light is mirrored.

    Args:
        graph: of the group.
        axes: `R e_i`.
        own_axes: whether they are the object's own.
    """

    def build(inside: Graph, sockets: Sockets) -> Sockets:
        turned = [sockets[name] for name in _AXES]
        own = [inside.to_world(direction) for direction in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))]
        inside.column()
        components = [inside.components(axis) for axis in own]
        inside.column()
        own_turned = [inside.weighted_sum(list(zip(turned, row, strict=True))) for row in components]
        inside.column()
        mixed = [inside.mixed(sockets["Own Axes"], *pair) for pair in zip(turned, own_turned, strict=True)]
        return dict(zip((*_AXES, *_OBJECT_AXES), (*mixed, *own), strict=True))

    vectors = dict.fromkeys(_AXES, "Vector")
    given, results = {**vectors, "Own Axes": "Float"}, {**vectors, **dict.fromkeys(_OBJECT_AXES, "Vector")}
    found = _made(graph, "Axes", given, (*axes, own_axes), results, build)
    return found[:3], found[3:]


def of_this_side(
    graph: Graph, transport: Sequence[bpy.types.NodeSocket], direct: Sequence[bpy.types.NodeSocket]
) -> tuple[list[bpy.types.NodeSocket], list[bpy.types.NodeSocket]]:
    """Transport and its direct part, those of backs where one is seen and the mesh has them, as `core.layout` has it."""

    def build(inside: Graph, sockets: Sockets) -> Sockets:
        is_back, backs, direct_backs = _backs(inside)
        inside.column()
        fronts, direct_fronts = ([sockets[name] for name in names] for names in (_TRANSPORT, _DIRECT))
        mixed = [inside.mixed(is_back, *pair) for pair in zip(fronts, backs, strict=True)]
        direct_pairs = zip(direct_fronts, direct_backs, strict=True)
        mixed += [inside.mixed(is_back, *pair, kind="Float") for pair in direct_pairs]
        return dict(zip((*_TRANSPORT, *_DIRECT), mixed, strict=True))

    kinds = {**dict.fromkeys(_TRANSPORT, "Vector"), **dict.fromkeys(_DIRECT, "Float")}
    found = _made(graph, "This Side", kinds, (*transport, *direct), kinds, build)
    return found[: len(LAYERS)], found[len(LAYERS) :]


def _backs(graph: Graph) -> tuple[bpy.types.NodeSocket, list[bpy.types.NodeSocket], list[bpy.types.NodeSocket]]:
    """Whether a back with transport is seen; that transport, and its direct part."""
    layers = [graph.attribute(name, "GEOMETRY") for name in BACKS]
    graph.column()
    marked, *rest = (part for layer in layers for part in graph.components(layer.outputs["Vector"]))
    share, red, green = (layer.outputs["Alpha"] for layer in layers)
    grey = [graph.math("ADD", marked, 1.0), *rest]
    seen = graph.add("ShaderNodeNewGeometry").outputs["Backfacing"]
    is_back = graph.math("MULTIPLY", seen, graph.math("LESS_THAN", marked, BAKED_BELOW))
    colour = graph.add("ShaderNodeCombineXYZ")
    blue = graph.math("SUBTRACT", graph.math("SUBTRACT", 3.0, red), green)
    for entry, channel in zip(colour.inputs, (red, green, blue), strict=True):
        graph.feed(entry, channel)
    graph.column()
    backs = [graph.vector("MULTIPLY", colour.outputs[0], one) for one in grey]
    return is_back, backs, [graph.math("MULTIPLY", share, one) for one in grey]


def turned_light(
    graph: Graph, light: Sequence[bpy.types.NodeSocket], axes: Sequence[bpy.types.NodeSocket]
) -> list[bpy.types.NodeSocket]:
    """The nine coefficients of a light, turned."""
    names = _LIGHT[1:]

    def build(inside: Graph, sockets: Sockets) -> Sockets:
        band_1, band_2 = ([sockets[name] for name in some] for some in (names[:3], names[3:]))
        turn = [sockets[name] for name in _AXES]
        return dict(zip(names, [*turned_vector(inside, band_1, turn), *turned_form(inside, band_2, turn)], strict=True))

    kinds = dict.fromkeys(names, "Vector")
    given = {**kinds, **dict.fromkeys(_AXES, "Vector")}
    return [light[0], *_made(graph, "Turned Light", given, (*light[1:], *axes), kinds, build)]


def received(
    graph: Graph, transport: Sequence[bpy.types.NodeSocket], light: Sequence[bpy.types.NodeSocket]
) -> bpy.types.NodeSocket:
    """Transport times light, summed: radiance, which may be negative."""

    def build(inside: Graph, sockets: Sockets) -> Sockets:
        terms = [(sockets[one], sockets[other]) for one, other in zip(_TRANSPORT, _LIGHT, strict=True)]
        return {"Radiance": inside.weighted_sum(terms)}

    given = dict.fromkeys((*_TRANSPORT, *_LIGHT), "Vector")
    [radiance] = _made(graph, "Received Light", given, (*transport, *light), {"Radiance": "Vector"}, build)
    return radiance


def unshadowed(graph: Graph, light: Sequence[bpy.types.NodeSocket]) -> bpy.types.NodeSocket:
    """What the open sky lights a white surface with: `sum A_l / pi L_lm Y_lm(n)` (Ramamoorthi & Hanrahan 2001), which may be negative.

    Args:
        graph: of the group.
        light: nine coefficients, in the scene's axes.
    """

    def build(inside: Graph, sockets: Sockets) -> Sockets:
        x, y, z = inside.components(inside.add("ShaderNodeNewGeometry").outputs["Normal"])
        inside.column()
        first = [inside.math("MULTIPLY", value, 2.0 / 3.0 * Y_1) for value in (y, z, x)]
        second = [inside.math("MULTIPLY", value, 0.25) for value in second_band(inside, x, y, z)]
        mean, *rest = (sockets[name] for name in _LIGHT)
        inside.column()
        total = inside.vector("MULTIPLY", mean, (Y_0,) * 3)
        for coefficient, weight in zip(rest, (*first, *second), strict=True):
            total = inside.vector("MULTIPLY_ADD", coefficient, weight, total)
        return {"Radiance": total}

    kinds = dict.fromkeys(_LIGHT, "Vector")
    [radiance] = _made(graph, "Unshadowed", kinds, light, {"Radiance": "Vector"}, build)
    return radiance


def without_negatives(graph: Graph, radiance: bpy.types.NodeSocket) -> bpy.types.NodeSocket:
    """Clamp after the dot product: a band-limited light may be negative where the sum of all is not.

    A colour with a negative channel goes towards the grey of its mean until none is negative. Clamped one by one, the
    channels that are left would make saturated blotches. Where the mean itself is negative, black is left.
    """

    def build(inside: Graph, sockets: Sockets) -> Sockets:
        return {"Radiance": _greyed(inside, sockets["Radiance"])}

    kinds = {"Radiance": "Vector"}
    [positive] = _made(graph, "Without Negatives", kinds, (radiance,), kinds, build)
    return positive


def _greyed(graph: Graph, radiance: bpy.types.NodeSocket) -> bpy.types.NodeSocket:
    least = graph.math("MINIMUM", graph.math("MINIMUM", *(parts := graph.components(radiance))[:2]), parts[2])
    mean = graph.math("MULTIPLY", graph.math("ADD", graph.math("ADD", *parts[:2]), parts[2]), 1.0 / 3.0)
    lacking = graph.math("MAXIMUM", graph.math("MULTIPLY", least, -1.0), 0.0)
    room = graph.math("MAXIMUM", graph.math("SUBTRACT", mean, least), 1e-9)
    share = graph.math("MINIMUM", graph.math("DIVIDE", lacking, room), 1.0)
    greyer = graph.vector("MULTIPLY_ADD", graph.vector("SUBTRACT", mean, radiance), share, radiance)
    return graph.vector("MAXIMUM", greyer, (0.0, 0.0, 0.0))


def sky_seen(
    graph: Graph,
    direct: Sequence[bpy.types.NodeSocket],
    own_axes: bpy.types.NodeSocket,
    object_axes: Sequence[bpy.types.NodeSocket],
) -> bpy.types.NodeSocket:
    """How much sky there is where a mirror looks: the direct transport along the mirrored view, by what it is in the open.

    The direct transport is visibility times the cosine lobe, in spherical harmonics. In the open its sum along a direction R is that
    of the lobe alone: band l gives `A_l / pi (2 l + 1) / (4 pi) P_l(N.R)` (Ramamoorthi & Hanrahan 2001). It is right for
    what is as rough as order 2 is coarse, and a guide for what is smoother.
    """

    def build(inside: Graph, sockets: Sockets) -> Sockets:
        coefficients, axes = ([sockets[name] for name in names] for names in (_DIRECT, _OBJECT_AXES))
        return {"Sky Seen": _mirrored_sky(inside, coefficients, sockets["Own Axes"], axes)}

    given = {**dict.fromkeys(_DIRECT, "Float"), "Own Axes": "Float", **dict.fromkeys(_OBJECT_AXES, "Vector")}
    [seen] = _made(graph, "Sky Seen", given, (*direct, own_axes, *object_axes), {"Sky Seen": "Float"}, build)
    return seen


def _mirrored_sky(
    graph: Graph,
    direct: list[bpy.types.NodeSocket],
    own_axes: bpy.types.NodeSocket,
    object_axes: list[bpy.types.NodeSocket],
) -> bpy.types.NodeSocket:
    """The nodes of `sky_seen`."""
    geometry = graph.add("ShaderNodeNewGeometry")
    normal, view = geometry.outputs["Normal"], geometry.outputs["Incoming"]
    mirrored = graph.vector("MULTIPLY", graph.vector("REFLECT", view, normal), (-1.0, -1.0, -1.0))
    x, y, z = _along_axes(graph, mirrored, own_axes, object_axes)
    cosine = graph.math("ABSOLUTE", graph.vector("DOT_PRODUCT", normal, view))

    seen = graph.math("MULTIPLY", direct[0], Y_0 * _BANDS_SEEN[0])
    for coefficient, value in zip(direct[1:4], (y, z, x), strict=True):
        weighted = graph.math("MULTIPLY", value, Y_1 * _BANDS_SEEN[1])
        seen = graph.math("MULTIPLY_ADD", coefficient, weighted, seen)
    for coefficient, value in zip(direct[4:], second_band(graph, x, y, z), strict=True):
        weighted = graph.math("MULTIPLY", value, _BANDS_SEEN[2])
        seen = graph.math("MULTIPLY_ADD", coefficient, weighted, seen)

    constant = (_BANDS_SEEN[0] - _BANDS_SEEN[2] * 5.0 / 8.0) / (4.0 * pi)
    linear, square = _BANDS_SEEN[1] * 2.0 / (4.0 * pi), _BANDS_SEEN[2] * 15.0 / 8.0 / (4.0 * pi)
    slope = graph.math("MULTIPLY_ADD", cosine, square, linear)
    share = graph.math("DIVIDE", seen, graph.math("MULTIPLY_ADD", cosine, slope, constant))
    return graph.math("MINIMUM", graph.math("MAXIMUM", share, 0.0), 1.0)


def detail(
    graph: Graph,
    soft: Sequence[bpy.types.NodeSocket],
    share: bpy.types.NodeSocket,
    own_axes: bpy.types.NodeSocket,
    object_axes: Sequence[bpy.types.NodeSocket],
) -> list[bpy.types.NodeSocket]:
    """What a normal map or a bump adds to the light, per component by which it bends the normal, along the world's axes.

    It is the gradient of what the open sky lights a white surface with, `sum A_l / pi L_lm Y_lm(n)` (Ramamoorthi & Hanrahan 2001), by the
    share of sky that is seen. (A factor, what the sky gives the bent normal over what it gives the surface's own, grows without bounds
    where the sky gives little and much has bounced.)

    Args:
        graph: of the group.
        soft: bands 1 and 2 of the light without lamps, in the axes of the transport.
        share: of the sky, times the strength of the world.
        own_axes: whether these axes are the object's own.
        object_axes: the object's axes in the world.
    """
    names = _LIGHT[1:]

    def build(inside: Graph, sockets: Sockets) -> Sockets:
        coefficients, axes = ([sockets[name] for name in some] for some in (names, _OBJECT_AXES))
        gradient = _gradient(inside, coefficients, sockets["Share"], sockets["Own Axes"], axes)
        return dict(zip(DETAIL, gradient, strict=True))

    numbers = dict.fromkeys(("Share", "Own Axes"), "Float")
    given = {**dict.fromkeys(names, "Vector"), **numbers, **dict.fromkeys(_OBJECT_AXES, "Vector")}
    fed = (*soft, share, own_axes, *object_axes)
    return _made(graph, "Detail of Light", given, fed, dict.fromkeys(DETAIL, "Color"), build)


def _gradient(
    graph: Graph,
    soft: list[bpy.types.NodeSocket],
    share: bpy.types.NodeSocket,
    own_axes: bpy.types.NodeSocket,
    object_axes: list[bpy.types.NodeSocket],
) -> list[bpy.types.NodeSocket]:
    """The nodes of `detail`."""
    y1, z1, x1, xy, yz, zz, zx, xx = soft
    x, y, z = _along_axes(graph, graph.add("ShaderNodeNewGeometry").outputs["Normal"], own_axes, object_axes)
    graph.column()
    less_y, height = graph.math("MULTIPLY", y, -1.0), graph.math("MULTIPLY", z, 6.0 * sh.K_ZZ / sh.K_XY)
    second = (
        graph.weighted_sum([(xy, y), (zx, z), (xx, x)]),
        graph.weighted_sum([(xy, x), (yz, z), (xx, less_y)]),
        graph.weighted_sum([(yz, y), (zx, x), (zz, height)]),
    )
    graph.column()
    gradient = []
    for first, bent in zip((x1, y1, z1), second, strict=True):
        straight = graph.vector("MULTIPLY", first, (2.0 / 3.0 * Y_1,) * 3)
        both = graph.vector("MULTIPLY_ADD", bent, (sh.K_XY / 4.0,) * 3, straight)
        gradient.append(graph.vector("MULTIPLY", both, share))
    parts = [graph.components(axis) for axis in object_axes]
    turned = [graph.weighted_sum(list(zip(gradient, entries, strict=True))) for entries in zip(*parts, strict=True)]
    return [graph.mixed(own_axes, *pair) for pair in zip(gradient, turned, strict=True)]


def _along_axes(
    graph: Graph,
    direction: bpy.types.NodeSocket,
    own_axes: bpy.types.NodeSocket,
    object_axes: list[bpy.types.NodeSocket],
) -> list[bpy.types.NodeSocket]:
    """The components of a direction along the axes of the transport: the world's, or the object's own."""
    along = graph.add("ShaderNodeCombineXYZ")
    for entry, axis in zip(along.inputs, object_axes, strict=True):
        graph.feed(entry, graph.vector("DOT_PRODUCT", direction, axis))
    return graph.components(graph.mixed(own_axes, direction, along.outputs[0]))
