# SPDX-License-Identifier: GPL-3.0-or-later
"""Takes layers of transport out of a glTF file that Blender is about to import, and puts them onto the meshes that it makes."""

from __future__ import annotations

import copy
from typing import Any

import bpy
import numpy as np
import numpy.typing as npt

from ...core.errors import PRTError
from ...core.exchange import shorts
from ...core.exchange.gltf_extras import EXTRAS, SCALES
from ...core.layout import BACKS, BAKED_BELOW, LAYERS, OWN_AXES_BELOW
from ...core.problem import BakeSettings
from ..mesh.layers import has_backs, is_baked
from ..mesh.meshes import layer_array
from ..mesh.record import write_record

_FLOAT = 5126


def widen(gltf: Any) -> None:
    """Have layers of 16 bits be floats before Blender looks for them: it would leave them out.

    Raises:
        PRTError: if their scales are not what is written.
    """
    for mesh in gltf.data.meshes or ():
        for primitive in mesh.primitives:
            extras = primitive.extras if isinstance(primitive.extras, dict) else {}
            for key, names in SCALES.items() if EXTRAS in extras else ():
                if all(name in primitive.attributes for name in names):
                    _widen(gltf, primitive, names, _scales(extras[EXTRAS], key, mesh.name))


def _widen(gltf: Any, primitive: Any, names: tuple[str, ...], scales: npt.NDArray[np.float64]) -> None:
    layers = np.stack([_decoded(gltf, primitive.attributes[name]) for name in names], axis=1)
    floats = shorts.restored(layers, scales)
    for i, name in enumerate(names):
        primitive.attributes[name] = _added(gltf, primitive.attributes[name], floats[:, i])


def _scales(extras: Any, key: str, mesh: str | None) -> npt.NDArray[np.float64]:
    count = len(SCALES[key])
    try:
        found = np.array(extras[key], dtype=np.float64)
    except (KeyError, TypeError, ValueError):
        found = np.zeros(0)
    if found.shape != (count, 2) or not np.isfinite(found).all():
        raise PRTError(f"the '{key}' of mesh '{mesh}' are missing, or not {count} pairs of numbers")
    return found


def _decoded(gltf: Any, index: int) -> npt.NDArray[np.float32]:
    """(N, 4) what an accessor holds, normalised ones in -1 to 1."""
    from io_scene_gltf2.io.imp.gltf2_io_binary import BinaryData  # the importer calls us: it is there

    found: npt.NDArray[np.float32] = BinaryData.decode_accessor_obj(gltf, gltf.data.accessors[index])
    return found


def _added(gltf: Any, like: int, values: npt.NDArray[np.float32]) -> int:
    """Index of a new accessor of floats (N, 4), in a buffer of its own."""
    accessor = copy.copy(gltf.data.accessors[like])
    view = copy.copy(gltf.data.buffer_views[accessor.buffer_view])
    buffer = max([len(gltf.data.buffers or ()) - 1, *gltf.buffers]) + 1
    gltf.buffers[buffer] = values.tobytes()
    view.buffer, view.byte_offset, view.byte_length, view.byte_stride = buffer, 0, values.nbytes, None
    gltf.data.buffer_views.append(view)
    accessor.buffer_view, accessor.byte_offset = len(gltf.data.buffer_views) - 1, None
    accessor.component_type, accessor.normalized, accessor.sparse = _FLOAT, None, None
    gltf.data.accessors.append(accessor)
    return len(gltf.data.accessors) - 1


def take_over(mesh: bpy.types.Mesh) -> bool:
    """Make a mesh that was imported a baked one, if it has layers; True then. What its bake depended on is unknown."""
    if not is_baked(mesh) or not _are_floats(mesh, LAYERS):
        return False
    marks = layer_array(mesh, LAYERS[0], "color", 4)[:, 3]
    if not (marks < BAKED_BELOW).any():
        return False
    if not has_backs(mesh) or not _are_floats(mesh, BACKS):
        _remove(mesh, BACKS)
    colours = mesh.color_attributes
    if colours.active_color_name in LAYERS + BACKS:
        colours.active_color_name = ""
    if colours.default_color_name in LAYERS + BACKS:
        colours.default_color_name = ""
    space = "OBJECT" if marks.min() < OWN_AXES_BELOW else "SCENE"
    elements = (len(mesh.vertices), len(mesh.loops))
    write_record(
        mesh, mesh.attributes[LAYERS[0]].domain, BakeSettings(mode="SHADOWED", samples=0), space, None, elements
    )
    return True


def _are_floats(mesh: bpy.types.Mesh, names: tuple[str, ...]) -> bool:
    return all(mesh.attributes[name].data_type == "FLOAT_COLOR" for name in names)


def _remove(mesh: bpy.types.Mesh, names: tuple[str, ...]) -> None:
    """Remove what of some layers is there: a part of them would be taken for something else."""
    for name in names:
        if name in mesh.attributes:
            mesh.attributes.remove(mesh.attributes[name])
