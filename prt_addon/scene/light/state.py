# SPDX-License-Identifier: GPL-3.0-or-later
"""Decides whether a world's SH light still is that of its nodes and pictures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import bpy

from ...core.errors import PRTError
from ..sky.identity import sky_identity
from ..sky.sky import Sky, read_world
from .drivers import drivers_work
from .light import (
    FRAMES,
    RECORD,
    REPAINTED,
    has_light,
    is_keyframed,
    is_projected,
    lamps_are_lost,
    light_record,
    source_of,
    stands_in,
)


@dataclass(frozen=True)
class LightState:
    """Whether a world's light still is its sky's: one phrase. Only what follows its nodes can be `stale`.

    not_followed: what needs another projection although the light follows nodes, each a part of a sentence.
    """

    stale: bool
    text: str
    not_followed: tuple[str, ...] = ()


def light_state(world: Any) -> LightState:
    """Decide whether the light is still that of the world's nodes and pictures; fast enough while they are edited.

    Args:
        world: a World or None; may be an evaluated one, where a depsgraph and not the file says what it is now.
    """
    if not has_light(world):
        return LightState(False, "No light yet: project the world")
    if stands_in(world.original):
        return LightState(True, f"A white sky stands in. {_why_not(world)}")
    if not is_projected(world.original):
        return LightState(False, "Light was imported: it follows no nodes")
    record = light_record(world.original)
    if is_keyframed(world.original):
        if not drivers_work(world.original):
            return LightState(True, "Light is keyframed, but the node that turned it is gone: keyframe it again")
        return LightState(False, "Light is keyframed, frames {} to {}".format(*record[FRAMES]))
    source = source_of(world.original)
    try:
        sky = read_world(world if source == world.original else source, world.original)
    except PRTError as error:
        return LightState(True, str(error))
    now = sky_identity(sky)
    changes = {
        "a picture is another, or its file has changed": now.pictures != record["pictures"],
        f"'{record.get(REPAINTED)}' was painted on or changed": REPAINTED in record,
        "the nodes have changed": now.graph != record["graph"],
        "another node turns it": (node.name if (node := sky.mapping or sky.sun) else "") != record["mapping"],
        "lamps of it are gone": lamps_are_lost(world.original),
        "another node sets its strength": (sky.strength.node.name if sky.strength else "") != record["strength"],
    }
    why = ", ".join(reason for reason, changed in changes.items() if changed)
    return LightState(bool(why), f"Light is stale: {why}" if why else "Light is fresh", tuple(_not_followed(sky)))


def _why_not(world: Any) -> str:
    """What keeps a world from being projected."""
    try:
        read_world(source_of(world.original))
    except PRTError as error:
        return str(error)
    return "Project the world"


def _not_followed(sky: Sky) -> list[str]:
    """What drivers do not reach, and what to do about it."""
    insertable = ["its rotation is followed once Project World has inserted a Mapping node"] if sky.entry else []
    return insertable + sky.not_followed


def note_repainted(world: bpy.types.World, image: bpy.types.Image) -> None:
    """Note that the texels of one of the world's pictures may have changed: nothing else shows it."""
    if not is_projected(world) or is_keyframed(world):
        return
    try:
        shown = image in read_world(source_of(world)).images
    except PRTError:
        return
    if shown:
        world[RECORD][REPAINTED] = image.name
