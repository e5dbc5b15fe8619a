# SPDX-License-Identifier: GPL-3.0-or-later
"""What Blender's own glTF exporter writes of a bake: transport as float attributes, the light beside it, and the person's own
materials.

Left to itself the exporter writes the nine layers as vertex colours, clamped and in 16 bits, and loses the base colour and
the textures of relit materials, as it looks for them behind our output. Blender finds the class by its name in the
extension's top module, and calls its hooks.
"""

from __future__ import annotations

import weakref
from contextlib import ExitStack
from typing import Any

import bpy
import numpy as np
import numpy.typing as npt

from ...core.layout import LAYERS
from ...core.sphere import sh
from ..light.light import has_light, read_light, read_turn, strength_of
from ..mesh.carrier import carrier_of, transport_mesh
from ..mesh.layers import is_baked
from ..mesh.record import FORMAT_VERSION
from ..shading.shading import own_surfaces_active

EXTRAS = "prt_relight"
"""Key in the extras of a scene."""

VERSION = 1

_BASIS = "real, orthonormal, without the Condon-Shortley sign, i = l(l+1) + m, Z up"
_AXES = [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]
"""Blender's X, Y and Z in glTF's axes, which are Y up."""
_COMPONENTS: dict[int, tuple[type, float]] = {
    5121: (np.uint8, 255.0),
    5123: (np.uint16, 65535.0),
    5126: (np.float32, 1.0),
}
"""NumPy's types of glTF's numbers of components, and what stands for 1."""
_ROUNDING = 1.0 / 65535.0


class glTF2ExportUserExtension:
    """One export."""

    is_critical = False

    def __init__(self) -> None:
        self._undo = ExitStack()
        self._scenes_left = 0
        self._others_too = True
        self._concerns_us = False

    def pre_export_hook(self, settings: dict[str, Any]) -> None:
        """Have attributes written, and materials found behind the person's own outputs."""
        baked = [ob for ob in bpy.data.objects if ob.type == "MESH" and is_baked(transport_mesh(ob))]
        self._concerns_us = bool(baked)
        if not baked:
            return
        self._others_too = settings["gltf_attributes"]
        settings["gltf_attributes"] = True
        self._scenes_left = 1 if settings.get("gltf_active_scene") else len(bpy.data.scenes)
        self._undo.enter_context(own_surfaces_active())
        weakref.finalize(self, self._undo.close).atexit = False  # an export that fails calls no further hook
        carried = [ob.name for ob in baked if carrier_of(ob)]
        if carried and not settings["gltf_apply"]:
            names = ", ".join(f"'{name}'" for name in sorted(carried))
            settings["log"].warning(
                f"PRT Relight: the transport of {names} lies behind modifiers, and is not exported: turn on Data > Mesh > "
                "Apply Modifiers."
            )

    def gather_attribute_keep(self, attribute: Any, _settings: dict[str, Any]) -> None:
        """Of attributes that only we have turned on, ours alone."""
        if self._concerns_us and not self._others_too and attribute.attr_name not in LAYERS:
            attribute.keep = False

    def gather_mesh_hook(self, gltf_mesh: Any, mesh: bpy.types.Mesh, *_: Any) -> None:
        """Take our layers away from among the vertex colours."""
        if not self._concerns_us:
            return
        own = {colour.name for colour in mesh.color_attributes} - set(LAYERS)
        for primitive in gltf_mesh.primitives:
            if LAYERS[0] in primitive.attributes:
                _drop_colours(primitive.attributes, bool(own))

    def gather_scene_hook(self, gltf_scene: Any, scene: bpy.types.Scene, _settings: dict[str, Any]) -> None:
        """Write the light of the scene's world beside what it lights. With the last scene all materials are gathered."""
        if not self._concerns_us:
            return
        self._scenes_left -= 1
        if self._scenes_left <= 0:
            self._undo.close()  # before the file is written, which may fail
        gltf_scene.extras = {**(gltf_scene.extras or {}), EXTRAS: extras(scene)}

    def post_export_hook(self, _settings: dict[str, Any]) -> None:
        """Put the materials back."""
        self._undo.close()


def extras(scene: bpy.types.Scene) -> dict[str, Any]:
    """What another program needs to relight a scene; plain data, by the schema in docs/formats.md."""
    found: dict[str, Any] = {
        "version": VERSION,
        "layout": FORMAT_VERSION,
        "order": sh.ORDER,
        "basis": _BASIS,
        "axes": _AXES,
        "attributes": list(LAYERS),
    }
    if has_light(scene.world):
        found["light"] = read_light(scene.world).tolist()
        found["turn"] = read_turn(scene.world).T.tolist()  # the columns of R
        found["strength"] = strength_of(scene.world)
    return found


def _drop_colours(attributes: dict[str, Any], has_others: bool) -> None:
    """Remove vertex colours that hold our layers, and number the others anew; all of them if there are no others.

    They are known by what they hold: the exporter names no sources.
    """
    layers = [_values(attributes[name]) for name in LAYERS]
    colours = sorted((name for name in attributes if name.startswith("COLOR_")), key=lambda name: int(name[6:]))
    kept = []
    for name in colours:
        accessor = attributes.pop(name)
        values = _values(accessor)
        if has_others and not any(_same(values, layer) for layer in layers):
            kept.append(accessor)
    attributes.update({f"COLOR_{number}": accessor for number, accessor in enumerate(kept)})


def _values(accessor: Any) -> npt.NDArray[np.float64]:
    """(N, width) what an accessor holds; whole numbers stand for 0 to 1."""
    kind, most = _COMPONENTS[int(accessor.component_type)]
    values: npt.NDArray[Any] = np.frombuffer(accessor.buffer_view.data, dtype=kind).reshape(accessor.count, -1)
    return values.astype(np.float64) / most


def _same(colour: npt.NDArray[np.float64], layer: npt.NDArray[np.float64]) -> bool:
    """Whether a colour is a layer, clamped to 0..1 and rounded to 16 bits."""
    clamped = np.clip(layer[:, :3], 0.0, 1.0)
    return len(colour) == len(layer) and bool(np.abs(colour[:, :3] - clamped).max(initial=0.0) <= _ROUNDING)
