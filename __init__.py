# SPDX-License-Identifier: GPL-3.0-or-later
"""PRT Relight, a Blender extension: register() and unregister(), and what Blender looks for here."""

from __future__ import annotations

from . import operators, ui
from .prt_addon import handlers
from .prt_addon.scene import preferences, settings
from .prt_addon.scene.bake.before import take_back
from .prt_addon.scene.export.gltf import (
    glTF2ExportUserExtension as glTF2ExportUserExtension,  # Blender looks for it here
)
from .prt_addon.scene.export.gltf_import import (
    glTF2ImportUserExtension as glTF2ImportUserExtension,  # and for this
)
from .prt_addon.session import session
from .prt_addon.worker.job import end_engine

_PARTS = (preferences, settings, handlers, operators, ui)


def register() -> None:
    """Enable the extension: Blender calls it."""
    for part in _PARTS:
        part.register()


def unregister() -> None:
    """Disable the extension, and leave nothing behind."""
    end_engine()
    take_back()
    for part in reversed(_PARTS):
        part.unregister()
    session.forget_file()
