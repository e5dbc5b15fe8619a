# SPDX-License-Identifier: GPL-3.0-or-later
"""What Blender's own glTF exporter writes of a bake: transport as float attributes, the light beside it, and the person's own
materials.

Left to itself the exporter writes the nine layers as vertex colours, clamped and in 16 bits, and loses the base colour and
the textures of relit materials, as it looks for them behind our output. Blender finds the class by its name in the
extension's top module, and calls its hooks.
"""

from __future__ import annotations

import copy
import weakref
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from typing import Any

import bpy
import numpy as np
import numpy.typing as npt

from ...core.errors import PRTError
from ...core.layout import LAYERS, OWN_AXES_BELOW
from ...core.shown import shown
from ...core.sphere import sh
from ...core.sphere.rotation import rotation_matrix
from ..light.lamps import is_lamp_of_sky
from ..light.light import has_light, read_lamps, read_light, read_turn, shown_light, strength_of
from ..mesh.carrier import carrier_of, transport_mesh
from ..mesh.layers import is_baked
from ..mesh.meshes import own_axes
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
        self._with_transport = True
        self._concerns_us = False
        self._light: npt.NDArray[np.float64] | None = None
        self._shown_by: bpy.types.Object | None = None

    def pre_export_hook(self, settings: dict[str, Any]) -> None:
        """Have attributes written, and materials found behind the person's own outputs."""
        baked = [ob for ob in bpy.data.objects if ob.type == "MESH" and is_baked(transport_mesh(ob))]
        self._concerns_us = bool(baked)
        if not baked:
            return
        chosen = bpy.context.scene.prt.gltf
        self._with_transport = chosen.transport
        if chosen.light:
            self._light = _light_of_now(settings["log"])
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

    def gather_node_mesh_hook(self, _choice: Any, ob: bpy.types.Object | None, _settings: dict[str, Any]) -> None:
        """Remember whose mesh comes next: the mesh's own hook is not told."""
        self._shown_by = ob

    def gather_node_hook(self, node: Any, ob: bpy.types.Object | None, _settings: dict[str, Any]) -> None:
        """Put out lamps of the sky: they are in the light."""
        if ob and is_lamp_of_sky(ob) and node.extensions:
            node.extensions.pop("KHR_lights_punctual", None)

    def gather_mesh_hook(self, gltf_mesh: Any, mesh: bpy.types.Mesh, *others: Any) -> None:
        """Take our layers away from among the vertex colours, and put the light there if it is wanted."""
        if not self._concerns_us:
            return
        own = {colour.name for colour in mesh.color_attributes} - set(LAYERS)
        for primitive in gltf_mesh.primitives:
            if LAYERS[0] in primitive.attributes:
                _drop_colours(primitive.attributes, bool(own))
                if self._light is not None and self._shown_by:
                    _put_light_first(primitive.attributes, self._light, self._shown_by, others[-1]["log"])
                if not self._with_transport:
                    for name in LAYERS:
                        del primitive.attributes[name]

    def gather_scene_hook(self, gltf_scene: Any, scene: bpy.types.Scene, _settings: dict[str, Any]) -> None:
        """Write the light of the scene's world beside what it lights. With the last scene all materials are gathered."""
        if not self._concerns_us:
            return
        self._scenes_left -= 1
        if self._scenes_left <= 0:
            self._undo.close()  # before the file is written, which may fail
        if self._with_transport:
            gltf_scene.extras = {**(gltf_scene.extras or {}), EXTRAS: extras(scene)}

    def post_export_hook(self, _settings: dict[str, Any]) -> None:
        """Put the materials back."""
        self._undo.close()


@contextmanager
def with_transport(scene: bpy.types.Scene) -> Iterator[None]:
    """Inside, exports hold transport and no light as vertex colours, whatever the person has chosen for exports as glTF."""
    chosen = scene.prt.gltf
    before = chosen.transport, chosen.light
    chosen.transport, chosen.light = True, False
    try:
        yield
    finally:
        chosen.transport, chosen.light = before


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
        found["lamps"] = read_lamps(scene.world).tolist()
        found["turn"] = read_turn(scene.world).T.tolist()  # the columns of R
        found["strength"] = strength_of(scene.world)
    return found


def _light_of_now(log: Any) -> npt.NDArray[np.float64] | None:
    """(9, 3) as the world's nodes turn and scale it; None, and a word to the log, if there is none."""
    world = bpy.context.scene.world
    if not has_light(world):
        log.warning(
            "PRT Relight: the scene's world carries no light to export: press Project World (prt.project_light)."
        )
        return None
    try:
        return shown_light(world)
    except PRTError as error:
        log.warning(f"PRT Relight: {error}")
        return None


def _put_light_first(
    attributes: dict[str, Any], light: npt.NDArray[np.float64], ob: bpy.types.Object, log: Any
) -> None:
    """What a white surface shows, as COLOR_0, in 0 to 1 as glTF demands of it; other colours follow."""
    layers = np.stack([_values(attributes[name]) for name in LAYERS], axis=1)
    if layers[0, 0, 3] < OWN_AXES_BELOW:
        light = rotation_matrix(own_axes(ob.matrix_world).T) @ light
        if ob.data.users > 1:
            log.warning(
                f"PRT Relight: the objects that share the mesh of '{ob.name}' all get its light: make them single users."
            )
    colours = shown(layers[..., :3], light)
    bright = float((colours.max(axis=1) > 1.0).mean())
    if bright > 0.0:
        log.warning(
            f"PRT Relight: the light of '{ob.name}' is cut off at 1 in {bright:.0%} of its vertices: lower the world's strength."
        )
    rgba = np.ones((len(colours), 4), dtype=np.float32)
    rgba[:, :3] = np.minimum(colours, 1.0)
    accessor = copy.copy(attributes[LAYERS[0]])  # four floats a vertex, too
    accessor.buffer_view = copy.copy(accessor.buffer_view)
    accessor.buffer_view.data = rgba.tobytes()
    others = [attributes.pop(name) for name in sorted(name for name in attributes if name.startswith("COLOR_"))]
    if others and (_values(others[0]) == 1.0).all():
        del others[0]  # the exporter's own, so that viewers do not multiply with unused paint
    attributes.update({f"COLOR_{number}": each for number, each in enumerate([accessor, *others])})


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
