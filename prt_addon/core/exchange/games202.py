# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads and writes the text files of the GAMES202 course's WebGL framework: `light.txt` and `transport.txt`.

Both hold nine coefficients in the course's convention: Condon-Shortley signs, and the pole of the harmonics on the z
axis of a world whose y axis is up. What goes in and comes out here is in ours: no such sign, Blender's axes.

`light.txt` is nine rows "R G B". `transport.txt` is a line with the number of mesh vertices, then one row of nine
numbers per face corner, in the order of the (triangular) faces. The framework drops what follows the last line break, so
there has to be one.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Literal

import numpy as np

from ..arrays import Float64
from ..errors import PRTError
from ..files import written
from ..sky.cube_map import Y_UP_TO_Z_UP
from ..sphere import sh
from ..sphere.rotation import rotation_matrix

Flavour = Literal["RADIANCE", "IRRADIANCE"]
"""What a transport row holds of an open receiver: 0.2821 first (radiance, ours), or 0.8862 (without the 1/pi)."""

_COUNT = sh.coefficient_count(sh.ORDER)
_LARGEST = 1e6  # of a coefficient of transport: a white furnace of a hundred bounces stays below

_BETWEEN_FLAVOURS = 0.5  # the geometric mean of the two first numbers, exactly


class InterchangeError(PRTError):
    """A text file of coefficients that cannot be read, or values that cannot be written."""


@cache
def course_matrix(order: int = sh.ORDER) -> Float64:
    """The matrix C that takes coefficients of the course's convention into ours, and ours into the course's.

    First the Condon-Shortley sign, `(-1)**m`, then the quarter turn that takes y up to z up, as an SH rotation. The sign
    is the half turn about the pole, so both together are a half turn about (0, 1, -1): its own inverse.

    The numbers have the same bits on all machines, though the rotation comes out of a linear solve: under a quarter turn,
    the squares of band l > 0 are whole multiples of `4**(1 - l)` (seen in all bands up to 8).

    Args:
        order: highest band, 8 at most.

    Returns:
        ((order + 1)**2, (order + 1)**2) float64, orthogonal and symmetric; `ours = C @ theirs`, `theirs = C @ ours`. In
        bands 0 and 1 a permutation with signs.
    """
    matrix = rotation_matrix(Y_UP_TO_Z_UP, order)
    for band in range(order + 1):
        block = matrix[sh.band_slice(band), sh.band_slice(band)]
        steps = 4.0 ** max(band - 1, 0)
        block[:] = np.sign(block) * np.sqrt(np.rint(block**2 * steps) / steps) * (-1.0) ** np.arange(-band, band + 1)
    return matrix + 0.0  # no negative zeros


def write_light(path: Path, light: Float64) -> None:
    """Write `light.txt`.

    Args:
        path: the file, replaced if it is there.
        light: (9, 3) radiance, our convention.

    Raises:
        InterchangeError: if the light holds NaN or infinite numbers.
        OSError: if the file cannot be written.
    """
    rows = _course_rows(path, light.T).T
    with written(path) as (temporary,):
        _write(temporary, rows)


def read_light(path: Path) -> Float64:
    """Read `light.txt`: (9, 3) radiance, our convention.

    Raises:
        InterchangeError: if the file does not hold nine rows of three finite numbers.
        OSError: if the file cannot be opened.
    """
    rows = _parse(path, _numbered_lines(path), 3)
    if len(rows) != _COUNT:
        raise InterchangeError(f"{path.name} has {len(rows)} rows, but a light has {_COUNT}: export it again.")
    return course_matrix() @ rows


def write_transport(path: Path, transport: Float64, vertex_count: int) -> None:
    """Write `transport.txt`.

    Args:
        path: the file, replaced if it is there.
        transport: (corners, 9), our convention and with its 1/pi; three rows per triangle.
        vertex_count: vertices of the mesh, for the first line.

    Raises:
        InterchangeError: if the transport holds NaN or infinite numbers.
        OSError: if the file cannot be written.
    """
    rows = _course_rows(path, transport)
    with written(path) as (temporary,):
        _write(temporary, rows, header=str(vertex_count))


def write_both(light_path: Path, light: Float64, transport_path: Path, transport: Float64, vertex_count: int) -> None:
    """Write both files as one: whatever happens, they belong together. Arguments and errors as those of either."""
    light_rows, transport_rows = _course_rows(light_path, light.T).T, _course_rows(transport_path, transport)
    with written(light_path, transport_path) as (for_light, for_transport):
        _write(for_light, light_rows)
        _write(for_transport, transport_rows, header=str(vertex_count))


def read_transport(path: Path, corner_count: int) -> tuple[Float64, Flavour]:
    """Read `transport.txt`, in either of the scales that are in circulation.

    Nothing a white receiver sends out exceeds what an open one does, 0.2821, under any number of bounces; without the
    1/pi the mesh's most open corners lie near 0.8862. The largest first number distinguishes the two, at 0.5, for any
    mesh of which some corner sees more than 56 % of the sky.

    Args:
        path: the file.
        corner_count: face corners of the mesh that it is for.

    Returns:
        (corners, 9) float64 in our convention and with the 1/pi, and which flavour the file had.

    Raises:
        InterchangeError: if the counts do not match or a row does not hold nine finite numbers.
        OSError: if the file cannot be opened.
    """
    lines = _numbered_lines(path)
    header = lines[0][1].split() if lines else []
    if len(header) != 1 or not header[0].isdecimal():
        raise InterchangeError(f"{path.name} does not start with the number of vertices: export it again.")
    rows = _parse(path, lines[1:], _COUNT)
    if len(rows) != corner_count:
        raise InterchangeError(
            f"{path.name} has {len(rows)} rows, but the mesh has {corner_count} face corners: "
            "choose the mesh it was made from, triangulated."
        )
    irradiance = len(rows) > 0 and rows[:, 0].max() > _BETWEEN_FLAVOURS
    if not np.abs(rows).max(initial=0.0) <= _LARGEST:
        raise InterchangeError(
            f"{path.name} holds numbers beyond {_LARGEST:g}, which no transport has: export it again."
        )
    ours = rows @ course_matrix()
    return (ours / np.pi, "IRRADIANCE") if irradiance else (ours, "RADIANCE")


def _course_rows(path: Path, rows: Float64) -> Float64:
    """Vectors (n, 9) of ours in the course's convention, fit to be printed.

    What lies thirteen digits below the largest number of a vector is rounding of the change of axes: it is cleared, or
    files would differ that hold the same.
    """
    if not np.isfinite(rows).all():
        raise InterchangeError(f"{path.name} cannot hold NaN or infinite numbers: bake or project again.")
    theirs = rows @ course_matrix()
    largest = np.maximum(np.abs(theirs).max(axis=1, keepdims=True), 1e-200)
    unit = 10.0 ** (np.floor(np.log10(largest * (1.0 + 5e-6))) - 13.0)  # the same once `largest` has been printed
    return np.rint(theirs / unit) * unit + 0.0  # no -0


def _write(path: Path, rows: Float64, header: str = "") -> None:
    """Six significant digits, space separated, as the course's own C++ prints them."""
    with path.open("w", encoding="ascii", newline="\n") as file:
        np.savetxt(file, rows, fmt="%.6g", header=header, comments="")


def _numbered_lines(path: Path) -> list[tuple[int, str]]:
    """The lines that hold anything, with their numbers from 1; commas count as spaces, any line break will do."""
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise InterchangeError(f"{path.name} is no text file: choose one that the course's framework reads.") from error
    lines = enumerate(text.replace(",", " ").split("\n"), start=1)
    return [(number, line) for number, line in lines if line.strip()]


def _parse(path: Path, lines: list[tuple[int, str]], columns: int) -> Float64:
    """(rows, columns) float64, finite; the first line that is anything else is named."""
    if not lines:
        return np.empty((0, columns))
    try:
        rows = np.loadtxt([line for _, line in lines], comments=None, ndmin=2)
        if rows.shape[1] == columns and np.isfinite(rows).all():
            return rows
    except ValueError:
        pass
    raise InterchangeError(next(_complaints(path, lines, columns)))


def _complaints(path: Path, lines: list[tuple[int, str]], columns: int) -> Iterator[str]:
    """What is wrong with each line, by the slow way."""
    for number, line in lines:
        words = line.split()
        for word in words:
            try:
                finite = np.isfinite(float(word))
            except ValueError:
                yield f'{path.name}, line {number}: "{word}" is no number; export the file again.'
            else:
                if not finite:
                    yield f'{path.name}, line {number}: "{word}" is not finite; bake again and export.'
        if len(words) != columns:
            yield f"{path.name}, line {number}: {len(words)} numbers instead of {columns}; is the file cut off?"
    yield f"{path.name} holds something else than rows of {columns} numbers: export it again."
