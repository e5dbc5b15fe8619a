# SPDX-License-Identifier: GPL-3.0-or-later
"""Drives a light by its sky's nodes: by simple expressions, which Blender evaluates without Python."""

from __future__ import annotations

import bpy
import numpy as np

from ..sky.sky import Sky

TURN = ("prt_turn_x", "prt_turn_y", "prt_turn_z")
"""Column k of the rotation R under which a direction w looks up the sky at R w; then 1 and one channel of the colour that all lamps of
the sky have: what shaders read of a light without lamps is 1."""
STRENGTH = "prt_strength"
"""Three times what scales the light; then 0 where no lamps light relit surfaces, else by what band 1 of the light is to be multiplied to
be that of EEVEE's own, which is not windowed; negative where EEVEE's own light of the sky lacks what lamps of the sky show."""
_ID_TYPES = {bpy.types.World: "WORLD", bpy.types.Light: "LIGHT", bpy.types.Scene: "SCENE"}
DRIVEN = (*TURN, STRENGTH)
"""Custom properties of the world that carries the light."""

# Entries of R = Rz Ry Rx for Euler angles x, y, z (Blender's XYZ order), as simple expressions.
_EULER_MATRIX = (
    ("cos(y)*cos(z)", "sin(x)*sin(y)*cos(z)-cos(x)*sin(z)", "cos(x)*sin(y)*cos(z)+sin(x)*sin(z)"),
    ("cos(y)*sin(z)", "sin(x)*sin(y)*sin(z)+cos(x)*cos(z)", "cos(x)*sin(y)*sin(z)-sin(x)*cos(z)"),
    ("-sin(y)", "sin(x)*cos(y)", "cos(x)*cos(y)"),
)


_SUN_TURN = (
    (TURN[0], 0, "cos(z)"),
    (TURN[0], 1, "sin(z)"),
    (TURN[1], 0, "-sin(z)"),
    (TURN[1], 1, "cos(z)"),
)
"""Columns and rows of R: a Sun Rotation of z takes the sun about the vertical, clockwise as seen from above."""


def follow(sky: Sky, mapping: bpy.types.Node | None) -> None:
    """Make turn and strength follow the sky's nodes.

    Args:
        sky: whose world carries the light.
        mapping: the node that turns the sky; None if there is none.
    """
    if mapping:
        rotation = _socket_path(mapping.inputs["Rotation"])
        angles = {axis: f"{rotation}[{i}]" for i, axis in enumerate("xyz")}
        inverse = mapping.vector_type == "TEXTURE"  # this type undoes the rotation: the transposed matrix
        for column, name in enumerate(TURN):
            for row in range(3):
                expression = _EULER_MATRIX[column][row] if inverse else _EULER_MATRIX[row][column]
                _drive(sky, name, row, expression, angles)
    elif sky.sun:
        angle = f"{_node_path(sky.sun)}.sun_rotation"
        for name, index, expression in _SUN_TURN:
            _drive(sky, name, index, f"{expression}+0*w", {"z": angle, "w": _socket_path(_some_number(sky.sun))})
    if sky.strength:
        for index in range(3):
            _drive(sky, STRENGTH, index, "s", {"s": _socket_path(sky.strength)})


def write_rest(world: bpy.types.World, lamps: float = 0.0) -> None:
    """Store no turn, no colour of lamps, and strength 1.

    Args:
        world: that carries the light.
        lamps: the last of the strength; 0 unless EEVEE's own light of the sky is the light that is stored.
    """
    for name, axis in zip(TURN, np.eye(3), strict=True):
        world[name] = [*axis.tolist(), 1.0]
    world[STRENGTH] = [1.0, 1.0, 1.0, lamps]


def drive_rotation(ob: bpy.types.Object, sky: Sky, mapping: bpy.types.Node | None) -> None:
    """Turn an object as a sky turns: by R^T, in Euler angles.

    Args:
        ob: the object that is turned.
        sky: that it turns with.
        mapping: the node that turns the sky; None if there is none.
    """
    ob.driver_remove("rotation_euler")
    inverse = mapping is not None and mapping.vector_type == "TEXTURE"
    ob.rotation_mode, ob.rotation_euler = "XYZ" if inverse else "ZYX", (0.0, 0.0, 0.0)
    if mapping:
        rotation = _socket_path(mapping.inputs["Rotation"])
        for index in range(3):
            driver = _scripted(ob, "rotation_euler", index)
            _read(driver, "a", sky.world, f"{rotation}[{index}]")
            driver.expression = "a" if inverse else "-a"
    elif sky.sun:  # a node's setting cannot be read from another data-block: the turn it drives can
        driver = _scripted(ob, "rotation_euler", 2)
        _read(driver, "c", sky.holder, f'["{TURN[0]}"][0]')
        _read(driver, "s", sky.holder, f'["{TURN[0]}"][1]')
        driver.expression = "-atan2(s,c)"


def drive_energy(lamp: bpy.types.Light, path: str, world: bpy.types.World) -> None:
    """Make a lamp's energy follow a property of its own, times the strength of a world's light."""
    driver = _scripted(lamp, "energy")
    _read(driver, "e", lamp, path)
    _read(driver, "s", world, f'["{STRENGTH}"][0]')
    driver.expression = "e*s"


def drive_gloss(lamp: bpy.types.Light, path: str, world: bpy.types.World, scene: bpy.types.Scene) -> None:
    """Make a lamp's share in gloss follow what a scene's clamp takes of it in the sky that EEVEE's gloss mirrors.

    Of a radiance L the clamp c leaves c: the lamp adds the rest. Where the clamp is off, the mirrored sky is whole.

    Args:
        lamp: whose share in gloss is driven.
        path: of the lamp's property that holds L at strength 1.
        world: that carries the light.
        scene: whose clamp counts.
    """
    driver = _scripted(lamp, "specular_factor")
    _read(driver, "l", lamp, path)
    _read(driver, "s", world, f'["{STRENGTH}"][0]')
    _read(driver, "c", scene, "eevee.clamp_surface_indirect")
    driver.expression = "max(0,1-c/max(l*s,1e-9)) if c>0 else 0"


def _scripted(block: bpy.types.ID, path: str, index: int = -1) -> bpy.types.Driver:
    """A new driver of a property, or of one of its numbers."""
    driver: bpy.types.Driver = block.driver_add(path, index).driver
    driver.type = "SCRIPTED"
    return driver


def _read(driver: bpy.types.Driver, name: str, block: bpy.types.ID, path: str) -> None:
    """Give a driver a variable that reads a property."""
    variable = driver.variables.new()
    variable.name = name
    target = variable.targets[0]
    target.id_type = next(name for kind, name in _ID_TYPES.items() if isinstance(block, kind))
    target.id, target.data_path = block, path


def _some_number(sun: bpy.types.Node) -> bpy.types.NodeSocket:
    """A socket of the same tree: a driver that reads one waits for the tree's keyframes, by a setting alone it does not."""
    return next(entry for node in sun.id_data.nodes for entry in node.inputs if entry.type == "VALUE" and entry.enabled)


def _drive(sky: Sky, name: str, index: int, expression: str, variables: dict[str, str]) -> None:
    driver = _scripted(sky.holder, f'["{name}"]', index)
    for variable_name, path in variables.items():
        if variable_name in expression:
            _read(driver, variable_name, sky.world, path)
    driver.expression = expression


def remove_drivers(world: bpy.types.World) -> None:
    """Remove all drivers of a light; what they wrote stays."""
    for name in DRIVEN:
        if name in world:
            world.driver_remove(f'["{name}"]')


def drivers_work(world: bpy.types.World) -> bool:
    """Whether all that the light follows is still there: drivers of removed nodes keep their last value."""
    data = world.animation_data
    ours = [curve for curve in data.drivers if curve.data_path in {f'["{name}"]' for name in DRIVEN}] if data else []
    return all(
        _leads_somewhere(target) for curve in ours for variable in curve.driver.variables for target in variable.targets
    )


def _leads_somewhere(target: bpy.types.DriverTarget) -> bool:
    try:
        return target.id is not None and target.id.path_resolve(target.data_path) is not None
    except ValueError:
        return False


def _socket_path(socket: bpy.types.NodeSocket) -> str:
    node = socket.node
    side = "outputs" if socket.is_output else "inputs"
    number = list(getattr(node, side)).index(socket)
    return f"{_node_path(node)}.{side}[{number}].default_value"


def _node_path(node: bpy.types.Node) -> str:
    return f'node_tree.nodes["{bpy.utils.escape_identifier(node.name)}"]'
