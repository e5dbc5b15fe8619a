# SPDX-License-Identifier: GPL-3.0-or-later
"""Projects cube maps to SH light, and resamples them as the equirectangular picture that Blender can show.

Faces are pictures as files hold them, top row first. Tables are written in the Y-up world of the graphics
interfaces; what comes out is in Blender's axes, by `(x, y, z) -> (x, -z, y)`: what OpenGL sees ahead, -z, lies in +y.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Literal

import numpy as np
import numpy.typing as npt

from ..arrays import Float64
from ..errors import PictureError
from ..sphere import sh
from ..sphere.equirect import texel_directions
from ..sphere.rotation import rotation_matrix
from ..workers import IN_LINE
from .projection import project_equirect, srgb_to_linear

Picture = npt.NDArray[np.float32]
CubeFaces = Mapping[str, Picture] | Sequence[Picture]
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
_SLIGHT = 1e-3  # a change that needs a thousand times the force of another is not made


def decode(encoded: npt.NDArray[np.uint8] | Picture, table: Table = "OPENGL") -> Picture:
    """Decode an 8-bit picture to linear radiance: by the course's `(x / 255) ** 2.2`, or by the sRGB curve for OPENGL.

    Args:
        encoded: any shape; bytes, or those bytes divided by 255.
        table: whose convention.
    """
    values = encoded.astype(np.float32) / np.float32(255 if encoded.dtype == np.uint8 else 1)
    return values ** np.float32(2.2) if table == "GAMES202" else srgb_to_linear(values)


def face_solid_angles(size: int, rows: slice = slice(None)) -> Float64:
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


def project_cubemap(faces: CubeFaces, table: Table = "OPENGL", order: int = sh.ORDER) -> Float64:
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
        weighted = (sh.basis(local, order) * face_solid_angles(size, rows)[..., None]).reshape(-1, sums.shape[1])
        for total, picture in zip(sums, pictures, strict=True):
            total += weighted.T @ picture[rows].reshape(-1, 3).astype(np.float64)
    turns = np.stack([rotation_matrix(frame.T, order) for frame in _TABLES[table]])
    return np.matmul(turns, sums).sum(axis=0)


def to_equirect(faces: CubeFaces, table: Table = "OPENGL", height: int | None = None) -> Picture:
    """Resample a cube map as the equirectangular picture that shows the same sky in a Blender world.

    Bilinear between texels, across the edges of faces too, and averaged over each texel of the picture, by samples so
    fine that a sun of one texel keeps its energy within 3 %. `with_light` puts the rest right.

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
    height = height or 2 * len(pictures[0])
    pictures = [_shrunk(picture, height // 2) for picture in pictures]
    size = len(pictures[0])
    bordered = _with_border(pictures, frames)
    finer = -(-4 * size // height)
    picture = np.empty((height, 2 * height, 3), dtype=np.float32)

    def fill(rows: slice) -> None:
        """Average the samples of each texel in some rows of the picture."""
        samples = slice(rows.start * finer, rows.stop * finer)
        found = _bilinear(bordered, frames, texel_directions(height * finer, samples).reshape(-1, 3))
        picture[rows] = found.reshape(-1, finer, 2 * height, finer, 3).mean(axis=(1, 3))

    IN_LINE.run(height, max(1, _TEXELS_AT_A_TIME // (2 * height * finer * finer)), fill)
    return picture


def with_light(picture: Picture, light: Float64) -> Picture:
    """Change an equirectangular picture, as little as it takes, so that it projects, interpolated, to a given light.

    What resampling did to a picture is put right where it went wrong: the error of a texel is in proportion to its
    radiance p, so that the likeliest correction (weighted least squares) is `p**2 sum c_i Y_i(w)`, which falls on suns
    and leaves the rest alone. What a sun cannot carry, a second round spreads over the whole picture, by p.

    Args:
        picture: (height, 2 * height, 3) radiance, row 0 at the bottom, whose own light is not far off.
        light: (9, 3).

    Returns:
        (height, 2 * height, 3) float32. Its light is equal but for what would take more than a slight change: lone
        suns in a black sky stay where the picture shows them.
    """
    for power in (2, 1):
        picture = _corrected(picture, light - project_equirect(picture, interpolated=True), power)
    return picture


def _corrected(picture: Picture, lacking: Float64, power: int) -> Picture:
    """The picture p plus `p**power sum c_i Y_i(w)`, whose light is `lacking` (9, 3)."""
    scale = np.abs(picture).max(axis=(0, 1)) + np.float32(1e-30)  # powers of suns overflow
    moments = project_equirect((picture / scale) ** power, 2 * sh.ORDER)
    systems = np.einsum("ijk,kc->cij", _triple_products(), moments)
    weights = np.stack(
        [np.linalg.lstsq(*pair, rcond=_SLIGHT)[0] for pair in zip(systems, (lacking / scale).T, strict=True)], axis=1
    )
    corrected, height = np.empty_like(picture), len(picture)

    def fill(rows: slice) -> None:
        """Correct some rows of the picture."""
        factor = sh.basis(texel_directions(height, rows)) @ weights
        corrected[rows] = picture[rows] + scale * (picture[rows] / scale) ** power * factor

    IN_LINE.run(height, max(1, _TEXELS_AT_A_TIME // (2 * height)), fill)
    return corrected


@cache
def _triple_products() -> Float64:
    """(9, 9, 25) integrals of Y_i Y_j Y_k over the sphere; exact, by a product rule for polynomials of degree 9."""
    z, weight = np.polynomial.legendre.leggauss(5)  # type: ignore[no-untyped-call]
    azimuth = np.pi * (np.arange(10) + 0.5) / 5.0
    ring = np.sqrt(1.0 - z * z)[:, None]
    parts = ring * np.cos(azimuth), ring * np.sin(azimuth), z[:, None]
    values = sh.basis(np.stack(np.broadcast_arrays(*parts), axis=-1), 2 * sh.ORDER)
    low = values[..., : sh.coefficient_count(sh.ORDER)]
    return np.einsum("z,zai,zaj,zak->ijk", weight * np.pi / 5.0, low, low, values, optimize=True)


def _shrunk(picture: Picture, size: int) -> Picture:
    """A face, averaged over blocks as long as it stays at least as wide as `size`."""
    block = max(step for step in range(1, max(1, len(picture) // size) + 1) if len(picture) % step == 0)
    width = len(picture) // block
    return picture.reshape(width, block, width, block, 3).mean(axis=(1, 3)) if block > 1 else picture


def _checked(faces: CubeFaces) -> list[Picture]:
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


def _local_directions(column: npt.ArrayLike, row: npt.ArrayLike, size: int) -> Float64:
    """Towards texels, in the frame of their face: (u, v, 1), not of unit length."""
    u, v = ((2.0 * np.asarray(index) + 1.0) / size - 1.0 for index in (column, row))
    return np.stack(np.broadcast_arrays(u, v, 1.0), axis=-1)


def _locate(directions: Float64, frames: Float64, size: int) -> tuple[npt.NDArray[np.intp], Float64, Float64]:
    """Face, column and row that directions (n, 3) hit; whole numbers are the middles of texels."""
    face = np.argmax(directions @ frames[:, 2].T, axis=1)
    column, row = np.empty(len(face)), np.empty(len(face))
    for index, frame in enumerate(frames):
        here = np.flatnonzero(face == index)
        u, v, ahead = frame @ directions.take(here, axis=0).T
        column[here], row[here] = ((w / ahead + 1.0) * (size / 2.0) - 0.5 for w in (u, v))
    return face, column, row


def _with_border(pictures: list[Picture], frames: Float64) -> Picture:
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


def _bilinear(pictures: Picture, frames: Float64, directions: Float64) -> Picture:
    """Colours (n, 3) along directions (n, 3), of faces with a border."""
    width = pictures.shape[1]
    face, column, row = _locate(directions, frames, width - 2)
    column += 1.0
    row += 1.0
    x, y = column.astype(np.intp), row.astype(np.intp)  # nothing is negative
    right, down = ((column - x)[:, None].astype(np.float32), (row - y)[:, None].astype(np.float32))
    texels, first = pictures.reshape(-1, 3), (face * width + y) * width + x
    upper, upper_right, lower, lower_right = (texels.take(first + by, axis=0) for by in (0, 1, width, width + 1))
    upper += right * (upper_right - upper)
    lower += right * (lower_right - lower)
    return upper + down * (lower - upper)
