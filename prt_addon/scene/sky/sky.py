# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads a world's node graph: what its sky is made of, which changes of it drivers can follow, and which they cannot."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np

from ...core.errors import LightError, PictureError
from ..blender.images import missing
from ..blender.nodes import PROCEDURAL_TEXTURES, Wiring, is_remapped, nodes_are_on

_LOOKS_ALONG = {"ShaderNodeTexEnvironment", "ShaderNodeTexSky", *PROCEDURAL_TEXTURES}
"""Textures that look along the view where their Vector is not linked."""

_GIVES_DIRECTION = {
    "ShaderNodeBevel",
    "ShaderNodeBump",
    "ShaderNodeCameraData",
    "ShaderNodeFresnel",
    "ShaderNodeLayerWeight",
    "ShaderNodeNewGeometry",
    "ShaderNodeNormalMap",
    "ShaderNodeScript",
    "ShaderNodeTexCoord",
    "ShaderNodeTexIES",
    "ShaderNodeVectorTransform",
}
"""Nodes whose value depends on the direction in a way of their own."""


_UNIFORM = "it looks the same in all directions"


@dataclass(frozen=True)
class Sky:
    """A world's sky, and what of it can be followed without looking at it again.

    world: whose nodes light the scene.
    holder: the scene's world, which carries the SH light, as shaders read it there. Since 5.2 a view layer may be lit by
        another world than the scene's.
    texture: the Environment Texture whose picture is all there is to see; None where Blender must evaluate the nodes.
    mapping: the Mapping node that turns everything; None if there is none.
    entry: where a Mapping node can be inserted: the one input that looks along the view; else None.
    sun: the Sky Texture whose Sun Rotation turns everything, as it takes no Vector with its Sun Disc; None if there is none.
    strength: the socket whose number scales everything; None if there is none.
    still: why a turn cannot be followed; empty if it can, or once a node is inserted at `entry`.
    """

    world: bpy.types.World
    holder: bpy.types.World
    texture: bpy.types.Node | None
    mapping: bpy.types.Node | None
    entry: bpy.types.NodeSocket | None
    sun: bpy.types.Node | None
    strength: bpy.types.NodeSocket | None
    still: str

    @property
    def is_uniform(self) -> bool:
        """Whether it looks the same in all directions, so that nothing of it can be seen to turn."""
        return self.still == _UNIFORM

    @property
    def nodes(self) -> list[bpy.types.Node]:
        """All nodes that can be seen, those in groups after the group."""
        output = output_of(self.world)
        return list(_all_nodes(output, Wiring())) if output else []

    @property
    def has_sun_disc(self) -> bool:
        """Whether a Sky Texture shows its Sun Disc, which Cycles lights with and EEVEE does not (4.5 to 5.2)."""
        return any(node.bl_idname == "ShaderNodeTexSky" and _shows_disc(node) for node in self.nodes)

    @property
    def images(self) -> list[bpy.types.Image]:
        """All pictures among them."""
        return list(dict.fromkeys(node.image for node in self.nodes if getattr(node, "image", None)))

    @property
    def following(self) -> str:
        """What is followed and what is not, for the user; part of a sentence."""
        node = self.mapping or self.sun
        through = f"'{node.name}'" if node else "the Mapping node that was inserted"
        turns = [f"its rotation is followed through {through}"] if node or self.entry else []
        return "; ".join(turns + self.not_followed)

    @property
    def not_followed(self) -> list[str]:
        """What cannot be followed and why, each a part of a sentence."""
        reasons = [self.still] if self.still else []
        if not self.strength:
            reasons.append(
                "its strength cannot be followed: that takes one Background node, with a number or a Value node"
            )
        return reasons


def read_sky(scene: bpy.types.Scene) -> Sky:
    """Read the sky of the scene's world.

    Raises:
        LightError: if the scene has no world, or one that cannot be written to or lacks a picture.
        PictureError: if the file of a picture is missing; the message names it.
    """
    if scene.world is None:
        raise LightError(f"Scene '{scene.name}' has no world: add one in World properties.")
    return read_world(lighting_world(scene) or scene.world, scene.world)


def lighting_world(scene: bpy.types.Scene) -> bpy.types.World | None:
    """The world that lights a scene: that of its view layer, if it has one of its own, before the scene's."""
    layer = bpy.context.view_layer if bpy.context.scene == scene else scene.view_layers[0]
    return getattr(layer, "world_override", None) or scene.world


def objects_seen(world: bpy.types.World) -> Iterator[bpy.types.Object]:
    """The objects by whose place nodes of a world look around, groups included."""
    trees = [world.node_tree] if world.node_tree else []
    for tree in trees:
        for node in tree.nodes:
            if seen := getattr(node, "object", None):
                yield seen
            inner = getattr(node, "node_tree", None)
            if inner and inner not in trees:
                trees.append(inner)


def read_world(world: bpy.types.World, holder: bpy.types.World | None = None) -> Sky:
    """As `read_sky`, of one world, which may be an evaluated one.

    Args:
        world: that lights the scene.
        holder: the world that carries the light, if that is another.
    """
    holder = holder or world
    output, wiring = output_of(world), Wiring()
    surface = wiring.source(output.inputs["Surface"]) if output else None
    if surface is None:
        return Sky(world, holder, None, None, None, None, None, _UNIFORM)
    _check_pictures(world, output, wiring)
    background = surface.node if surface.node.bl_idname == "ShaderNodeBackground" else None
    strength = _number(background.inputs["Strength"], wiring) if background else None
    turning = (node for node in wiring.upstream(output) if _turns(node, wiring))
    mapping = next((node for node in turning if not any(_lookups(output, wiring, node))), None)
    lookups = [] if mapping else list(_lookups(output, wiring))
    entry = lookups[0] if len(lookups) == 1 and lookups[0].node.id_data == world.node_tree else None
    entry = entry if entry and _takes_a_mapping(entry, wiring) else None
    sun = None if mapping else _lone_sun(lookups, world)
    still = "" if mapping or entry or sun else _why_still(lookups)
    texture = wiring.source(background.inputs["Color"]) if background and strength else None
    alone = texture is not None and _is_picture(texture.node, mapping, entry, wiring)
    return Sky(world, holder, texture.node if texture and alone else None, mapping, entry, sun, strength, still)


def output_of(world: bpy.types.World) -> bpy.types.Node | None:
    """The World Output that EEVEE shows; None for a world without nodes, as there are before 5.0."""
    return world.node_tree.get_output_node("EEVEE") if world.node_tree and nodes_are_on(world) else None


def _check_pictures(world: bpy.types.World, output: bpy.types.Node, wiring: Wiring) -> None:
    for node in _all_nodes(output, wiring):
        if node.bl_idname not in {"ShaderNodeTexEnvironment", "ShaderNodeTexImage"}:
            continue
        image = node.image
        if image is None:
            raise LightError(f"'{node.name}' of world '{world.name}' has no image: open an HDRI in it.")
        if image.source == "TILED":
            raise PictureError(f"Image '{image.name}' consists of UDIM tiles: use a single picture.")
        there = all(image.size)  # reading the size loads the file, and only then is its type known
        if image.source in {"MOVIE", "SEQUENCE"} or image.type == "MULTILAYER":  # no pixels before a frame or layer is
            there = bool(image.packed_file) or Path(bpy.path.abspath(image.filepath, library=image.library)).is_file()
        if not there:
            raise missing(image)


def _all_nodes(output: bpy.types.Node, wiring: Wiring, seen: set[int] | None = None) -> Iterator[bpy.types.Node]:
    """An output and all that feed it, each once, those of a group after the first that shows it."""
    seen = set() if seen is None else seen
    if output.as_pointer() in seen:
        return
    seen.add(output.as_pointer())
    for node in wiring.upstream(output):
        yield node
        group = getattr(node, "node_tree", None)
        inner = _group_output(group) if group else None
        if inner:
            yield from _all_nodes(inner, wiring, seen)


def _group_output(group: bpy.types.NodeTree) -> bpy.types.Node | None:
    return next((node for node in group.nodes if node.bl_idname == "NodeGroupOutput" and node.is_active_output), None)


def _number(socket: bpy.types.NodeSocket, wiring: Wiring) -> bpy.types.NodeSocket | None:
    """The socket that holds the number of an input: itself, or that of a Value node that feeds nothing else."""
    source = wiring.source(socket)
    if source is None:
        return socket
    only = source.node.bl_idname == "ShaderNodeValue" and len(wiring.fed_by(source)) == 1
    return source if only else None


def _turns(node: bpy.types.Node, wiring: Wiring) -> bool:
    """Whether a node is a Mapping that turns the view, by numbers, and does nothing else."""
    if node.bl_idname != "ShaderNodeMapping" or not is_view(wiring.source(node.inputs["Vector"])):
        return False
    inputs = {entry.name: entry for entry in node.inputs if entry.name != "Vector"}
    rests = {"Location": (0.0, 0.0, 0.0), "Scale": (1.0, 1.0, 1.0)}
    if node.vector_type in {"VECTOR", "NORMAL"}:
        del rests["Location"]  # without effect
    return not any(wiring.source(entry) for entry in inputs.values()) and all(
        np.allclose(inputs[name].default_value, rest, atol=1e-6) for name, rest in rests.items()
    )


def is_view(source: bpy.types.NodeSocket | None) -> bool:
    """Whether a socket gives the direction of view, unchanged."""
    return source is not None and (source.node.bl_idname, source.name) == ("ShaderNodeTexCoord", "Generated")


def looks_along(entry: bpy.types.NodeSocket) -> bool:
    """Whether an input that nothing feeds gets the direction of view."""
    return entry.node.bl_idname in _LOOKS_ALONG and entry.enabled and entry == entry.node.inputs[0]


def _lookups(
    output: bpy.types.Node, wiring: Wiring, through: bpy.types.Node | None = None
) -> Iterator[bpy.types.NodeSocket]:
    """The sockets by which a graph gets the direction: implicit inputs, and outputs or inputs fed by them.

    Args:
        output: where to begin.
        wiring: of its tree and the groups in it.
        through: a node beyond which not to look.
    """
    pending, seen = [output], set[int]()
    while pending:
        node = pending.pop()
        if node == through or node.as_pointer() in seen:
            continue
        seen.add(node.as_pointer())
        group = getattr(node, "node_tree", None)
        if group and (inner := _group_output(group)):
            pending.append(inner)
        vector = node.inputs[0] if node.bl_idname in _LOOKS_ALONG else None
        if vector and not vector.enabled:
            yield node.outputs[0]
        elif vector and not wiring.source(vector):
            yield vector
        for entry in node.inputs:
            if not entry.enabled:
                continue
            source = wiring.source(entry)
            if source and source.node.bl_idname in _GIVES_DIRECTION:
                yield entry if is_view(source) else source
            elif source:
                pending.append(source.node)


def _takes_a_mapping(socket: bpy.types.NodeSocket, wiring: Wiring) -> bool:
    """Whether a Mapping inserted before an input would turn it: all it lacks is the node."""
    if socket.is_output:
        return False
    source = wiring.source(socket)
    return source is None or is_view(source)


def _lone_sun(lookups: list[bpy.types.NodeSocket], world: bpy.types.World) -> bpy.types.Node | None:
    """The Sky Texture, if it alone depends on the direction, and lies where drivers reach it."""
    nodes = {socket.node for socket in lookups}
    node = nodes.pop() if len(nodes) == 1 else None
    if node is None or node.bl_idname != "ShaderNodeTexSky" or not lookups[0].is_output:
        return None
    return node if node.id_data == world.node_tree else None


def _shows_disc(node: bpy.types.Node) -> bool:
    """Whether a Sky Texture is of a type with a sun, and shows it: then it takes no Vector."""
    return bool(node.sun_disc) and not node.inputs[0].enabled


def _why_still(lookups: list[bpy.types.NodeSocket]) -> str:
    if not lookups:
        return _UNIFORM
    suns = [socket.node.name for socket in lookups if socket.is_output and socket.node.bl_idname == "ShaderNodeTexSky"]
    if suns:
        return (
            f"its rotation cannot be followed, as '{suns[0]}' takes no Vector with its Sun Disc and is not alone: switch that "
            "off, or keyframe the light"
        )
    names = ", ".join(f"'{name}'" for name in dict.fromkeys(socket.node.name for socket in lookups))
    return (
        "its rotation cannot be followed: insert Texture Coordinate > Generated and one Mapping node, which only "
        f"rotates, to feed all of {names}"
    )


def _is_picture(
    node: bpy.types.Node, mapping: bpy.types.Node | None, entry: bpy.types.NodeSocket | None, wiring: Wiring
) -> bool:
    """Whether a node is an Environment Texture looked up along the view, at most turned, whose texels we can read."""
    if node.bl_idname != "ShaderNodeTexEnvironment":
        return False
    source = wiring.source(node.inputs["Vector"])
    looked_up = entry == node.inputs["Vector"] or (source and mapping and source.node == mapping)
    single = node.image.source in {"FILE", "GENERATED"} and node.image.type != "MULTILAYER"
    return bool(looked_up) and single and not is_remapped(node) and not node.mute
