# SPDX-License-Identifier: GPL-3.0-or-later
"""Digests of arrays: whether two things are the same, without keeping either."""

from __future__ import annotations

import hashlib
from typing import Any

import numpy as np
import numpy.typing as npt

_BYTES = 16


def digest(*parts: bytes | npt.NDArray[Any]) -> bytes:
    """One digest of several things, each with its type and size, so that no two lists of things look alike."""
    whole = hashlib.blake2b(digest_size=_BYTES)
    for part in parts:
        array = np.frombuffer(part, dtype=np.uint8) if isinstance(part, bytes) else np.ascontiguousarray(part)
        whole.update(f"{array.dtype.str}{array.shape}".encode())
        whole.update(array.reshape(-1).data)
    return whole.digest()
