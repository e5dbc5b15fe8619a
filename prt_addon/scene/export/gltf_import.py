# SPDX-License-Identifier: GPL-3.0-or-later
"""Brings a bake back when Blender imports the glTF file that it was exported with: it shades as it did.

Blender finds the class by its name in the extension's top module, and calls its hooks. Whatever is wrong with what concerns us,
the import goes on without it.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy

from ...core.errors import PRTError
from ...core.exchange.gltf_extras import EXTRAS, SceneLight, from_extras
from ...core.notices import counted
from ..mesh.record import FORMAT_VERSION
from ..shading.shading import add_shading
from .gltf_layers import take_over, widen
from .gltf_light import light_with


class glTF2ImportUserExtension:
    """One import, of one file or of several, one after the other."""

    def __init__(self) -> None:
        self._concerns_us = False
        self._light: SceneLight | None = None
        self._meshes: list[bpy.types.Mesh] = []

    def gather_import_gltf_before_hook(self, gltf: Any) -> None:
        """Read what the extras say, and have Blender read all layers."""
        self._concerns_us, self._light, self._meshes = False, None, []
        found = _taken(gltf)
        if found is None:
            return
        try:
            self._light = from_extras(found, FORMAT_VERSION)
            widen(gltf)
        except PRTError as error:
            _warn(gltf, f"'{_name(gltf)}' is imported without its bake: {error}.")
            return
        self._concerns_us = True

    def gather_import_mesh_after_hook(self, _pymesh: Any, mesh: bpy.types.Mesh, _gltf: Any) -> None:
        """Note that a mesh is baked."""
        if self._concerns_us and take_over(mesh):
            self._meshes.append(mesh)

    def gather_import_scene_after_animation_hook(self, _pyscene: Any, scene: bpy.types.Scene, gltf: Any) -> None:
        """Light the scene, and relight what is baked."""
        if not self._meshes:
            return
        try:
            if self._light:
                _inform(gltf, light_with(scene, self._light, _name(gltf)))
            objects = [ob for ob in bpy.data.objects if ob.type == "MESH" and ob.data in self._meshes]
            for one in counted(add_shading(objects, anew=False)):
                (_warn if one.kind.level == "WARNING" else _inform)(gltf, one.sentence)
        except PRTError as error:
            _warn(gltf, str(error))


def _taken(gltf: Any) -> Any:
    """What the extras of the scene that is shown hold of ours, taken out: Blender would keep it as a custom property."""
    scenes = gltf.data.scenes or []
    found = None
    for scene in ([scenes[gltf.data.scene]] if gltf.data.scene is not None else []) + scenes:
        if isinstance(scene.extras, dict) and EXTRAS in scene.extras:
            other = scene.extras.pop(EXTRAS)
            found = other if found is None else found
    return found


def _name(gltf: Any) -> str:
    return Path(gltf.filename).stem


def _warn(gltf: Any, sentence: str) -> None:
    gltf.log.warning(f"PRT Relight: {sentence}", popup=True)


def _inform(gltf: Any, sentence: str) -> None:
    gltf.log.info(f"PRT Relight: {sentence}", popup=True)
