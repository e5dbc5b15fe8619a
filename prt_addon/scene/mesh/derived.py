# SPDX-License-Identifier: GPL-3.0-or-later
"""Identifies a mesh that modifiers make of another: by what they make it from, and roughly by what comes out.

Some modifiers give other last bits at each evaluation (4.5's Bevel under a Subdivision: 5e-7), so that digests of positions
would call a bake stale at once, and shards of two processes would not fit together. Known instead are the original, the
settings of the modifiers, the faces that come out, and where they lie as a few sums over all vertices show: these
notice what comes from other objects, through modifiers or drivers.
"""

from __future__ import annotations

from collections.abc import Iterator

import bpy
import numpy as np
import numpy.typing as npt

from ..blender.rna import plain, settings_of
from .carrier_group import is_carrier_group
from .meshes import corner_vertices, face_starts, layer_array

_LOOKS = {"name", "show_expanded", "show_in_editmode", "show_on_cage", "show_viewport", "is_active", "use_pin_to_last",
          "execution_time", "persistent_uid", "open_output_attributes_panel", "open_manage_panel",
          "open_bake_panel", "open_named_attributes_panel", "open_warnings_panel", "node_warnings", "panels"}  # fmt: skip
"""Settings of modifiers that change no mesh, or report how it went."""

_STEPS = 1e-4  # sums are known to that share of the mesh's size
_GOLDEN = 0.6180339887


def derived_sources(ob: bpy.types.Object, evaluated: bpy.types.Mesh) -> Iterator[bytes | npt.NDArray[np.generic]]:
    """Collect what identifies the evaluated mesh of an original object, to make a digest of."""
    yield layer_array(ob.data, "position", "vector", 3)
    yield corner_vertices(ob.data)
    yield face_starts(ob.data)
    for modifier in ob.modifiers:
        group = getattr(modifier, "node_group", None)
        if modifier.show_render and not is_carrier_group(group):
            yield repr([modifier.type, dict(settings_of(modifier, _LOOKS)), list(_inputs(modifier))]).encode()
            if group:
                yield repr(list(_nodes(group))).encode()
    yield corner_vertices(evaluated)
    yield face_starts(evaluated)
    yield _sums(layer_array(evaluated, "position", "vector", 3).astype(np.float64))


def _inputs(modifier: bpy.types.Modifier) -> Iterator[tuple[str, object]]:
    """What a node modifier is given: before 5.2 these are custom properties."""
    if modifier.type != "NODES" or "properties" in modifier.bl_rna.properties:
        return
    for name, value in modifier.items():
        yield (
            name,
            value.name if isinstance(value, bpy.types.ID) else plain(getattr(value, "to_list", lambda v=value: v)()),
        )


def _nodes(tree: bpy.types.NodeTree) -> Iterator[object]:
    for node in tree.nodes:
        values = [plain(socket.default_value) for socket in node.inputs if _holds_plain_value(socket)]
        yield node.bl_idname, node.mute, values
        if inner := getattr(node, "node_tree", None):
            yield from _nodes(inner)


def _holds_plain_value(socket: bpy.types.NodeSocket) -> bool:
    value = getattr(socket, "default_value", None)
    return value is not None and not isinstance(value, bpy.types.ID)


def _sums(positions: npt.NDArray[np.float64]) -> npt.NDArray[np.int64]:
    """First and second moments, and sums with weights that differ from vertex to vertex, in steps of the mesh's size."""
    if not len(positions):
        return np.zeros(0, dtype=np.int64)
    centre = positions.mean(axis=0)
    size = float(np.abs(positions - centre).max()) or 1.0
    near = (positions - centre) / size
    weights = np.cos(2.0 * np.pi * _GOLDEN * np.arange(len(near)))
    parts = [centre / size, (near**2).mean(axis=0), (near * weights[:, None]).mean(axis=0), [np.log(size)]]
    return np.rint(np.concatenate(parts) / _STEPS).astype(np.int64)
