# SPDX-License-Identifier: GPL-3.0-or-later
"""Loads Blender as a Python module, and enables this checkout in it as the real extension.

Import this before `bpy`: it gives the process a profile of its own, so that the user's preferences and extensions
neither help nor hinder.
"""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

CHECKOUT = Path(__file__).resolve().parent.parent
PACKAGE = "bl_ext.dev.prt_relight"

_profile = tempfile.TemporaryDirectory(prefix="prt-profile-", ignore_cleanup_errors=True)
os.environ["BLENDER_USER_RESOURCES"] = _profile.name

try:
    import bpy
except ImportError as error:
    sys.exit(f"bpy cannot be imported: {error}\nFor its libraries, run: tools/system.sh {sys.executable}")
import addon_utils  # noqa: E402 - these come with bpy
import bmesh  # noqa: E402
import mathutils  # noqa: E402

__all__ = ["bmesh", "bpy", "mathutils"]


def enable_extension() -> None:
    """Enable the checkout under its extension name, as Blender does with an installed one."""
    folder = Path(_profile.name) / "dev"
    folder.mkdir()
    (folder / "prt_relight").symlink_to(CHECKOUT, target_is_directory=True)
    bpy.context.preferences.extensions.repos.new(name="dev", module="dev", custom_directory=str(folder), source="USER")
    reenable_extension()


def reenable_extension() -> None:
    """Enable the linked checkout."""
    if addon_utils.enable(PACKAGE, default_set=True) is None:
        raise RuntimeError(f"Blender {bpy.app.version_string} refused to enable the extension {PACKAGE}")


def disable_extension() -> None:
    """Disable it again: handlers and timers left at exit can hang the module."""
    addon_utils.disable(PACKAGE, default_set=True)


@contextmanager
def extension_disabled() -> Iterator[None]:
    """Disable the extension for a while; it is enabled again whatever happens, as all that follows needs it."""
    disable_extension()
    try:
        yield
    finally:
        reenable_extension()


def use_nodes(block: bpy.types.Material | bpy.types.World) -> None:
    """Have a material or a world made of nodes: since 5.0 they all are, and saying so is deprecated."""
    if bpy.app.version < (5, 0, 0):
        block.use_nodes = True


def eevee_engine() -> str:
    """EEVEE's engine identifier in this Blender."""
    return "BLENDER_EEVEE_NEXT" if bpy.app.version < (5, 0, 0) else "BLENDER_EEVEE"


def studio_hdri(name: str) -> Path:
    """One of the photographic HDRIs that Blender ships: city, courtyard, forest, interior, night, studio, ..."""
    return Path(bpy.utils.system_resource("DATAFILES", path="studiolights/world")) / f"{name}.exr"


@contextmanager
def quiet() -> Iterator[None]:
    """Hide what Blender's C code writes to the terminal: a line per tile would bury the progress.

    What goes wrong still raises.
    """
    sys.stdout.flush()
    sys.stderr.flush()
    saved = {stream: os.dup(stream) for stream in (1, 2)}
    with Path(os.devnull).open("w") as nowhere:
        for stream in saved:
            os.dup2(nowhere.fileno(), stream)
        try:
            yield
        finally:
            sys.stdout.flush()
            for stream, copy in saved.items():
                os.dup2(copy, stream)
                os.close(copy)
