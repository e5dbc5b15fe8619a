# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks what belongs to this file: data that is linked from a library cannot be changed, nor can overrides hold ours."""

from __future__ import annotations

import bpy

from ...core.errors import PRTError


def is_local(data: bpy.types.ID) -> bool:
    """Whether a data-block is this file's own, so that what is written to it stays."""
    return data.is_editable and data.override_library is None


def check_local(data: bpy.types.ID, what: str, then: str, error: type[PRTError]) -> None:
    """Raises an error that says what to do, unless a data-block is this file's own.

    Args:
        data: the data-block.
        what: names it: "Mesh 'Ball' of 'Ball'".
        then: what it was needed for: "bake".
        error: the kind of error.
    """
    if not is_local(data):
        how = "is a library override" if data.override_library else "is linked from a library"
        raise error(f"{what} {how}: make it local, then {then}.")
