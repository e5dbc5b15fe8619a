# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes radiance pictures (.hdr): three bytes and an exponent a texel (Ward, "Real Pixels", Graphics Gems II, 1991)."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ..arrays import Float32

_LITERAL = 128  # bytes in a row that are written as they are, at most


def radiance_file(picture: Float32) -> bytes:
    """A picture (height, width, 3) of linear radiance, row 0 at the bottom, as a file; negative radiance becomes 0.

    Each row holds its channels one after the other, as files with run lengths do; the runs are left to whatever compresses
    the file.
    """
    height, width = picture.shape[:2]
    texels = rgbe(picture[::-1])
    out = [f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n".encode()]
    if not 8 <= width < 32768:  # the format's limits of rows by channels
        return out[0] + texels.tobytes()
    start = bytes([2, 2, width >> 8, width & 255])
    for row in texels:
        out.append(start)
        for channel in row.T:
            data = channel.tobytes()
            for first in range(0, width, _LITERAL):
                piece = data[first : first + _LITERAL]
                out.append(bytes([len(piece)]) + piece)
    return b"".join(out)


def rgbe(picture: Float32) -> npt.NDArray[np.uint8]:
    """(..., 4): the channels as shares of a power of two, and its exponent plus 128."""
    colours = np.maximum(picture, 0.0).astype(np.float64)
    brightest = colours.max(axis=-1)
    _, exponents = np.frexp(np.where(brightest > 1e-32, brightest * (256.0 / 255.5), 1.0))  # rounds to 255 at most
    texels = np.zeros((*picture.shape[:-1], 4), dtype=np.uint8)
    texels[..., :3] = np.rint(colours * 256.0 / np.exp2(exponents)[..., None])
    texels[..., 3] = exponents + 128
    texels[brightest <= 1e-32] = 0
    return texels


def resized(picture: Float32, height: int) -> Float32:
    """A picture as a panorama (height, 2 height, 3) of means over what each texel covers, unless it is no higher anyway."""
    if picture.shape[0] <= height and picture.shape[1] == 2 * picture.shape[0]:
        return picture
    height = min(height, picture.shape[0])
    return _means(_means(picture, 0, height), 1, 2 * height)


def _means(values: npt.NDArray[np.float32], axis: int, count: int) -> Float32:
    """So many means along an axis: differences of the running sum, which goes in straight lines within a texel."""
    values = np.moveaxis(values, axis, 0)
    sums = np.concatenate([np.zeros((1, *values.shape[1:])), np.cumsum(values, axis=0, dtype=np.float64)])
    edges = np.linspace(0.0, len(values), count + 1)
    below = np.minimum(edges.astype(np.int64), len(values) - 1)
    share = (edges - below).reshape(-1, *[1] * (values.ndim - 1))
    at_edges = sums[below] * (1.0 - share) + sums[below + 1] * share
    means = np.diff(at_edges, axis=0) * (count / len(values))
    return np.moveaxis(means, 0, axis).astype(np.float32)
