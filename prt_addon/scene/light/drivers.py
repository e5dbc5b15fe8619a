# SPDX-License-Identifier: GPL-3.0-or-later
"""Drivers by which a light follows its sky: simple expressions, which Blender evaluates without Python."""

from __future__ import annotations

import bpy
import numpy as np

from ..sky.sky import Sky

TURN = ("prt_turn_x", "prt_turn_y", "prt_turn_z")
"""Column k of the rotation R under which a direction w looks up the sky at R w."""
STRENGTH = "prt_strength"
"""Three times what scales the light, and whether lamps light relit surfaces, 0 or 1."""
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
    """Write turn and strength, and have them follow the sky's nodes.

    Args:
        mapping: the node that turns the sky; None if there is none.
    """
    world = sky.holder
    for name, axis in zip(TURN, np.eye(3), strict=True):
        world[name] = axis.tolist()
    write_strength(world, lamps=True)
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


def write_strength(world: bpy.types.World, lamps: bool) -> None:
    """Store strength 1.

    Args:
        lamps: whether lamps light relit surfaces: only if EEVEE's own light of the sky is the light that is stored.
    """
    world[STRENGTH] = [1.0, 1.0, 1.0, float(lamps)]


def _some_number(sun: bpy.types.Node) -> bpy.types.NodeSocket:
    """A socket of the same tree: a driver that reads one waits for the tree's keyframes, by a setting alone it does not."""
    return next(entry for node in sun.id_data.nodes for entry in node.inputs if entry.type == "VALUE" and entry.enabled)


def _drive(sky: Sky, name: str, index: int, expression: str, variables: dict[str, str]) -> None:
    driver = sky.holder.driver_add(f'["{name}"]', index).driver
    driver.type = "SCRIPTED"
    for variable_name, path in variables.items():
        if variable_name not in expression:
            continue
        variable = driver.variables.new()
        variable.name = variable_name
        target = variable.targets[0]
        target.id_type, target.id, target.data_path = "WORLD", sky.world, path
    driver.expression = expression


def remove_drivers(world: bpy.types.World) -> None:
    """Take all of them off; what they wrote stays."""
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
