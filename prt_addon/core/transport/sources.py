# SPDX-License-Identifier: GPL-3.0-or-later
"""Collects what a bounce reads from: the receivers at the corners of triangles, in the colours that they show there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ..arrays import Float32, Int64
from ..surface import Albedo


@dataclass(frozen=True)
class Sources:
    """The distinct (receiver, colour) pairs at the corners of triangles: what a bounce reads from.

    Light is tinted here, once per pair and not once per hit, wherever a triangle has one colour.

    Attributes:
        receiver: (M,) int64.
        tint: (M, C) float32; black where the corner shows no receiver.
        corner: (T, 3) int32, the source at each corner.
    """

    receiver: Int64
    tint: Float32
    corner: npt.NDArray[np.int32]

    @classmethod
    def of(cls, albedo: Albedo, corner_receiver: npt.NDArray[np.integer[Any]], channels: int) -> Sources:
        """Sources of all triangles; patterned ones are left white, since each hit brings its own colour."""
        colours = albedo.constants[:, :channels].copy()
        colours[albedo.is_patterned] = 1.0
        colour = _row_ids(colours)
        key = np.where(corner_receiver < 0, -1, corner_receiver * np.int64(colour.max() + 1) + colour[:, None])
        _, example, inverse = np.unique(key, return_index=True, return_inverse=True)
        receiver = corner_receiver.ravel()[example].astype(np.int64)
        tint = np.where(receiver[:, None] < 0, np.float32(0.0), colours[example // 3])
        return cls(np.maximum(receiver, 0), tint, inverse.reshape(-1, 3).astype(np.int32))

    @property
    def black(self) -> int:
        """The number of one more source, which returns nothing."""
        return len(self.receiver)

    def returned_light(self, transport: Float32) -> Float32:
        """(M + 1, C * 9) what each source returns of (N, C, 9)."""
        returned_light = np.zeros((len(self.receiver) + 1, *transport.shape[1:]), dtype=np.float32)
        np.multiply(transport[self.receiver], self.tint[:, :, None], out=returned_light[:-1])
        return returned_light.reshape(len(returned_light), -1)


def _row_ids(rows: Float32) -> Int64:
    """(T,) a number for each row (T, C), the same for equal rows."""
    ids = np.zeros(len(rows), dtype=np.int64)
    for column in rows.T:
        values = np.unique(column, return_inverse=True)[1]
        ids = np.unique(ids * (values.max() + 1) + values, return_inverse=True)[1]
    return ids
