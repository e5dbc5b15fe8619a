# SPDX-License-Identifier: GPL-3.0-or-later
"""Recognises cube maps in files: six pictures by many names, or one picture with all faces as a cross or a strip."""

from __future__ import annotations

import re

import numpy as np

from ..errors import PictureError
from .cube_map import FACES, Picture

_ALIASES: dict[str, tuple[str, ...]] = {
    "posx": ("posx", "xpos", "positivex", "px", "xp", "x+", "+x", "right", "rt", "r"),
    "negx": ("negx", "xneg", "negativex", "nx", "xn", "x-", "-x", "left", "lf", "lt", "l"),
    "posy": ("posy", "ypos", "positivey", "py", "yp", "y+", "+y", "top", "up", "u", "t"),
    "negy": ("negy", "yneg", "negativey", "ny", "yn", "y-", "-y", "bottom", "down", "dn", "bt", "d", "b"),
    "posz": ("posz", "zpos", "positivez", "pz", "zp", "z+", "+z", "front", "ft", "f"),
    "negz": ("negz", "zneg", "negativez", "nz", "zn", "z-", "-z", "back", "bk", "bc", "k"),
}
"""What the graphics interfaces, their tutorials and games call the faces; right is +x, up +y, front +z, as in OpenGL."""

_BY_ALIAS = {alias: face for face, aliases in _ALIASES.items() for alias in aliases}
_LONGEST_FIRST = sorted(_BY_ALIAS, key=len, reverse=True)
_SHORTEST = 3  # letters of a name that may stand without a separator, as in "skyright"

_LAYOUTS: dict[tuple[int, int], dict[str, tuple[int, int]]] = {
    (3, 4): {"posy": (0, 1), "negx": (1, 0), "posz": (1, 1), "posx": (1, 2), "negz": (1, 3), "negy": (2, 1)},
    (4, 3): {"posy": (0, 1), "negx": (1, 0), "posz": (1, 1), "posx": (1, 2), "negy": (2, 1), "negz": (3, 1)},
    (1, 6): {face: (0, column) for column, face in enumerate(FACES)},
    (6, 1): {face: (row, 0) for row, face in enumerate(FACES)},
}
"""By rows and columns of faces: where each lies. In an upright cross, -z hangs below -y, upside down."""


def face_of(stem: str) -> tuple[str, str] | None:
    """Find the face that a file's name without its ending stands for, and the rest of the name; None if it is no face's.

    A face's name is the whole name, or stands at its end or beginning: "sky_posx", "nx-studio", "skybox right", "m4_ft".
    Case does not matter.
    """
    name = stem.lower().strip()
    for alias in _LONGEST_FIRST:
        mark = re.escape(alias)
        separated = rf"(?:^|[\s_.\-]){mark}$" if alias[0].isalnum() else rf"{mark}$"
        for pattern in (separated, rf"^{mark}[\s_.\-]"):
            if found := re.search(pattern, name):
                return _BY_ALIAS[alias], _rest(name, found)
        if len(alias) >= _SHORTEST and (found := re.search(rf"{mark}$", name)):
            return _BY_ALIAS[alias], _rest(name, found)
    return None


def _rest(name: str, found: re.Match[str]) -> str:
    return (name[: found.start()] + name[found.end() :]).strip(" _.-")


def faces_in(picture: Picture) -> dict[str, Picture]:
    """Cut a picture that holds all faces: a cross of 4 x 3 or 3 x 4 faces, or a strip of six, +x first.

    Args:
        picture: (height, width, 3), top row first.

    Raises:
        PictureError: if its proportions are none of these.
    """
    height, width = picture.shape[:2]
    for (rows, columns), places in _LAYOUTS.items():
        size = height // rows
        if size and height == rows * size and width == columns * size:
            faces = {
                face: picture[row * size : (row + 1) * size, column * size : (column + 1) * size]
                for face, (row, column) in places.items()
            }
            if (rows, columns) == (4, 3):
                faces["negz"] = faces["negz"][::-1, ::-1]
            return {face: np.ascontiguousarray(faces[face]) for face in FACES}
    raise PictureError(
        f"A picture of {width} x {height} is no cube map: a cross has 4 x 3 or 3 x 4 faces, a strip 6 x 1 or 1 x 6."
    )
