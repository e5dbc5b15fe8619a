# SPDX-License-Identifier: GPL-3.0-or-later
"""A number at the cursor, for work that keeps the window waiting."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TypeVar

import bpy

Item = TypeVar("Item")


def counted(items: Sequence[Item]) -> Iterator[Item]:
    """One after the other, with the share that is done at the cursor."""
    manager = bpy.context.window_manager
    manager.progress_begin(0, len(items))
    try:
        for number, item in enumerate(items):
            manager.progress_update(number)
            yield item
    finally:
        manager.progress_end()
