# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads what light does at the surfaces of one state of the scene: which share of it they return, and which they stop."""

from __future__ import annotations

from .albedo import AlbedoReader
from .opacity import OpacityReader
from .patterns import PatternReader


class MaterialReaders:
    """Both readers. They leave nothing in the file once they are closed."""

    def __init__(self) -> None:
        patterns = PatternReader()
        self.albedo, self.opacity = AlbedoReader(patterns), OpacityReader(patterns)

    def __enter__(self) -> MaterialReaders:
        return self

    def __exit__(self, *_: object) -> None:
        self.albedo.close()
        self.opacity.close()
