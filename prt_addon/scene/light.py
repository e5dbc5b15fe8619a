# SPDX-License-Identifier: GPL-3.0-or-later
"""The SH light on the World: nine RGB custom properties, and drivers that carry its turn and strength.

The light is stored with the world's rotation at zero. Its turn is stored as the images of the three axes under
the world's Mapping node, by drivers that need no Python (simple expressions): a saved file turns and renders in a
Blender that has never heard of this extension. Shaders read all of it with Attribute nodes of type View Layer.
"""

from __future__ import annotations

import bpy
import numpy as np
import numpy.typing as npt

from ..core import sh
from ..core.envmap import project_equirect
from ..core.errors import LightError
from ..core.rotation import rotation_matrix
from .images import linear_pixels
from .libraries import check_own, is_own
from .sky import EnvironmentSky
from .versions import refuse_newer, version_of

LIGHT_VERSION = 1
LIGHT = tuple(f"prt_light_{i}" for i in range(sh.coefficient_count(sh.ORDER)))
TURN = ("prt_turn_x", "prt_turn_y", "prt_turn_z")
"""Column k of the rotation R under which a direction w looks up the sky at R w."""
STRENGTH = "prt_strength"
RECORD = "prt_light"

_DRIVEN = (*TURN, STRENGTH)

# Entries of R = Rz Ry Rx for Euler angles x, y, z (Blender's XYZ order), as simple expressions.
_EULER_MATRIX = (
    ("cos(y)*cos(z)", "sin(x)*sin(y)*cos(z)-cos(x)*sin(z)", "cos(x)*sin(y)*cos(z)+sin(x)*sin(z)"),
    ("cos(y)*sin(z)", "sin(x)*sin(y)*sin(z)+cos(x)*cos(z)", "cos(x)*sin(y)*sin(z)-sin(x)*cos(z)"),
    ("-sin(y)", "sin(x)*cos(y)", "cos(x)*cos(y)"),
)


def picture_light(sky: EnvironmentSky) -> npt.NDArray[np.float64]:
    """Project the sky's picture: (9, 3) float64, the light with the world unturned and at strength 1.

    Raises:
        PictureError: if the picture cannot be read.
        LightError, VersionError: if the world could not carry it; see `check_world`.
    """
    check_world(sky.world)
    return project_equirect(linear_pixels(sky.image))


def write_light(sky: EnvironmentSky, light: npt.NDArray[np.float64]) -> None:
    """Store a light (9, 3) on the sky's world and let it follow the world's nodes.

    Inserts a Mapping node before the texture if the world has none, so that there is something to turn.
    """
    store_light(sky.world, light)
    mapping = sky.mapping or insert_mapping(sky)
    sky.world[RECORD] = {
        "version": LIGHT_VERSION,
        "order": sh.ORDER,
        "image": sky.image.name,
        "mapping": mapping.name,
        "background": sky.background.name,
    }
    _follow(sky, mapping)
    sky.world.update_tag()


def check_world(world: bpy.types.World) -> None:
    """Raises LightError if a world cannot be changed, VersionError if it carries a light of a newer version."""
    check_own(world, f"World '{world.name}'", "project it", LightError)
    check_version(world)


def check_version(world: bpy.types.World) -> None:
    """Raises VersionError if a newer version projected a world."""
    refuse_newer(f"World '{world.name}' was projected", version_of(world.get(RECORD)), LIGHT_VERSION)


def store_light(world: bpy.types.World, light: npt.NDArray[np.float64]) -> None:
    """Write (9, 3) coefficients as the world's custom properties."""
    for name, rgb in zip(LIGHT, light, strict=True):
        world[name] = [float(channel) for channel in rgb]


def read_light(world: bpy.types.World) -> npt.NDArray[np.float64]:
    """The stored (9, 3) light of a world that `has_light`."""
    return np.array([list(world[name]) for name in LIGHT])


def read_turn(world: bpy.types.World) -> npt.NDArray[np.float64]:
    """The (3, 3) rotation R that the drivers hold: the sky seen along w is the picture's along R w."""
    return np.array([list(world[name]) for name in TURN]).T


def shown_light(world: bpy.types.World, update: bool = True) -> npt.NDArray[np.float64]:
    """(9, 3) the light as it is turned and scaled now; without an update, as Blender last evaluated it.

    Raises:
        LightError: if the world carries none.
        VersionError: if a newer version projected it.
    """
    check_version(world)
    if not has_light(world):
        raise LightError("The scene's world carries no SH light: project it first (prt.project_light).")
    if update:
        bpy.context.view_layer.update()  # the drivers' latest word
    return float(world[STRENGTH]) * (rotation_matrix(read_turn(world).T) @ read_light(world))


def write_still_light(world: bpy.types.World, light: npt.NDArray[np.float64]) -> None:
    """Store a light (9, 3) that follows no nodes: unturned, at strength 1."""
    check_world(world)
    remove_light(world)
    store_light(world, light)
    for name, axis in zip(TURN, np.eye(3), strict=True):
        world[name] = axis.tolist()
    world[STRENGTH] = 1.0
    world[RECORD] = {"version": LIGHT_VERSION, "order": sh.ORDER}
    world.update_tag()


def has_light(world: bpy.types.World | None) -> bool:
    """Whether a world carries an SH light."""
    return world is not None and all(name in world for name in LIGHT)


def followed_nodes(world: bpy.types.World) -> tuple[bpy.types.Node, bpy.types.Node] | None:
    """The Mapping and Background node whose values the light follows; None if they are gone."""
    record, tree = world.get(RECORD), world.node_tree
    if not record or not tree:
        return None
    mapping, background = (tree.nodes.get(record.get(key, "")) for key in ("mapping", "background"))
    return (mapping, background) if mapping and background else None


def remove_light(world: bpy.types.World) -> bool:
    """Remove light, record and drivers from a world; True if there was any. A Mapping node once added stays."""
    _remove_drivers(world)
    present = [name for name in (*LIGHT, *_DRIVEN, RECORD) if name in world]
    for name in present:
        del world[name]
    return bool(present)


def remove_lights() -> None:
    """Remove the light from all worlds, save those of libraries and of newer versions."""
    for world in bpy.data.worlds:
        if is_own(world) and version_of(world.get(RECORD)) <= LIGHT_VERSION:
            remove_light(world)


def insert_mapping(sky: EnvironmentSky) -> bpy.types.Node:
    """Add Texture Coordinate > Mapping before the texture; the picture stays where it was."""
    tree = sky.world.node_tree
    mapping = tree.nodes.new("ShaderNodeMapping")
    mapping.location = (sky.texture.location.x - 200.0, sky.texture.location.y)
    entry = sky.texture.inputs["Vector"]
    if entry.is_linked:
        coordinate = entry.links[0].from_socket
    else:
        node = tree.nodes.new("ShaderNodeTexCoord")
        node.location = (mapping.location.x - 200.0, mapping.location.y)
        coordinate = node.outputs["Generated"]
    tree.links.new(coordinate, mapping.inputs["Vector"])
    tree.links.new(mapping.outputs["Vector"], entry)
    return mapping


def _follow(sky: EnvironmentSky, mapping: bpy.types.Node) -> None:
    world = sky.world
    _remove_drivers(world)
    for name in TURN:
        world[name] = [0.0, 0.0, 0.0]
    world[STRENGTH] = 1.0
    rotation = f"{_node_path(mapping)}.inputs[{_input_index(mapping, 'Rotation')}].default_value"
    angles = {axis: f"{rotation}[{i}]" for i, axis in enumerate("xyz")}
    inverse = mapping.vector_type == "TEXTURE"  # this type undoes the rotation: the transposed matrix
    for column, name in enumerate(TURN):
        for row in range(3):
            expression = _EULER_MATRIX[column][row] if inverse else _EULER_MATRIX[row][column]
            _drive(world, name, row, expression, angles)
    strength = f"{_node_path(sky.background)}.inputs[{_input_index(sky.background, 'Strength')}].default_value"
    _drive(world, STRENGTH, -1, "s", {"s": strength})


def _drive(world: bpy.types.World, name: str, index: int, expression: str, variables: dict[str, str]) -> None:
    driver = world.driver_add(f'["{name}"]', index).driver
    driver.type = "SCRIPTED"
    for variable_name, path in variables.items():
        if f"{variable_name}" not in expression:
            continue
        variable = driver.variables.new()
        variable.name = variable_name
        target = variable.targets[0]
        target.id_type, target.id, target.data_path = "WORLD", world, path
    driver.expression = expression


def _remove_drivers(world: bpy.types.World) -> None:
    for name in _DRIVEN:
        if name in world:
            world.driver_remove(f'["{name}"]')


def _node_path(node: bpy.types.Node) -> str:
    return f'node_tree.nodes["{bpy.utils.escape_identifier(node.name)}"]'


def _input_index(node: bpy.types.Node, name: str) -> int:
    return [entry.name for entry in node.inputs].index(name)
