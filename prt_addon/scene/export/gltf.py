# SPDX-License-Identifier: GPL-3.0-or-later
"""Adds a bake to what Blender's glTF exporter writes: transport as float attributes, the light, and the user's own
materials.

Left to itself the exporter writes the nine layers as vertex colours, clamped and in 16 bits, and loses the base colour and
the textures of relit materials, as it looks for them behind our output. Blender finds the class by its name in the
extension's top module, and calls its hooks.
"""

from __future__ import annotations

import weakref
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from typing import Any

import bpy
import numpy as np
import numpy.typing as npt
from mathutils import Matrix

from ...core.errors import PRTError
from ...core.exchange import gltf_extras
from ...core.exchange.gltf_extras import EXTRAS, Y_UP, SceneLight
from ...core.layout import BACKS, LAYERS
from ...core.sphere.rotation import rotation_matrix
from ..light.lamps import is_lamp_of_sky, read_lamps_of
from ..light.light import has_light, read_lamps, read_light, read_turn, shown_light, strength_of
from ..mesh.carrier import carrier_of, transport_mesh
from ..mesh.layers import is_baked
from ..mesh.meshes import own_axes
from ..mesh.record import FORMAT_VERSION
from ..shading.own_surfaces import own_surfaces_active
from .gltf_meshes import Writer, drop_colours, has_layers, in_own_axes
from .gltf_nodes import placed

_CHOICES = ("transport", "precision", "light")


class glTF2ExportUserExtension:
    """One export."""

    is_critical = False

    def __init__(self) -> None:
        self._undo = ExitStack()
        self._scenes_left = 0
        self._others_too = True
        self._concerns_us = False
        self._shows_light = False
        self._writer = Writer(transport=True, rounds=False)

    def pre_export_hook(self, settings: dict[str, Any]) -> None:
        """Have attributes written, and materials found behind the user's own outputs."""
        baked = [ob for ob in bpy.data.objects if ob.type == "MESH" and is_baked(transport_mesh(ob))]
        self._concerns_us = bool(baked)
        if not baked:
            return
        chosen = bpy.context.scene.prt.gltf
        self._writer = Writer(chosen.transport, chosen.precision == "SHORT")
        self._shows_light = chosen.light
        self._others_too = settings["gltf_attributes"]
        settings["gltf_attributes"] = True
        self._scenes_left = 1 if settings.get("gltf_active_scene") else len(bpy.data.scenes)
        self._undo.enter_context(own_surfaces_active())
        weakref.finalize(self, self._undo.close).atexit = False  # an export that fails calls no further hook
        carried = [ob.name for ob in baked if carrier_of(ob)]
        if carried and not settings["gltf_apply"]:
            names = ", ".join(f"'{name}'" for name in sorted(carried))
            _warn(
                settings,
                f"the transport of {names} lies behind modifiers, and is not exported: turn on Data > Mesh > Apply Modifiers.",
            )

    def gather_attribute_keep(self, attribute: Any, _settings: dict[str, Any]) -> None:
        """Of attributes that only we have turned on, ours alone."""
        if self._concerns_us and not self._others_too and attribute.attr_name not in LAYERS + BACKS:
            attribute.keep = False

    def gather_node_hook(self, node: Any, ob: bpy.types.Object | None, _settings: dict[str, Any]) -> None:
        """Put out lamps of the sky: they are in the light."""
        if ob and is_lamp_of_sky(ob) and node.extensions:
            node.extensions.pop("KHR_lights_punctual", None)

    def gather_mesh_hook(self, gltf_mesh: Any, mesh: bpy.types.Mesh, *_others: Any) -> None:
        """Take our layers away from among the vertex colours."""
        if not self._concerns_us:
            return
        painted = {colour.name for colour in mesh.color_attributes} - {*LAYERS, *BACKS}
        for primitive in gltf_mesh.primitives:
            if LAYERS[0] in primitive.attributes:
                drop_colours(primitive.attributes, bool(painted))

    def gather_scene_hook(self, gltf_scene: Any, scene: bpy.types.Scene, settings: dict[str, Any]) -> None:
        """Write the light of the scene's world, and what of the meshes is wanted. With the last scene all materials are gathered."""
        if not self._concerns_us:
            return
        self._scenes_left -= 1
        if self._scenes_left <= 0:
            self._undo.close()  # before the file is written, which may fail
        axes = Y_UP if settings.get("gltf_yup", True) else np.eye(3)
        light = _light_of_now(scene, settings) if self._shows_light else None
        for node, matrix in placed(gltf_scene.nodes):
            if node.mesh and has_layers(node.mesh):
                node.mesh = self._writer.written(node.mesh, _seen(light, node, matrix, axes, settings))
        if self._writer.transport:
            gltf_scene.extras = {**(gltf_scene.extras or {}), EXTRAS: extras(scene, axes)}
        if self._scenes_left <= 0:
            self._say(settings)

    def _say(self, settings: dict[str, Any]) -> None:
        """What differs from Blender's numbers."""
        for name, share in self._writer.cut_off.items():
            _warn(
                settings,
                f"the light of '{name}' is cut off at 1 in {share:.0%} of its vertices: lower the world's strength.",
            )
        if self._writer.whole > 0.0:
            error = np.sqrt(self._writer.error / self._writer.whole)
            settings["log"].info(
                f"PRT Relight: 16 bits a number change the transport by {error:.4%} (relative RMS).", popup=True
            )

    def post_export_hook(self, _settings: dict[str, Any]) -> None:
        """Put the materials back."""
        self._undo.close()


@contextmanager
def with_transport(scene: bpy.types.Scene) -> Iterator[None]:
    """Inside, exports hold transport as floats and no light as vertex colours, whatever the user has chosen for exports as glTF."""
    chosen = scene.prt.gltf
    before = [getattr(chosen, name) for name in _CHOICES]
    chosen.transport, chosen.precision, chosen.light = True, "FLOAT", False
    try:
        yield
    finally:
        for name, value in zip(_CHOICES, before, strict=True):
            setattr(chosen, name, value)


def extras(scene: bpy.types.Scene, axes: npt.NDArray[np.float64]) -> dict[str, Any]:
    """What another program needs to relight a scene; plain data, by the schema in docs/formats.md.

    Args:
        scene: whose world carries the light.
        axes: (3, 3) rows, Blender's axes in those of the file.
    """
    light = light_of(scene.world) if has_light(scene.world) else None
    return gltf_extras.to_extras(FORMAT_VERSION, axes, light)


def light_of(world: bpy.types.World) -> SceneLight:
    """All that a world which carries a light says of it."""
    return SceneLight(read_light(world), read_lamps(world), read_lamps_of(world), read_turn(world), strength_of(world))


def _light_of_now(scene: bpy.types.Scene, settings: dict[str, Any]) -> npt.NDArray[np.float64] | None:
    """(9, 3) as the nodes of a scene's world turn and scale it; None, and a word to the log, if there is none."""
    if not has_light(scene.world):
        _warn(settings, "the scene's world carries no light to export: press Project World (prt.project_light).")
        return None
    try:
        return shown_light(scene.world)
    except PRTError as error:
        _warn(settings, str(error))
        return None


def _seen(
    light: npt.NDArray[np.float64] | None,
    node: Any,
    matrix: Matrix,
    axes: npt.NDArray[np.float64],
    settings: dict[str, Any],
) -> npt.NDArray[np.float64] | None:
    """A light in the axes of the transport that a node shows; None, and a word to the log, where these are not known."""
    if light is None or not in_own_axes(node.mesh):
        return light
    if node.skin:
        _warn(
            settings,
            f"'{node.name}' has no light as vertex colors: its transport is in the axes of the object, which skinned meshes of "
            "glTF do not keep. Bake it for the scene.",
        )
        return None
    turn = own_axes(axes @ np.array(matrix)[:3, :3] @ axes.T)
    if not np.isfinite(turn).all():
        _warn(settings, f"'{node.name}' has no light as vertex colors: it is scaled to nothing.")
        return None
    return rotation_matrix(turn.T) @ light


def _warn(settings: dict[str, Any], sentence: str) -> None:
    """Say something on the console and in the operator's report."""
    settings["log"].warning(f"PRT Relight: {sentence}", popup=True)
