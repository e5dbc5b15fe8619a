# SPDX-License-Identifier: GPL-3.0-or-later
"""Stores transport on meshes: nine float colour attributes, and the record of the bake that made them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np
import numpy.typing as npt

from ...core.layout import BACKS, LAYERS, Space, packed, unpacked_backs
from ...core.problem import BakeSettings
from . import temporary_layer
from .meshes import Domain, layer_array
from .record import RECORD, Evidence, write_record

Transport = npt.NDArray[np.float32]
"""(receivers, 9) or (receivers, 9, 3)."""


def is_baked(mesh: bpy.types.Mesh) -> bool:
    """Whether a mesh carries a whole set of transport layers."""
    return all(name in mesh.attributes for name in LAYERS)


def has_backs(mesh: bpy.types.Mesh) -> bool:
    """Whether a mesh carries transport of its backs."""
    return all(name in mesh.attributes for name in BACKS)


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
    preview_of: int = 0,
    backs: Transport | None = None,
) -> None:
    """Store transport as the mesh's nine layers, replacing earlier ones and leaving all other layers alone.

    Args:
        mesh: that shows the transport.
        domain: POINT or CORNER.
        transport: (receivers, 9) or (receivers, 9, 3).
        direct: (receivers, 9) the part of it that no bounce brought.
        element_receiver: (vertices or corners,) the receiver each shows.
        settings: what the record keeps.
        space: whose axes the transport is in.
        evidence: what the bake depended on; without it no check can find later whether it still holds.
        elements: vertices and face corners of the mesh that people edit, if that is another one.
        preview_of: rays per receiver of the bake that this is a preview of; 0 if it is none.
        backs: (receivers, 3, 4) the floats of their layers (`core.layout.packed_backs`); None if there are none.
    """
    temporary_layer.take_back(mesh, (temporary_layer.TRANSPORT,))  # it would show transport that is no longer there
    colours = mesh.color_attributes
    active, rendered = colours.active_color_name, colours.default_color_name
    remove(mesh)
    for name in LAYERS if backs is None else LAYERS + BACKS:  # all before any is fetched: on 5.0 references go stale
        mesh.attributes.new(name, "FLOAT_COLOR", domain)
    for name, rgba in _values(transport, direct, space, backs):
        mesh.attributes[name].data.foreach_set("color", rgba[element_receiver].reshape(-1))
    colours.active_color_name, colours.default_color_name = active, rendered
    elements = elements or (len(mesh.vertices), len(mesh.loops))
    write_record(mesh, domain, settings, space, evidence, elements, preview_of)
    mesh.update()


def _values(
    transport: Transport, direct: Transport, space: Space, backs: Transport | None
) -> Iterator[tuple[str, Transport]]:
    """Each layer's name and its floats, (receivers, 4): one at a time, as all together are large."""
    for i, name in enumerate(LAYERS):
        yield name, packed(i, transport[:, i], direct[:, i], space)
    if backs is not None:
        yield from zip(BACKS, backs.transpose(1, 0, 2), strict=True)


@dataclass(frozen=True)
class Snapshot:
    """The layers and the record of a mesh as they are, to put them back; no values if there are none.

    colours: names of the active colour layer and of the one that renders.
    """

    domain: Domain
    values: dict[str, npt.NDArray[np.float32]]
    record: Any
    colours: tuple[str, str]

    @classmethod
    def of(cls, mesh: bpy.types.Mesh) -> Snapshot:
        """Take the snapshot of a mesh as it is."""
        record, colours = mesh.get(RECORD), mesh.color_attributes
        names = LAYERS + BACKS if has_backs(mesh) else LAYERS
        values = {name: layer_array(mesh, name, "color", 4) for name in names} if is_baked(mesh) else {}
        return cls(
            domain_of(mesh) if values else "POINT",
            values,
            record.to_dict() if hasattr(record, "to_dict") else record,
            (colours.active_color_name, colours.default_color_name),
        )

    def restore(self, mesh: bpy.types.Mesh) -> bool:
        """Put them back, in place of what is there; False if the mesh has other elements by now, and they are gone."""
        remove(mesh)
        fits = all(len(values) == _size(mesh, self.domain) for values in self.values.values())
        for name in self.values if fits else ():
            mesh.attributes.new(name, "FLOAT_COLOR", self.domain)
        for name, values in self.values.items() if fits else ():
            mesh.attributes[name].data.foreach_set("color", values.reshape(-1))
        if fits and self.record is not None:
            mesh[RECORD] = self.record
        mesh.color_attributes.active_color_name, mesh.color_attributes.default_color_name = self.colours
        mesh.update()
        return fits


def _size(mesh: bpy.types.Mesh, domain: Domain) -> int:
    """How many elements of a domain a mesh has."""
    return len(mesh.vertices if domain == "POINT" else mesh.loops)


def read(mesh: bpy.types.Mesh) -> npt.NDArray[np.float32]:
    """Read the transport of a baked mesh: (elements of its domain, 9, 3) float32, in the axes that `space_of` names."""
    return np.stack([layer_array(mesh, name, "color", 4)[:, :3] for name in LAYERS], axis=1)


def read_backs(mesh: bpy.types.Mesh) -> npt.NDArray[np.float32]:
    """Read the transport of a baked mesh's backs: (elements of its domain, 9, 3) float32."""
    return unpacked_backs(np.stack([layer_array(mesh, name, "color", 4) for name in BACKS], axis=1))


def domain_of(mesh: bpy.types.Mesh) -> Domain:
    """The domain of a baked mesh's layers: its points or its corners."""
    return "POINT" if mesh.attributes[LAYERS[0]].domain == "POINT" else "CORNER"


def space_of(mesh: bpy.types.Mesh) -> Space:
    """Whose axes the transport of a baked mesh is in: the scene's or the object's."""
    return "OBJECT" if mesh.get(RECORD, {}).get("space") == "OBJECT" else "SCENE"


def remove(mesh: bpy.types.Mesh) -> bool:
    """Remove the layers and the record; True if there was any."""
    present = [name for name in LAYERS + BACKS if name in mesh.attributes]
    for name in present:
        while name in mesh.attributes:  # before 5.0, joining objects leaves one per domain
            mesh.attributes.remove(mesh.attributes[name])
    recorded = RECORD in mesh
    if recorded:
        del mesh[RECORD]
    return recorded or bool(present)
