# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes and reads what the extras of a glTF scene hold of transport and light: the schema in docs/formats.md."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import Float64
from ..errors import PRTError, VersionError
from ..layout import BACKS, LAYERS
from ..sky.lamps import Lamp, Lamps
from ..sphere import sh

EXTRAS = "prt_relight"
"""Key in the extras of a scene, and of a primitive whose layers are rounded."""

VERSION = 2
"""Of the schema. The first knew neither scales nor suns.

Backs came without a new version: programs that do not know them show fronts.
"""

SCALES = {"scales": LAYERS, "backs": BACKS}
"""Keys in the extras of a primitive whose layers are rounded, and the layers whose scales each holds.

A primitive has each of these sets whole, or not at all.
"""

Y_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
"""Blender's X, Y and Z, a row each, in glTF's axes, which are Y up."""

_BASIS = "real, orthonormal, without the Condon-Shortley sign, i = l(l+1) + m, Z up"
_NEARLY = 1e-3


@dataclass(frozen=True)
class SceneLight:
    """The light of a scene's world.

    Attributes:
        light: (9, 3) L_i of the whole sky, unturned and at strength 1.
        lamps: (9, 3) the part of it that lamps show in Blender.
        suns: these lamps.
        turn: (3, 3) the rotation R: along w the sky shows what it holds along R w.
        strength: of the sky.
    """

    light: Float64
    lamps: Float64
    suns: Lamps
    turn: Float64
    strength: float


def to_extras(layout: int, axes: Float64, light: SceneLight | None) -> dict[str, Any]:
    """Extras as plain data.

    Args:
        layout: version of the layers.
        axes: (3, 3) rows, Blender's axes in those of the file.
        light: None where the world carries none.
    """
    found: dict[str, Any] = {
        "version": VERSION,
        "layout": layout,
        "order": sh.ORDER,
        "basis": _BASIS,
        "axes": axes.tolist(),
        "attributes": list(LAYERS),
        "backs": list(BACKS),
    }
    if light:
        found["light"] = light.light.tolist()
        found["lamps"] = light.lamps.tolist()
        found["suns"] = suns_as_extras(light.suns)
        found["turn"] = light.turn.T.tolist()  # its columns
        found["strength"] = light.strength
    return found


def from_extras(extras: Any, layout: int) -> SceneLight | None:
    """The light that extras hold, None if they hold none.

    Args:
        extras: what a file has under `EXTRAS`, whatever that is.
        layout: the latest version of the layers that is known.

    Raises:
        VersionError: if a newer version wrote them.
        PRTError: if they are not what is written here, or the file's axes are not glTF's.
    """
    if not isinstance(extras, dict):
        raise PRTError("its extras are no object")
    versions: list[Any] = [extras.get("version"), extras.get("layout")]
    if not all(isinstance(one, int) and one > 0 for one in versions):
        raise PRTError("its extras have no version")
    if any(one > latest for one, latest in zip(versions, (VERSION, layout), strict=True)):
        raise VersionError("a newer version of PRT Relight exported it: use that here, too")
    if extras.get("order") != sh.ORDER:
        raise PRTError(f"its order is {extras.get('order')!r}, and not {sh.ORDER}")
    if np.abs(_numbers(extras, "axes", (3, 3)) - Y_UP).max() > _NEARLY:
        raise PRTError("its axes are not those of glTF: export it with +Y Up")
    return _light(extras) if "light" in extras else None


def suns_as_extras(lamps: Lamps) -> list[dict[str, Any]]:
    """Lamps as plain data."""
    return [_sun(lamp, lamps.colour) for lamp in lamps.lamps]


def _light(extras: dict[str, Any]) -> SceneLight:
    light = _numbers(extras, "light", (9, 3))
    lamps = _numbers(extras, "lamps", (9, 3)) if "lamps" in extras else np.zeros((9, 3))
    turn = _numbers(extras, "turn", (3, 3)).T
    if np.abs(turn @ turn.T - np.eye(3)).max() > _NEARLY or np.linalg.det(turn) < 0.0:
        raise PRTError("its 'turn' is no rotation")
    return SceneLight(light, lamps, _suns(extras.get("suns", [])), turn, float(_numbers(extras, "strength", ())))


def _sun(lamp: Lamp, colour: tuple[float, float, float]) -> dict[str, Any]:
    irradiance = [lamp.irradiance * channel for channel in colour]
    return {"direction": lamp.direction.tolist(), "irradiance": irradiance, "radius": lamp.radius}


def _suns(rows: Any) -> Lamps:
    if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows):
        raise PRTError("its 'suns' are no list of objects")
    lamps, total = [], np.zeros(3)
    for row in rows:
        direction, irradiance = _numbers(row, "direction", (3,)), _numbers(row, "irradiance", (3,))
        radius, length = float(_numbers(row, "radius", ())), float(np.linalg.norm(direction))
        if abs(length - 1.0) > _NEARLY or not 0.0 <= radius < np.pi / 2 or irradiance.min() < 0.0:
            raise PRTError("one of its 'suns' has no unit vector as direction, or an impossible radius or irradiance")
        lamps.append(Lamp(direction / length, float(irradiance.mean()), radius))
        total += irradiance
    if not total.any():
        return Lamps()
    red, green, blue = (total / total.mean()).tolist()
    return Lamps(tuple(lamps), (red, green, blue))


def _numbers(holder: dict[str, Any], name: str, shape: tuple[int, ...]) -> Float64:
    """An entry as an array of finite numbers of a shape."""
    try:
        found = np.array(holder[name], dtype=np.float64)
    except (KeyError, TypeError, ValueError):
        found = np.array(np.nan)
    if found.shape != shape or not np.isfinite(found).all():
        size = " x ".join(map(str, shape)) + " numbers" if shape else "a number"
        raise PRTError(f"its '{name}' is missing, or not {size}")
    return found
