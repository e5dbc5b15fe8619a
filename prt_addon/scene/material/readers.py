# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads what light does at the surfaces of one state of the scene: which share of it they return, and which they stop."""

from __future__ import annotations

from .albedo import AlbedoReader
from .cycles_colour import ColourRequest, CyclesRequests
from .cycles_texels import TexelRequest
from .opacity import OpacityReader
from .patterns import PatternReader


class MaterialReaders:
    """Both readers, for as long as Cycles may have to evaluate what they read; afterwards nothing of it is in the file."""

    def __init__(self) -> None:
        patterns = PatternReader()
        self._requests = CyclesRequests(ColourRequest), CyclesRequests(TexelRequest)
        self.albedo = AlbedoReader(patterns, self._requests[0])
        self.opacity = OpacityReader(patterns, self._requests[1])

    def __enter__(self) -> MaterialReaders:
        return self

    def __exit__(self, *_: object) -> None:
        for requests in self._requests:
            requests.close()
