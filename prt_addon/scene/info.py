# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes what somebody who helps needs to know as text: versions, settings, light, bakes, and the last messages."""

from __future__ import annotations

import platform
import tomllib
from collections import Counter
from collections.abc import Iterator
from importlib import metadata
from pathlib import Path

import bpy
import numpy as np

from ..core.transport import raycast
from ..session import session
from .light.lamps import suns_of
from .light.light import has_light
from .light.state import light_state
from .mesh.carrier import carrier_of, is_carrier, transport_mesh
from .mesh.record import read_record
from .settings import BakeProperties, LightProperties

_MANIFEST = Path(__file__).resolve().parents[2] / "blender_manifest.toml"


def info(context: bpy.types.Context) -> str:
    """Write a block of lines that holds nothing private: no paths, no names but those of worlds and in messages."""
    return "\n".join(f"{name}: {value}" for name, value in _lines(context))


def _lines(context: bpy.types.Context) -> Iterator[tuple[str, object]]:
    scene = context.scene
    yield "PRT Relight", tomllib.loads(_MANIFEST.read_text(encoding="utf-8"))["version"]
    yield "Blender", f"{bpy.app.version_string}, {bpy.app.build_hash.decode()}, {_window()}"
    yield "System", f"{platform.platform()}, {platform.machine()}, Python {platform.python_version()}"
    yield "Libraries", f"NumPy {np.__version__}, embreex {_embreex()}"
    yield "Engine", f"{scene.render.engine}, {scene.view_settings.view_transform}"
    for title, properties in (("Bake", BakeProperties), ("Light", LightProperties)):
        values = (f"{name}={getattr(scene.prt, name)}" for name in properties.__annotations__)
        yield f"{title} settings", ", ".join(values)
    yield "World", _world(scene.world)
    for kind, count in Counter(_bakes(scene)).items():
        yield "Bakes", f"{count} of {kind}"
    for notice in session.notices.get(scene.session_uid, []):
        yield "Said", notice.sentence


def _window() -> str:
    if bpy.app.background:
        return "in background"
    import gpu  # type: ignore[import-not-found]

    return f"{gpu.platform.backend_type_get()}, {gpu.platform.renderer_get()}"


def _embreex() -> str:
    if not raycast.is_available():
        return "missing"
    try:
        return metadata.version("embreex")
    except metadata.PackageNotFoundError:
        return "of unknown version"


def _world(world: bpy.types.World | None) -> str:
    if world is None:
        return "none"
    lamps = f", {len(suns_of(world))} lamps" if has_light(world) else ""
    return f"{light_state(world).text}{lamps}"


def _bakes(scene: bpy.types.Scene) -> Iterator[str]:
    """What each baked object of a scene was baked with, in words."""
    for ob in scene.objects:
        record = read_record(transport_mesh(ob)) if ob.type == "MESH" and not is_carrier(ob) else None
        if record:
            carried = ", carried" if carrier_of(ob) else ""
            yield f"{record.settings.mode}, {record.settings.samples} samples{carried}"
