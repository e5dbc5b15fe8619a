# SPDX-License-Identifier: GPL-3.0-or-later
"""Packs transport for the web: ten bits a number, in an order that compresses well."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ..layout import LAYERS, OWN_AXES_BELOW
from .glb import Glb

STEPS = 511
"""The largest whole number: nine bits and a sign. Of what a surface shows that leaves an error of about a thousandth."""

DIRECT_STEPS = 31
"""The same for the direct part, where it only dims what gloss shows of the sky."""

SUN_STEPS = 127
"""The same where suns of the sky are shown in place of it: as much as a byte holds."""

EXTRAS = "prt_relight"
"""Key in the extras of a primitive: `view`, where its packed transport lies; `scales`, by which numbers are multiplied, one
per layer; `space`, whose axes they are in; and, of what is glossy or lit by suns, `direct` and `directScale`, the same of the direct part."""


def pack_transport(glb: Glb, suns: bool) -> int:
    """Replace the layers of all meshes of a file by packed ones.

    Args:
        glb: the file.
        suns: whether suns of the sky are shown in place of their part of the direct transport.

    Returns:
        How many vertices have transport.
    """
    vertices = 0
    for mesh in glb.document.get("meshes", ()):
        for primitive in mesh["primitives"]:
            if LAYERS[0] in primitive["attributes"]:
                vertices += _pack(glb, primitive, suns)
    return vertices


def _pack(glb: Glb, primitive: dict[str, Any], suns: bool) -> int:
    layers = np.stack([glb.values(primitive["attributes"].pop(name)) for name in LAYERS], axis=1)
    numbers, scales = rounded(layers[..., :3].astype(np.float64))
    own_axes = bool(layers[0, 0, 3] < OWN_AXES_BELOW)
    extras = primitive.setdefault("extras", {})[EXTRAS] = {
        "view": glb.add_view(to_bytes(numbers)),
        "scales": scales.tolist(),
        "space": "OBJECT" if own_axes else "SCENE",
    }
    materials = glb.document.get("materials", ())
    if suns or ("material" in primitive and is_glossy(materials[primitive["material"]])):
        direct = layers[..., 3].astype(np.float64)
        direct[:, 0] += 2.0 if own_axes else 1.0  # its marks
        step = max(float(np.abs(direct).max(initial=0.0)), 1e-9) / (SUN_STEPS if suns else DIRECT_STEPS)
        extras["direct"], extras["directScale"] = glb.add_view(direct_to_bytes(np.rint(direct / step))), step
    return len(layers)


def is_glossy(material: dict[str, Any]) -> bool:
    """Whether a material of glTF mirrors anything."""
    surface, extensions = material.get("pbrMetallicRoughness"), material.get("extensions", {})
    if surface is None:
        return False
    specular = extensions.get("KHR_materials_specular", {}).get("specularFactor", 1.0)
    ior = extensions.get("KHR_materials_ior", {}).get("ior", 1.5)
    return bool(surface.get("metallicFactor", 1.0) > 0.0 or (specular > 0.0 and ior != 1.0))


def rounded(transport: npt.NDArray[np.float64]) -> tuple[npt.NDArray[np.int32], npt.NDArray[np.float64]]:
    """Transport (N, 9, 3) as whole numbers up to `STEPS`, and the scale of each layer (9,): their product is transport."""
    scales = np.abs(transport).max(axis=(0, 2), initial=0.0) / STEPS
    scales = np.where(scales > 0.0, scales, 1.0)
    return np.rint(transport / scales[:, None]).astype(np.int32), scales


def to_bytes(numbers: npt.NDArray[np.int32]) -> bytes:
    """Whole numbers (N, 9, 3) as bytes, the low ones of all numbers and then the high ones.

    Red and blue are kept as what they differ from green by, each number as what it differs by from that of the vertex
    before, the sign in the lowest bit: neighbours are alike, so that most bytes are small and most high ones 0.
    """
    coded = numbers.copy()
    coded[:, :, 0] -= numbers[:, :, 1]
    coded[:, :, 2] -= numbers[:, :, 1]
    steps = np.diff(coded.reshape(len(numbers), -1), axis=0, prepend=0).T
    signless = ((steps << 1) ^ (steps >> 31)).astype(np.uint16)
    return (signless & 255).astype(np.uint8).tobytes() + (signless >> 8).astype(np.uint8).tobytes()


def direct_to_bytes(numbers: npt.NDArray[np.float64]) -> bytes:
    """Whole numbers (N, 9) up to `SUN_STEPS`, a byte each: coefficient by coefficient, as what each vertex differs by from the
    one before, modulo 256."""
    steps = np.diff(numbers.astype(np.int16), axis=0, prepend=np.int16(0)).T
    return (steps & 255).astype(np.uint8).tobytes()
