# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds the node group "PRT Relight": transport from the mesh, light from the world, turned and multiplied in the shader.

The light is turned by the world's Mapping node, and, where the mesh says that its transport is in its object's own
axes, by the object itself. What lamps show of the sky leaves the direct light; what they send on by bounces stays.

Backs of faces have transport of their own where the mesh has the layers, and the material a group that reads these.

It hands out what the surfaces of a material are relit with: the light on a white one (Shading), whether there is transport
(Baked), how much of what a mirror would see there is sky (Sky Seen; all, while EEVEE traces reflections), and by how much more light
arrives where a normal is bent along an axis of the world (Detail). Base Color, Unbaked and Surface are a matte surface.
"""

from __future__ import annotations

from math import pi

import bpy

from ...core.layout import BACKS, BAKED_BELOW, LAYERS, OWN_AXES_BELOW
from ...core.sphere import sh
from ..blender.libraries import is_local
from ..blender.nodes import Graph
from ..blender.versions import refuse_newer, version_of
from ..light.drivers import STRENGTH, TURN
from ..light.light import LIGHT
from ..material.reading import PART
from .helper_groups import Sockets, part_group
from .light_nodes import DETAIL, Y_0, Y_1, less_colour, second_band, turned_form, turned_vector

GROUP = "PRT Relight"
GROUP_VERSION = 7
_VERSION, _BACKS = "prt_version", "prt_backs"


def relight_group(with_backs: bool = False) -> bpy.types.NodeTree:
    """The node group of this version, built on first use and shared by all materials.

    It takes the place of older ones, and of copies of itself, which appended materials bring along.

    Args:
        with_backs: whether it reads the layers of backs, which take three of the attributes that EEVEE has for a material.
    """
    local = [tree for tree in bpy.data.node_groups if is_relight_group(tree) and is_local(tree)]
    local = [tree for tree in local if bool(tree.get(_BACKS, False)) is with_backs]
    whole = (tree for tree in local if _version(tree) == GROUP_VERSION and _is_whole(tree))
    current = next(whole, None) or _built(with_backs)
    for tree in local:
        if tree != current and _version(tree) <= GROUP_VERSION:
            tree.user_remap(current)
            bpy.data.node_groups.remove(tree)
    _remove_unused_parts()
    return current


_INPUTS = (
    ("Base Color", "Color", "Albedo of a matte surface, multiplied with the light that reaches it"),
    ("Unbaked", "Shader", "What meshes without baked transport show"),
)
_OUTPUTS = (
    ("Surface", "Shader", "A relit matte surface"),
    ("Shading", "Color", "The light that a white surface would show"),
    ("Baked", "Float", "1 where the mesh has transport, 0 where it has not"),
    (
        "Sky Seen",
        "Float",
        "How much of what a mirror would see is sky, and not the scene: 0 to 1; 1 if EEVEE traces reflections",
    ),
    *((name, "Color", "How the light grows with that component of the normal") for name in DETAIL),
)
_SOCKETS = {(name, "INPUT") for name, _, _ in _INPUTS} | {(name, "OUTPUT") for name, _, _ in _OUTPUTS}

_PARTS = ("PRT Turned Light", "PRT Sky Seen", "PRT Detail of Light")
"""Groups inside: each node that is added to a tree, and each link, takes Blender time by the size of the tree."""

_COEFFICIENTS = tuple(f"Coefficient {i}" for i in range(len(LAYERS)))
_AXES = ("X Axis", "Y Axis", "Z Axis")

_BANDS_SEEN = (1.0, 1.0, 0.75)
"""Weights of the bands in what a mirror sees: order 2 rings less with the last one damped."""


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
    trees = [tree for tree in bpy.data.node_groups if is_relight_group(tree) and is_local(tree)]
    bpy.data.batch_remove([tree for tree in trees if not tree.users])
    _remove_unused_parts()


def _remove_unused_parts() -> None:
    parts = [tree for tree in bpy.data.node_groups if tree.get(PART) in _PARTS and is_local(tree)]
    bpy.data.batch_remove([tree for tree in parts if not tree.users])


def check_version(material: bpy.types.Material) -> None:
    """Raises VersionError if a newer version relights a material."""
    for node in material.node_tree.nodes if material.node_tree else ():
        if node.bl_idname == "ShaderNodeGroup" and is_relight_group(node.node_tree):
            refuse_newer(f"Material '{material.name}' is relit", _version(node.node_tree), GROUP_VERSION)


def _version(tree: bpy.types.NodeTree) -> int:
    return version_of(tree, _VERSION)


def _built(with_backs: bool) -> bpy.types.NodeTree:
    tree = bpy.data.node_groups.new(f"{GROUP} Both Sides" if with_backs else GROUP, "ShaderNodeTree")
    tree[_VERSION], tree[_BACKS] = GROUP_VERSION, with_backs
    _build(tree, with_backs)
    return tree


def _build(tree: bpy.types.NodeTree, with_backs: bool) -> None:
    for sockets, side in ((_INPUTS, "INPUT"), (_OUTPUTS, "OUTPUT")):
        for name, kind, description in sockets:
            socket = tree.interface.new_socket(name, in_out=side, socket_type=f"NodeSocket{kind}")
            socket.description = description
            if side == "INPUT" and kind == "Color":
                socket.default_value = (0.8, 0.8, 0.8, 1.0)

    graph = Graph(tree)
    group_input = graph.add("NodeGroupInput")
    layers = [graph.attribute(name, "GEOMETRY") for name in LAYERS]
    light_nodes, turn_nodes = ([graph.attribute(name, "VIEW_LAYER") for name in names] for names in (LIGHT, TURN))
    light, axes = ([node.outputs["Vector"] for node in nodes] for nodes in (light_nodes, turn_nodes))
    strength = graph.attribute(STRENGTH, "VIEW_LAYER")
    graph.column()
    baked, own_axes, older = _marks(graph, layers)
    graph.column()
    object_axes = _object_axes(graph)
    axes = [graph.mixed(own_axes, *pair) for pair in zip(axes, _turned_axes(graph, axes, object_axes), strict=True)]
    graph.column()
    transport, direct = [layer.outputs["Vector"] for layer in layers], _direct(graph, layers, own_axes)
    if with_backs:
        transport, direct = _of_this_side(graph, transport, direct)
    turned = _turned(graph, light, axes)
    radiance = _received(graph, transport, turned)
    lamps = _turned(graph, [node.outputs["Alpha"] for node in light_nodes], axes)
    of_lamps = graph.mixed(older, _received(graph, direct, lamps), _received(graph, transport, lamps))
    colour = less_colour(graph, turn_nodes)
    radiance = graph.vector("MULTIPLY_ADD", of_lamps, colour, radiance)
    shown = graph.vector("MULTIPLY", _without_negatives(graph, radiance), strength.outputs["Fac"])
    graph.column()
    sky_seen = _sky_seen(graph, direct, own_axes, object_axes)
    graph.column()
    share = graph.math("MAXIMUM", graph.math("MULTIPLY", direct[0], 1.0 / Y_0), older)
    share = graph.math("MULTIPLY", share, strength.outputs["Fac"])
    soft = [graph.vector("MULTIPLY_ADD", colour, *pair) for pair in zip(lamps[1:], turned[1:], strict=True)]
    detail = _detail(graph, soft, share, own_axes, object_axes)

    graph.column()
    results = {
        "Surface": _matte(graph, group_input, shown, baked),
        "Shading": shown,
        "Baked": baked,
        "Sky Seen": graph.math("MAXIMUM", graph.math("MAXIMUM", sky_seen, older), _traced(graph)),
        **dict(zip(DETAIL, detail, strict=True)),
    }
    graph.column()
    group_output = graph.add("NodeGroupOutput")
    for name, socket in results.items():
        graph.feed(group_output.inputs[name], socket)


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
    graph: Graph, group_input: bpy.types.Node, shown: bpy.types.NodeSocket, baked: bpy.types.NodeSocket
) -> bpy.types.NodeSocket:
    """A surface that reflects the light alike in all directions; where there is no transport, the user's own."""
    emission = graph.add("ShaderNodeEmission")
    graph.feed(emission.inputs["Color"], graph.vector("MULTIPLY", shown, group_input.outputs["Base Color"]))
    mix = graph.add("ShaderNodeMixShader")
    graph.feed(mix.inputs[0], baked)
    graph.feed(mix.inputs[1], group_input.outputs["Unbaked"])
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


def _of_this_side(
    graph: Graph, transport: list[bpy.types.NodeSocket], direct: list[bpy.types.NodeSocket]
) -> tuple[list[bpy.types.NodeSocket], list[bpy.types.NodeSocket]]:
    """Transport and its direct part, those of backs where one is seen and the mesh has them, as `core.layout` has it."""
    layers = [graph.attribute(name, "GEOMETRY") for name in BACKS]
    marked, *rest = (part for layer in layers for part in graph.components(layer.outputs["Vector"]))
    graph.column()
    share, red, green = (layer.outputs["Alpha"] for layer in layers)
    grey = [graph.math("ADD", marked, 1.0), *rest]
    seen = graph.add("ShaderNodeNewGeometry").outputs["Backfacing"]
    is_back = graph.math("MULTIPLY", seen, graph.math("LESS_THAN", marked, BAKED_BELOW))
    colour = graph.add("ShaderNodeCombineXYZ")
    for entry, channel in zip(
        colour.inputs, (red, green, graph.math("SUBTRACT", graph.math("SUBTRACT", 3.0, red), green)), strict=True
    ):
        graph.feed(entry, channel)
    graph.column()
    backs = [graph.vector("MULTIPLY", colour.outputs[0], one) for one in grey]
    direct_backs = [graph.math("MULTIPLY", share, one) for one in grey]
    graph.column()
    return (
        [graph.mixed(is_back, *pair) for pair in zip(transport, backs, strict=True)],
        [graph.mixed(is_back, *pair, kind="Float") for pair in zip(direct, direct_backs, strict=True)],
    )


def _turned(
    graph: Graph, light: list[bpy.types.NodeSocket], axes: list[bpy.types.NodeSocket]
) -> list[bpy.types.NodeSocket]:
    """The nine coefficients of a light, turned."""
    names = _COEFFICIENTS[1:]

    def build(inside: Graph, given: Sockets) -> Sockets:
        band_1, band_2 = ([given[name] for name in some] for some in (names[:3], names[3:]))
        turn = [given[name] for name in _AXES]
        return dict(zip(names, [*turned_vector(inside, band_1, turn), *turned_form(inside, band_2, turn)], strict=True))

    kinds = dict.fromkeys(names, "Vector")
    group = part_group(_PARTS[0], {**kinds, **dict.fromkeys(_AXES, "Vector")}, kinds, build)
    outputs = graph.group(group, dict(zip((*names, *_AXES), (*light[1:], *axes), strict=True)))
    return [light[0], *(outputs[name] for name in names)]


def _received(
    graph: Graph, transport: list[bpy.types.NodeSocket], light: list[bpy.types.NodeSocket]
) -> bpy.types.NodeSocket:
    """Transport times light, summed."""
    graph.column()
    return graph.weighted_sum(list(zip(transport, light, strict=True)))


def _sky_seen(
    graph: Graph,
    direct: list[bpy.types.NodeSocket],
    own_axes: bpy.types.NodeSocket,
    object_axes: list[bpy.types.NodeSocket],
) -> bpy.types.NodeSocket:
    """How much sky there is where a mirror looks: the direct transport along the mirrored view, by what it is in the open.

    The direct transport is visibility times the cosine lobe, in spherical harmonics. In the open its sum along a direction R is that
    of the lobe alone: band l gives `A_l / pi (2 l + 1) / (4 pi) P_l(N.R)` (Ramamoorthi & Hanrahan 2001). It is right for
    what is as rough as order 2 is coarse, and a guide for what is smoother.
    """

    def build(inside: Graph, given: Sockets) -> Sockets:
        coefficients, axes = ([given[name] for name in names] for names in (_COEFFICIENTS, _AXES))
        return {"Sky Seen": _mirrored_sky(inside, coefficients, given["Own Axes"], axes)}

    kinds = {**dict.fromkeys(_COEFFICIENTS, "Float"), "Own Axes": "Float", **dict.fromkeys(_AXES, "Vector")}
    group = part_group(_PARTS[1], kinds, {"Sky Seen": "Float"}, build)
    fed = (*direct, own_axes, *object_axes)
    return graph.group(group, dict(zip(kinds, fed, strict=True)))["Sky Seen"]


def _mirrored_sky(
    graph: Graph,
    direct: list[bpy.types.NodeSocket],
    own_axes: bpy.types.NodeSocket,
    object_axes: list[bpy.types.NodeSocket],
) -> bpy.types.NodeSocket:
    """The nodes of `_sky_seen`."""
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


def _detail(
    graph: Graph,
    soft: list[bpy.types.NodeSocket],
    share: bpy.types.NodeSocket,
    own_axes: bpy.types.NodeSocket,
    object_axes: list[bpy.types.NodeSocket],
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
    names = _COEFFICIENTS[1:]

    def build(inside: Graph, given: Sockets) -> Sockets:
        coefficients, axes = ([given[name] for name in some] for some in (names, _AXES))
        gradient = _gradient(inside, coefficients, given["Share"], given["Own Axes"], axes)
        return dict(zip(DETAIL, gradient, strict=True))

    kinds = {**dict.fromkeys(names, "Vector"), "Share": "Float", "Own Axes": "Float", **dict.fromkeys(_AXES, "Vector")}
    group = part_group(_PARTS[2], kinds, dict.fromkeys(DETAIL, "Color"), build)
    outputs = graph.group(group, dict(zip(kinds, (*soft, share, own_axes, *object_axes), strict=True)))
    return [outputs[name] for name in DETAIL]


def _gradient(
    graph: Graph,
    soft: list[bpy.types.NodeSocket],
    share: bpy.types.NodeSocket,
    own_axes: bpy.types.NodeSocket,
    object_axes: list[bpy.types.NodeSocket],
) -> list[bpy.types.NodeSocket]:
    """The nodes of `_detail`."""
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


def _object_axes(graph: Graph) -> list[bpy.types.NodeSocket]:
    """The object's three axes o_i, unit vectors in the world's."""
    return [graph.to_world(direction) for direction in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))]


def _turned_axes(
    graph: Graph, axes: list[bpy.types.NodeSocket], object_axes: list[bpy.types.NodeSocket]
) -> list[bpy.types.NodeSocket]:
    """The object's axes o_i instead of the world's e_i, as the world's Mapping turns them: `R o_i = sum_k (o_i)_k R e_k`.

    They need only be orthogonal, not right-handed: a mirrored object's light is mirrored.
    """
    components = [graph.components(axis) for axis in object_axes]
    graph.column()
    return [graph.weighted_sum(list(zip(axes, row, strict=True))) for row in components]
