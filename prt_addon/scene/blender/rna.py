# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads settings of any of Blender's structures as plain values, so that two states of it can be compared."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from typing import Any

import bpy


def settings_of(struct: Any, but: Collection[str] = ()) -> Iterator[tuple[str, Any]]:
    """The settings of a structure and those of the structures within, by name.

    Of data-blocks that it points to, what `_reached` says.

    Args:
        struct: the structure.
        but: names to leave out.
    """
    for prop in struct.bl_rna.properties:
        name = prop.identifier
        if name in but or name == "rna_type":
            continue
        value = getattr(struct, name)
        if prop.type == "COLLECTION":
            yield name, [dict(settings_of(item)) for item in value]
        elif prop.type != "POINTER":
            yield name, plain(value)
        elif isinstance(value, bpy.types.ID):
            yield name, _reached(value)
        elif value is not None:
            yield name, dict(settings_of(value))


def _reached(block: bpy.types.ID) -> Any:
    """What one sees of a data-block from a setting: of a picture nothing, these are distinguished elsewhere; of an object,
    where it stands; of all else, which it is.
    """
    if isinstance(block, bpy.types.Image):
        return type(block).__name__
    if isinstance(block, bpy.types.Object):
        return [round(value, 5) + 0.0 for row in block.matrix_world for value in row]
    return block.name


def plain(value: Any) -> Any:
    """Convert a value to numbers, text, or tuples of them."""
    if isinstance(value, set):
        return sorted(value)
    return value if value is None or isinstance(value, (str, int, float)) else tuple(value)


def plain_properties(block: bpy.types.ID | bpy.types.bpy_struct) -> dict[str, bool | int | float | list[Any]]:
    """Copy the custom properties that an Attribute node can read: numbers and lists of them. The data-block may go."""
    found: dict[str, bool | int | float | list[Any]] = {}
    for name, value in block.items():
        if isinstance(value, (bool, int, float)):
            found[name] = value
        elif hasattr(value, "to_list"):
            found[name] = value.to_list()
    return found
