# SPDX-License-Identifier: GPL-3.0-or-later
"""Transport on meshes: nine float colour attributes and the record of the bake that made them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np
import numpy.typing as npt

from ...core.layout import LAYERS, Space, packed
from ...core.problem import BakeSettings
from . import temporary_layer
from .meshes import Domain, layer_array
from .record import RECORD, Evidence, write_record

Transport = npt.NDArray[np.float32]
"""(receivers, 9) or (receivers, 9, 3)."""


def is_baked(mesh: bpy.types.Mesh) -> bool:
    """Whether a mesh carries a whole set of transport layers."""
    return all(name in mesh.attributes for name in LAYERS)


def write(
    mesh: bpy.types.Mesh,
    domain: Domain,
    transport: Transport,
    direct: Transport,
    element_receiver: npt.NDArray[np.int64],
    settings: BakeSettings,
    space: Space = "SCENE",
    evidence: Evidence | None = None,
    elements: tuple[int, int] | None = None,
) -> None:
    """Store transport as the mesh's nine layers, replacing earlier ones and leaving all other layers alone.

    Args:
        domain: POINT or CORNER.
        transport: (receivers, 9) or (receivers, 9, 3).
        direct: (receivers, 9) the part of it that no bounce brought.
        element_receiver: (vertices or corners,) the receiver each shows.
        settings: what the record keeps.
        space: whose axes the transport is in.
        evidence: what the bake depended on; without it nobody can tell later whether it still holds.
        elements: vertices and face corners of the mesh that people edit, if that is another one.
    """
    temporary_layer.take_back(mesh, (temporary_layer.TRANSPORT,))  # it would show transport that is no longer there
    colours = mesh.color_attributes
    active, rendered = colours.active_color_name, colours.default_color_name
    remove(mesh)
    for name in LAYERS:  # create all, then fetch each: on 5.0 and older, references go stale
        mesh.attributes.new(name, "FLOAT_COLOR", domain)
    for i, name in enumerate(LAYERS):
        rgba = packed(i, transport[:, i], direct[:, i], space)[element_receiver]
        mesh.attributes[name].data.foreach_set("color", rgba.reshape(-1))
    colours.active_color_name, colours.default_color_name = active, rendered
    write_record(mesh, domain, settings, space, evidence, elements or (len(mesh.vertices), len(mesh.loops)))
    mesh.update()


@dataclass(frozen=True)
class Snapshot:
    """The layers and the record of a mesh as they are, to put them back."""

    domain: Domain
    values: dict[str, npt.NDArray[np.float32]]
    record: Any

    @classmethod
    def of(cls, mesh: bpy.types.Mesh) -> Snapshot | None:
        """None of a mesh that is not baked."""
        if not is_baked(mesh):
            return None
        record = mesh.get(RECORD)
        values = {name: layer_array(mesh, name, "color", 4) for name in LAYERS}
        return cls(domain_of(mesh), values, record.to_dict() if hasattr(record, "to_dict") else record)

    def restore(self, mesh: bpy.types.Mesh) -> None:
        """Put them back, in place of what is there."""
        remove(mesh)
        for name in LAYERS:
            mesh.attributes.new(name, "FLOAT_COLOR", self.domain)
        for name, values in self.values.items():
            mesh.attributes[name].data.foreach_set("color", values.reshape(-1))
        if self.record is not None:
            mesh[RECORD] = self.record
        mesh.update()


def read(mesh: bpy.types.Mesh) -> npt.NDArray[np.float32]:
    """(elements of the layers' domain, 9, 3) float32 of a baked mesh, in the axes that `space_of` names."""
    return np.stack([layer_array(mesh, name, "color", 4)[:, :3] for name in LAYERS], axis=1)


def domain_of(mesh: bpy.types.Mesh) -> Domain:
    """Where the layers of a baked mesh lie: on its points or its corners."""
    return "POINT" if mesh.attributes[LAYERS[0]].domain == "POINT" else "CORNER"


def space_of(mesh: bpy.types.Mesh) -> Space:
    """Whose axes the transport of a baked mesh is in."""
    return "OBJECT" if mesh.get(RECORD, {}).get("space") == "OBJECT" else "SCENE"


def remove(mesh: bpy.types.Mesh) -> bool:
    """Remove the layers and the record; True if there was any."""
    present = [name for name in LAYERS if name in mesh.attributes]
    for name in present:
        while name in mesh.attributes:  # before 5.0, joining objects leaves one per domain
            mesh.attributes.remove(mesh.attributes[name])
    recorded = RECORD in mesh
    if recorded:
        del mesh[RECORD]
    return recorded or bool(present)
