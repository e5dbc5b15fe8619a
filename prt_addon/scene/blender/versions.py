# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks versions of what is stored in files: bakes, lights and node groups count theirs from 1, each on its own.

What is older is replaced where it is used. What is newer is refused and left as it is, since it cannot be known today
what it will hold. What carries no version, or a strange one, counts as 0: older than all, and of unknown origin.
"""

from __future__ import annotations

from typing import Any

from ...core.errors import VersionError


def version_of(stored: Any, key: str = "version") -> int:
    """The version in a custom property, or in the custom properties of a data-block."""
    version = stored.get(key) if hasattr(stored, "get") else None
    return version if isinstance(version, int) else 0


def refuse_newer(what: str, version: int, known: int) -> None:
    """Raises VersionError if a version is newer than the one that is known.

    Args:
        what: whose it is and what was done to it: "Object 'Ball' was baked".
        version: that is stored.
        known: the newest that this extension reads.
    """
    if version > known:
        raise VersionError(f"{what} by a newer version of PRT Relight: use a newer version of the extension here.")
