# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether a world's SH light still is that of its nodes and pictures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import bpy

from ..core.errors import PRTError
from .light import FRAMES, RECORD, REPAINTED, has_light, is_keyframed, is_projected
from .sky import read_world
from .sky_identity import identity


@dataclass(frozen=True)
class LightState:
    """Whether a world's light still is its sky's: one phrase. Only what follows its nodes can be `stale`."""

    stale: bool
    text: str


def light_state(world: Any) -> LightState:
    """Whether the light is still that of the world's nodes and pictures; fast enough to ask while they are edited.

    Args:
        world: a World or None; may be an evaluated one, where a depsgraph and not the file says what it is now.
    """
    if not has_light(world):
        return LightState(False, "No SH light on the world yet")
    if not is_projected(world.original):
        return LightState(False, "Imported: it follows no nodes")
    record = world.original[RECORD]
    if is_keyframed(world.original):
        return LightState(False, "Keyframed, frames {} to {}".format(*record[FRAMES]))
    try:
        sky = read_world(world)
    except PRTError as error:
        return LightState(True, str(error))
    now = identity(sky)
    changes = {
        "a picture is another, or its file has changed": now.pictures != record["pictures"],
        f"'{record.get(REPAINTED)}' was painted on or changed": REPAINTED in record,
        "the nodes have changed": now.graph != record["graph"],
        "another node turns it": (sky.mapping.name if sky.mapping else "") != record["mapping"],
        "its strength comes from elsewhere": (sky.strength.node.name if sky.strength else "") != record["strength"],
    }
    why = ", ".join(reason for reason, changed in changes.items() if changed)
    return LightState(bool(why), f"Stale: {why}" if why else "Fresh")


def note_repainted(world: bpy.types.World, image: bpy.types.Image) -> None:
    """Remember that the texels of one of the world's pictures may have changed: nothing else would tell."""
    if not is_projected(world) or is_keyframed(world):
        return
    try:
        shown = image in read_world(world).images
    except PRTError:
        return
    if shown:
        world[RECORD][REPAINTED] = image.name
