# SPDX-License-Identifier: GPL-3.0-or-later
"""Cube maps to SH light, and to the equirectangular picture that Blender can show.

Faces are pictures as files hold them, top row first. Tables are written in the Y-up world of the graphics
interfaces; what comes out is in Blender's axes, by `(x, y, z) -> (x, -z, y)`: what OpenGL sees ahead, -z, lies in +y.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal

import numpy as np
import numpy.typing as npt

from . import sh
from .envmap import srgb_to_linear
from .errors import PictureError
from .rotation import rotation_matrix

Array = npt.NDArray[np.float64]
Picture = npt.NDArray[np.float32]
Faces = Mapping[str, Picture] | Sequence[Picture]
Table = Literal["OPENGL", "GAMES202"]

FACES = ("posx", "negx", "posy", "negy", "posz", "negz")

Y_UP_TO_Z_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
"""Takes Y-up columns to Blender's axes: a quarter turn about x."""

# Per face: which way the picture's right, the picture's bottom and its middle point.
_OPENGL = {  # OpenGL 4.6 core profile, table 8.19
    "posx": ((0, 0, -1), (0, -1, 0), (1, 0, 0)),
    "negx": ((0, 0, 1), (0, -1, 0), (-1, 0, 0)),
    "posy": ((1, 0, 0), (0, 0, 1), (0, 1, 0)),
    "negy": ((1, 0, 0), (0, 0, -1), (0, -1, 0)),
    "posz": ((1, 0, 0), (0, -1, 0), (0, 0, 1)),
    "negz": ((-1, 0, 0), (0, -1, 0), (0, 0, -1)),
}
# The course's precomputation swaps +-y and +-z and mirrors +x: its light.txt files need the same.
_GAMES202 = _OPENGL | {
    "posx": ((0, 0, 1), (0, -1, 0), (1, 0, 0)),
    "posy": _OPENGL["negy"],
    "negy": _OPENGL["posy"],
    "posz": _OPENGL["negz"],
    "negz": _OPENGL["posz"],
}
_TABLES = {
    name: np.array([table[face] for face in FACES]) @ Y_UP_TO_Z_UP.T
    for name, table in (("OPENGL", _OPENGL), ("GAMES202", _GAMES202))
}

_TEXELS_AT_A_TIME = 1 << 16  # bounds the float64 copies whatever the size of the faces


def decode(encoded: npt.NDArray[np.uint8] | Picture, table: Table = "OPENGL") -> Picture:
    """Linear radiance of an 8-bit picture: the course's `(x / 255) ** 2.2`, or the sRGB curve for OPENGL.

    Args:
        encoded: any shape; bytes, or those bytes divided by 255.
        table: whose convention.
    """
    values = encoded.astype(np.float32) / np.float32(255 if encoded.dtype == np.uint8 else 1)
    return values ** np.float32(2.2) if table == "GAMES202" else srgb_to_linear(values)


def solid_angles(size: int, rows: slice = slice(None)) -> Array:
    """Exact solid angle, in steradian, of the texels of a face; the six faces sum to 4pi.

    The area of the rectangle from the middle of a face to (u, v) is `atan2(u v, sqrt(u**2 + v**2 + 1))`; a texel is
    the difference of its four corners (Driscoll 2012, "Cubemap Texel Solid Angle").

    Args:
        size: texels along an edge, N.
        rows: which rows.

    Returns:
        (rows, N) float64.
    """
    first, last, _ = rows.indices(size)
    u = 2.0 * np.arange(size + 1) / size - 1.0
    v = u[first : last + 1, None]
    return np.diff(np.diff(np.arctan2(u * v, np.sqrt(u * u + v * v + 1.0)), axis=0), axis=1)


def project_cubemap(faces: Faces, table: Table = "OPENGL", order: int = sh.ORDER) -> Array:
    """Project a cube map, every texel, onto spherical harmonics.

    Texels weigh their exact solid angle and stand at their middle, which leaves an error of 1 / N**2. All faces share
    one basis in their own frame; each sum is then turned, or mirrored, into the world.

    Args:
        faces: the six faces by name, or in the order of `FACES`; each (N, N, 3) linear radiance, top row first.
        table: `OPENGL`, which shows what a viewer of the cube map sees, or `GAMES202`, for the course's `light.txt`
            (write it with `games202.write_light`, which changes the convention of the coefficients).
        order: highest band.

    Returns:
        ((order + 1)**2, 3) float64 in Blender's axes, `L_i = sum L(w) Y_i(w) dw`.

    Raises:
        PictureError: if a face is missing, not square, of another size, or holds NaN or infinite texels.
    """
    pictures = _checked(faces)
    size = len(pictures[0])
    sums = np.zeros((len(FACES), sh.coefficient_count(order), 3))
    step = max(1, _TEXELS_AT_A_TIME // size)
    for first in range(0, size, step):
        rows = slice(first, min(first + step, size))
        local = _local_directions(np.arange(size), np.arange(size)[rows, None], size)
        local /= np.linalg.norm(local, axis=-1, keepdims=True)
        weighted = (sh.basis(local, order) * solid_angles(size, rows)[..., None]).reshape(-1, sums.shape[1])
        for total, picture in zip(sums, pictures, strict=True):
            total += weighted.T @ picture[rows].reshape(-1, 3).astype(np.float64)
    turns = np.stack([rotation_matrix(frame.T, order) for frame in _TABLES[table]])
    return np.matmul(turns, sums).sum(axis=0)


def to_equirect(faces: Faces, table: Table = "OPENGL", height: int | None = None) -> Picture:
    """Resample a cube map as the equirectangular picture that shows the same sky in a Blender world.

    Bilinear between texels, across the edges of faces too.

    Args:
        faces: as for `project_cubemap`.
        table: as for `project_cubemap`.
        height: rows; the width is twice that. Without it 2 N, which keeps the cube map's resolution.

    Returns:
        (height, 2 * height, 3) float32 linear radiance, row 0 at the bottom (Blender's order).

    Raises:
        PictureError: as `project_cubemap`.
    """
    pictures, frames = _checked(faces), _TABLES[table]
    size = len(pictures[0])
    height = height or 2 * size
    bordered = _with_border(pictures, frames)
    azimuth = np.pi * (1.0 - (np.arange(2 * height) + 0.5) / height)
    elevation = np.pi * ((np.arange(height) + 0.5) / height - 0.5)
    picture = np.empty((height, 2 * height, 3), dtype=np.float32)
    step = max(1, _TEXELS_AT_A_TIME // (2 * height))
    for first in range(0, height, step):
        rows = slice(first, first + step)
        ring, up = np.cos(elevation[rows, None]), np.sin(elevation[rows, None])
        directions = np.stack(np.broadcast_arrays(ring * np.cos(azimuth), ring * np.sin(azimuth), up), axis=-1)
        face, column, row = _locate(directions, frames, size)
        picture[rows] = _bilinear(bordered, face, column + 1.0, row + 1.0)
    return picture


def _checked(faces: Faces) -> list[Picture]:
    """The six faces in the order of `FACES`, known to be square, finite and of one size."""
    if not isinstance(faces, Mapping):
        if len(faces) != len(FACES):
            raise PictureError(f"A cube map has 6 faces, not {len(faces)}: give {', '.join(FACES)}.")
        faces = dict(zip(FACES, faces, strict=True))
    if missing := [name for name in FACES if name not in faces]:
        raise PictureError(f"The cube map lacks {', '.join(missing)}: all of {', '.join(FACES)} are needed.")
    for name in FACES:
        face, size = faces[name], len(faces[FACES[0]])
        if face.ndim != 3 or face.shape[2] != 3:
            raise PictureError(f"The cube-map face {name} is no RGB picture: save it with three channels.")
        height, width = face.shape[:2]
        if height != width or not width:
            raise PictureError(f"The cube-map face {name} is {width} x {height} texels: crop it to a square.")
        if width != size:
            raise PictureError(
                f"The cube-map face {name} is {width} texels wide but {FACES[0]} is {size}: scale all six to one size."
            )
        if not np.isfinite(face).all():
            raise PictureError(
                f"The cube-map face {name} holds NaN or infinite texels: repair it in the compositor and load it again."
            )
    return [faces[name] for name in FACES]


def _local_directions(column: npt.ArrayLike, row: npt.ArrayLike, size: int) -> Array:
    """Towards texels, in the frame of their face: (u, v, 1), not of unit length."""
    u, v = ((2.0 * np.asarray(index) + 1.0) / size - 1.0 for index in (column, row))
    return np.stack(np.broadcast_arrays(u, v, 1.0), axis=-1)


def _locate(directions: Array, frames: Array, size: int) -> tuple[npt.NDArray[np.intp], Array, Array]:
    """Face, column and row that directions (..., 3) hit; whole numbers are the middles of texels."""
    u, v, ahead = np.einsum("fij,...j->if...", frames, directions, optimize=True)
    face = np.argmax(ahead, axis=0)
    u, v, ahead = (np.take_along_axis(part, face[None], axis=0)[0] for part in (u, v, ahead))
    return face, (u / ahead + 1.0) * size / 2.0 - 0.5, (v / ahead + 1.0) * size / 2.0 - 0.5


def _with_border(pictures: list[Picture], frames: Array) -> Picture:
    """(6, N + 2, N + 2, 3): the faces, each with a border of its neighbours' nearest texels."""
    size = len(pictures[0])
    bordered = np.empty((len(FACES), size + 2, size + 2, 3), dtype=np.float32)
    bordered[:, 1:-1, 1:-1] = pictures
    border = np.ones((size + 2, size + 2), dtype=bool)
    border[1:-1, 1:-1] = False
    row, column = np.nonzero(border)
    outside = _local_directions(column - 1, row - 1, size)
    for index, frame in enumerate(frames):
        face, *texel = _locate(outside @ frame, frames, size)
        x, y = (np.clip(np.rint(where), 0, size - 1).astype(int) + 1 for where in texel)
        bordered[index, row, column] = bordered[face, y, x]
    return bordered


def _bilinear(pictures: Picture, face: npt.NDArray[np.intp], column: Array, row: Array) -> Picture:
    """Colours (..., 3) at fractional columns and rows."""
    x, y = column.astype(np.intp), row.astype(np.intp)  # nothing is negative
    right, down = ((column - x)[..., None].astype(np.float32), (row - y)[..., None].astype(np.float32))
    width = pictures.shape[1]
    texels, first = pictures.reshape(-1, 3), (face * width + y) * width + x
    upper, upper_right, lower, lower_right = (texels.take(first + by, axis=0) for by in (0, 1, width, width + 1))
    upper += right * (upper_right - upper)
    lower += right * (lower_right - lower)
    return upper + down * (lower - upper)
