# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders a small still of the scene as EEVEE shows it from its camera."""

from __future__ import annotations

import tempfile
from pathlib import Path

import bpy

from ..blender.rendered import picture_kept

_LONGER_SIDE = 960
_SAMPLES = 16


def still_picture(scene: bpy.types.Scene) -> bytes | None:
    """A JPEG; None if the scene has no camera, or this machine cannot draw. Settings and the last render are put back."""
    if scene.camera is None:
        return None
    with tempfile.TemporaryDirectory(prefix="prt-still-") as folder:
        path = Path(folder) / "still.jpg"
        before = _set(_wanted(scene, path))
        try:
            with picture_kept():
                bpy.ops.render.render(write_still=True, scene=scene.name)
        except RuntimeError:  # no graphics, or a render that runs
            return None
        finally:
            _set(before)
        return path.read_bytes() if path.is_file() else None


Settings = list[tuple[bpy.types.bpy_struct, dict[str, object]]]


def _wanted(scene: bpy.types.Scene, path: Path) -> Settings:
    render = scene.render
    output = render.image_settings
    longer = max(render.resolution_x, render.resolution_y)
    eevee = "BLENDER_EEVEE_NEXT" if bpy.app.version < (5, 0, 0) else "BLENDER_EEVEE"
    return [
        (output, {"media_type": "IMAGE"} if hasattr(output, "media_type") else {}),  # 5.0: decides on the formats
        (output, {"file_format": "JPEG", "color_mode": "RGB", "quality": 85}),
        (render, {"engine": eevee, "filepath": str(path), "film_transparent": False, "use_file_extension": True}),
        (render, {"resolution_percentage": min(100, max(1, 100 * _LONGER_SIDE // longer)), "use_border": False}),
        (render, {"use_compositing": False, "use_sequencer": False, "use_overwrite": True}),
        (scene.eevee, {"taa_render_samples": min(scene.eevee.taa_render_samples, _SAMPLES)}),
    ]


def _set(wanted: Settings) -> Settings:
    """Change settings; what they were, to be set again."""
    before: Settings = []
    for owner, values in wanted:
        before.insert(0, (owner, {name: getattr(owner, name) for name in values}))
        for name, value in values.items():
            if getattr(owner, name) != value:
                setattr(owner, name, value)
    return before
