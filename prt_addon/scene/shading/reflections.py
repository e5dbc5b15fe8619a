# SPDX-License-Identifier: GPL-3.0-or-later
"""Sets up EEVEE's own ray tracing so that gloss mirrors relit surfaces, and sets it back.

Its *Fast GI* is kept to ambient occlusion: by itself it would light surfaces once more by what their bake holds already.
"""

from __future__ import annotations

import bpy

_WANTED = {
    "use_raytracing": True,
    "ray_tracing_method": "SCREEN",
    "ray_tracing_options.trace_max_roughness": 1.0,
    "use_fast_gi": True,
    "fast_gi_method": "AMBIENT_OCCLUSION_ONLY",
}
"""EEVEE's settings of a scene. Gloss of any roughness is traced: while it is, nothing else dims what the scene hides."""
_BEFORE = "prt_before_reflections"
"""Custom property of a scene: what those that were changed had been, by their names."""


def are_on(scene: bpy.types.Scene) -> bool:
    """Whether there is something to set back."""
    return _BEFORE in scene


def switch_on(scene: bpy.types.Scene) -> bool:
    """Set EEVEE's ray tracing; False if it was set like that already."""
    before = {path: now for path, value in _WANTED.items() if (now := _value(scene, path)) != value}
    if before:
        scene[_BEFORE] = before | dict(scene.get(_BEFORE, {}))
    for path in before:
        _set(scene, path, _WANTED[path])
    return bool(before)


def switch_off(scene: bpy.types.Scene) -> bool:
    """Set back what `switch_on` changed, but for what someone has changed since; False if there is nothing to set back."""
    if not are_on(scene):
        return False
    for path, value in dict(scene[_BEFORE]).items():
        if _value(scene, path) == _WANTED[path]:
            _set(scene, path, value)
    del scene[_BEFORE]
    return True


def _value(scene: bpy.types.Scene, path: str) -> object:
    return scene.eevee.path_resolve(path)


def _set(scene: bpy.types.Scene, path: str, value: object) -> None:
    owner, _, name = path.rpartition(".")
    setattr(scene.eevee.path_resolve(owner) if owner else scene.eevee, name, value)
