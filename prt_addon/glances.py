# SPDX-License-Identifier: GPL-3.0-or-later
"""Caches what panels show of the light: it is computed when something has changed, and not at each redraw.

With a window it is looked up by a timer, between two redraws; without one, whenever it is drawn. `handlers` says when
it has to be looked up again.
"""

from __future__ import annotations

from dataclasses import dataclass

import bpy

from .core.errors import PRTError
from .scene.blender.areas import redraw_panels
from .scene.light import picture as light_picture
from .scene.light.light import has_light
from .scene.light.state import LightState, light_state
from .session import session

_DAMAGED = (KeyError, TypeError, ValueError, AttributeError, IndexError)
"""What properties raise that another program, or a user, has written."""


@dataclass(frozen=True)
class LightGlance:
    """What there is to see of a world's light.

    icon: identifier of a small picture of it; 0 for none.
    energy: how it is spread; None if that is unknown.
    """

    state: LightState
    icon: int = 0
    energy: light_picture.BandEnergy | None = None


_NOT_YET = LightGlance(LightState(False, "Looking at the world"))


def light_glance(world: bpy.types.World | None) -> LightGlance:
    """What to draw of a world's light; never raises, whatever the world holds."""
    if world is None or bpy.app.background:
        return _look(world)
    uid = world.session_uid
    if (uid not in session.glances or uid in session.outdated) and not bpy.app.timers.is_registered(_look_again):
        session.outdated.add(uid)
        bpy.app.timers.register(_look_again, first_interval=0.0)
    return session.glances.get(uid, _NOT_YET)


def forget() -> None:
    """Worlds may have changed: look again before they are drawn."""
    session.outdated.update(session.glances)


def unregister() -> None:
    """Stop the timer."""
    if bpy.app.timers.is_registered(_look_again):
        bpy.app.timers.unregister(_look_again)


def _look_again() -> None:
    for world in bpy.data.worlds:
        if world.session_uid in session.outdated:
            session.glances[world.session_uid] = _look(world)
    session.outdated.clear()
    redraw_panels()


def _look(world: bpy.types.World | None) -> LightGlance:
    try:
        state = light_state(world)
        if not has_light(world):
            return LightGlance(state)
        return LightGlance(state, light_picture.icon(world), light_picture.band_energy(world))
    except PRTError as error:
        return LightGlance(LightState(True, str(error)))
    except _DAMAGED:
        return LightGlance(LightState(True, "The light of this world is damaged: project the world"))
