# SPDX-License-Identifier: GPL-3.0-or-later
"""Lends a light to a world that has none yet, to see previews by, and takes it back with the nodes that came with it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import bpy

from ...core.sky.lamps import Lamps
from ..blender.modes import by_uid
from ..blender.nodes import feeding_socket
from ..light import light
from ..sky.projection import Projection
from ..sky.sky import Sky

_Socket = tuple[str, str]
"""Names of a node, and of one of its sockets."""


@dataclass(frozen=True)
class LentLight:
    """A light that a world was lent, and how to take it back.

    world: that carries it, by its identifier in this session.
    animated: whether it had animation data before.
    tree: the world whose nodes it follows.
    nodes: names of those that came with it.
    entry: the input that they feed, and
    coordinate: the output that fed it before, if any did.
    """

    world: int
    animated: bool
    tree: int = 0
    nodes: tuple[str, ...] = ()
    entry: _Socket = ("", "")
    coordinate: _Socket | None = None

    def take_back(self) -> None:
        """Leave the world as it was."""
        if world := by_uid(bpy.data.worlds, self.world):
            light.remove_light(world)
            if world.animation_data and not self.animated:
                world.animation_data_clear()
            world.update_tag()
        source = by_uid(bpy.data.worlds, self.tree)
        if source and source.node_tree and self.nodes:
            self._take_nodes(source.node_tree)

    def _take_nodes(self, tree: bpy.types.NodeTree) -> None:
        ours = [node for name in self.nodes if (node := tree.nodes.get(name))]
        entry = _found(tree, self.entry, "inputs")
        feeds = entry and any(link.from_node in ours for link in entry.links)
        for node in ours:
            tree.nodes.remove(node)
        coordinate = _found(tree, self.coordinate, "outputs")
        if entry and coordinate and feeds:
            tree.links.new(coordinate, entry)


def lend(sky: Sky, projection: Projection) -> LentLight:
    """Light a world that has no light yet, without lamps: suns glow in previews. Errors as those of `write_light`."""
    world, tree = sky.holder, sky.world.node_tree
    animated, before = world.animation_data is not None, {node.name for node in tree.nodes}
    entry, coordinate = sky.entry, feeding_socket(sky.entry) if sky.entry else None
    names = (
        _named(entry) if entry else ("", ""),
        _named(coordinate) if coordinate else None,
    )
    light.write_light(sky, replace(projection, lamps=Lamps()))
    inserted = tuple(node.name for node in tree.nodes if node.name not in before)
    return LentLight(world.session_uid, animated, sky.world.session_uid, inserted, *names)


def lend_white(world: bpy.types.World) -> LentLight:
    """Light a world that has no light yet by a white sky."""
    animated = world.animation_data is not None
    light.write_stand_in(world)
    return LentLight(world.session_uid, animated)


def _named(socket: bpy.types.NodeSocket) -> _Socket:
    return socket.node.name, socket.identifier


def _found(tree: bpy.types.NodeTree, names: _Socket | None, side: str) -> bpy.types.NodeSocket | None:
    """A socket by its names, on a node's `inputs` or `outputs`."""
    node = tree.nodes.get(names[0]) if names else None
    sockets = getattr(node, side) if node else ()
    return next((socket for socket in sockets if names and socket.identifier == names[1]), None)
