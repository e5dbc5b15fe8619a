# SPDX-License-Identifier: GPL-3.0-or-later
"""Lights a world by one of the HDRIs that Blender ships for its viewport: a sky in one click."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import bpy
import bpy.utils.previews

from ...core.errors import LightError
from ...session import session
from ..blender.nodes import Wiring, turn_nodes
from .sky import output_of


@cache
def studio_skies() -> dict[str, Path]:
    """The pictures by their names, in their order."""
    folder = Path(bpy.utils.system_resource("DATAFILES", path="studiolights/world"))
    return {path.stem: path for path in sorted(folder.glob("*.exr"))}


def load_icons() -> None:
    """Have Blender make small pictures of them, when they are first drawn; there are none in background."""
    if bpy.app.background or session.sky_icons is not None:
        return
    session.sky_icons = bpy.utils.previews.new()
    for name, path in studio_skies().items():
        session.sky_icons.load(name, str(path), "IMAGE")


def free_icons() -> None:
    """Give them back."""
    if session.sky_icons is not None:
        bpy.utils.previews.remove(session.sky_icons)
        session.sky_icons = None


def icon_of(name: str) -> int:
    """Identifier of the small picture of one of them; 0 if there is none."""
    return int(session.sky_icons[name].icon_id) if session.sky_icons else 0


def use_studio_sky(scene: bpy.types.Scene, name: str) -> bpy.types.World:
    """Light a scene's world with one of the pictures, turned by a Mapping node; its strength stays.

    The picture is packed: another machine has another Blender, or none.

    Raises:
        LightError: if Blender ships no such picture.
    """
    path = studio_skies().get(name)
    if path is None:
        raise LightError(f"Blender ships no HDRI '{name}': choose one of {', '.join(studio_skies())}.")
    world = scene.world or bpy.data.worlds.new("World")
    scene.world = world
    turn_nodes(world, True)
    tree = world.node_tree
    background = _background(world)
    texture, mapping, coordinate = (
        tree.nodes.new(f"ShaderNode{kind}") for kind in ("TexEnvironment", "Mapping", "TexCoord")
    )
    for column, node in enumerate((texture, mapping, coordinate), start=1):
        node.location = (background.location.x - 280.0 * column, background.location.y)
    texture.image = bpy.data.images.load(str(path), check_existing=True)
    if not texture.image.packed_file:
        texture.image.pack()
    tree.links.new(coordinate.outputs["Generated"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs["Vector"], texture.inputs["Vector"])
    tree.links.new(texture.outputs["Color"], background.inputs["Color"])
    return world


def _background(world: bpy.types.World) -> bpy.types.Node:
    """The Background that the world shows, made if there is none."""
    tree = world.node_tree
    output = output_of(world) or tree.nodes.new("ShaderNodeOutputWorld")
    source = Wiring().source(output.inputs["Surface"])
    if source and source.node.bl_idname == "ShaderNodeBackground" and source.node.id_data == tree:
        return source.node
    background = tree.nodes.new("ShaderNodeBackground")
    background.location = (output.location.x - 200.0, output.location.y)
    tree.links.new(background.outputs[0], output.inputs["Surface"])
    return background
