# SPDX-License-Identifier: GPL-3.0-or-later
"""What the sky of a world is: its node graph, read and checked."""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np

from ..core.errors import LightError
from .nodes import feeding_socket


@dataclass(frozen=True)
class EnvironmentSky:
    """A world of Environment Texture -> Background: its nodes, and the Mapping node that turns it, if any."""

    world: bpy.types.World
    background: bpy.types.Node
    texture: bpy.types.Node
    mapping: bpy.types.Node | None

    @property
    def image(self) -> bpy.types.Image:
        """The picture; `read_sky` made sure that there is one."""
        return self.texture.image


def read_sky(scene: bpy.types.Scene) -> EnvironmentSky:
    """Read the graph of the scene's world.

    Raises:
        LightError: if it is not one that can be followed; the message says what to change.
    """
    world = scene.world
    if world is None:
        raise LightError(f"Scene '{scene.name}' has no world: add one with an Environment Texture in World properties.")
    background = _background(world)
    colour = feeding_socket(background.inputs["Color"])
    if colour is None or colour.node.bl_idname != "ShaderNodeTexEnvironment":
        raise _not_an_environment(world)
    texture = colour.node
    if texture.image is None:
        raise LightError(f"The Environment Texture of world '{world.name}' has no image: open an HDRI in it.")
    if texture.projection != "EQUIRECTANGULAR":
        raise LightError(
            f"The Environment Texture of world '{world.name}' is a mirror ball: use an equirectangular image."
        )
    if feeding_socket(background.inputs["Strength"]) is not None:
        raise LightError(
            f"The Background's Strength in world '{world.name}' is fed by a node: unlink it and set a number."
        )
    return EnvironmentSky(world, background, texture, _mapping(world, texture))


def _not_an_environment(world: bpy.types.World) -> LightError:
    return LightError(
        f"World '{world.name}' is not lit by an environment texture: connect an Environment Texture to the Color of "
        "its Background node."
    )


def _background(world: bpy.types.World) -> bpy.types.Node:
    tree = world.node_tree
    output = tree.get_output_node("EEVEE") if tree and world.use_nodes else None
    surface = feeding_socket(output.inputs["Surface"]) if output else None
    if surface is None or surface.node.bl_idname != "ShaderNodeBackground":
        raise _not_an_environment(world)
    return surface.node


def _mapping(world: bpy.types.World, texture: bpy.types.Node) -> bpy.types.Node | None:
    """The Mapping node that turns the texture; None where the texture is looked up along plain directions."""
    source = feeding_socket(texture.inputs["Vector"])
    mapping = source.node if source and source.node.bl_idname == "ShaderNodeMapping" else None
    if mapping:
        source = feeding_socket(mapping.inputs["Vector"])
        _check_only_turns(world, mapping)
        if source is None:
            raise LightError(
                f"The Mapping node of world '{world.name}' has nothing in its Vector: connect Texture Coordinate > Generated."
            )
    if source and (source.node.bl_idname, source.name) != ("ShaderNodeTexCoord", "Generated"):
        raise LightError(
            f"The Environment Texture of world '{world.name}' is looked up by '{source.node.name}', which cannot be "
            "followed: use Texture Coordinate > Generated, with one Mapping node to turn it."
        )
    return mapping


def _check_only_turns(world: bpy.types.World, mapping: bpy.types.Node) -> None:
    inputs = [mapping.inputs[name] for name in ("Location", "Rotation", "Scale") if name in mapping.inputs]
    if any(entry.is_linked for entry in inputs):
        raise LightError(
            f"The Mapping node of world '{world.name}' is fed by nodes: unlink it and set or keyframe numbers."
        )
    rests = {"Location": (0.0, 0.0, 0.0), "Scale": (1.0, 1.0, 1.0)}
    for name, rest in rests.items():
        unused = name == "Location" and mapping.vector_type in {"VECTOR", "NORMAL"}
        if not unused and not np.allclose(mapping.inputs[name].default_value, rest, atol=1e-6):
            raise LightError(
                f"The Mapping node of world '{world.name}' changes {name}: reset it, as an SH light can only turn."
            )
