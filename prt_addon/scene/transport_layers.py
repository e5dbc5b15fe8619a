# SPDX-License-Identifier: GPL-3.0-or-later
"""Transport on meshes: nine float colour attributes and the record of the bake that made them."""

from __future__ import annotations

from dataclasses import asdict

import bpy
import numpy as np
import numpy.typing as npt

from ..core import sh
from ..core.bake import BakeSettings
from .meshes import Domain

FORMAT_VERSION = 1
LAYERS = tuple(f"_PRT_{i}" for i in range(sh.coefficient_count(sh.ORDER)))
"""The leading underscore lets glTF carry them."""
RECORD = "prt_bake"

BAKED_ALPHA = 0.0
"""Alpha of the layers. A mesh without the layer reads alpha 1 in a shader, which is how one material can serve
baked and unbaked objects."""


def is_baked(mesh: bpy.types.Mesh) -> bool:
    """Whether a mesh carries a whole set of transport layers."""
    return all(name in mesh.attributes for name in LAYERS)


def write(
    mesh: bpy.types.Mesh,
    domain: Domain,
    transport: npt.NDArray[np.float32],
    element_receiver: npt.NDArray[np.int64],
    settings: BakeSettings,
) -> None:
    """Store transport as the mesh's nine layers, replacing earlier ones and leaving all other layers alone.

    Args:
        domain: POINT or CORNER.
        transport: (receivers, 9) or (receivers, 9, 3).
        element_receiver: (vertices or corners,) the receiver each shows.
        settings: what the record keeps.
    """
    colours = mesh.color_attributes
    active, rendered = colours.active_color_name, colours.default_color_name
    remove(mesh)
    for name in LAYERS:  # create all, then fetch each: on 5.0 and older, references go stale
        mesh.attributes.new(name, "FLOAT_COLOR", domain)
    rgba = np.full((len(element_receiver), 4), BAKED_ALPHA, dtype=np.float32)
    for i, name in enumerate(LAYERS):
        coefficient = transport[:, i]
        rgba[:, :3] = (coefficient if coefficient.ndim == 2 else coefficient[:, None])[element_receiver]
        mesh.attributes[name].data.foreach_set("color", rgba.reshape(-1))
    colours.active_color_name, colours.default_color_name = active, rendered
    mesh[RECORD] = {"version": FORMAT_VERSION, "order": sh.ORDER, "domain": domain, **asdict(settings)}
    mesh.update()


def read(mesh: bpy.types.Mesh) -> npt.NDArray[np.float32]:
    """(elements of the layers' domain, 9, 3) float32 of a baked mesh."""
    layers = []
    for name in LAYERS:
        data = mesh.attributes[name].data
        rgba = np.empty(len(data) * 4, dtype=np.float32)
        data.foreach_get("color", rgba)
        layers.append(rgba.reshape(-1, 4)[:, :3])
    return np.stack(layers, axis=1)


def remove(mesh: bpy.types.Mesh) -> bool:
    """Remove the layers and the record; True if there was any."""
    present = [name for name in LAYERS if name in mesh.attributes]
    for name in present:
        mesh.attributes.remove(mesh.attributes[name])
    recorded = RECORD in mesh
    if recorded:
        del mesh[RECORD]
    return recorded or bool(present)
