# SPDX-License-Identifier: GPL-3.0-or-later
"""EEVEE's own ray tracing, set so that gloss mirrors relit surfaces; and set back.

Its *Fast GI* is kept to ambient occlusion: by itself it would light surfaces once more by what their bake holds already.
"""

from __future__ import annotations

import bpy

_WANTED = {
    "use_raytracing": True,
    "ray_tracing_method": "SCREEN",
    "use_fast_gi": True,
    "fast_gi_method": "AMBIENT_OCCLUSION_ONLY",
}
"""EEVEE's settings of a scene."""
_BEFORE = "prt_before_reflections"
"""Custom property of a scene: what those that were changed had been, by their names."""


def are_on(scene: bpy.types.Scene) -> bool:
    """Whether there is something to set back."""
    return _BEFORE in scene


def switch_on(scene: bpy.types.Scene) -> bool:
    """Set EEVEE's ray tracing; False if it was set like that already."""
    eevee = scene.eevee
    before = {name: getattr(eevee, name) for name, value in _WANTED.items() if getattr(eevee, name) != value}
    if before:
        scene[_BEFORE] = before | dict(scene.get(_BEFORE, {}))
    for name in before:
        setattr(eevee, name, _WANTED[name])
    return bool(before)


def switch_off(scene: bpy.types.Scene) -> bool:
    """Set back what `switch_on` changed, but for what someone has changed since; False if there is nothing to set back."""
    if not are_on(scene):
        return False
    for name, value in dict(scene[_BEFORE]).items():
        if getattr(scene.eevee, name) == _WANTED[name]:
            setattr(scene.eevee, name, value)
    del scene[_BEFORE]
    return True
