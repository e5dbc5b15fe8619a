# SPDX-License-Identifier: GPL-3.0-or-later
"""PRT Relight, a Blender extension: register() and unregister(), nothing else."""

from __future__ import annotations

from . import operators, ui
from .prt_addon import bake_job, handlers
from .prt_addon.scene import settings

_PARTS = (settings, handlers, operators, ui)


def register() -> None:
    for part in _PARTS:
        part.register()


def unregister() -> None:
    bake_job.unregister()
    for part in reversed(_PARTS):
        part.unregister()
