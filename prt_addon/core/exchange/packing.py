# SPDX-License-Identifier: GPL-3.0-or-later
"""Packs transport for the web: nine bits a number, in an order that compresses well."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ..layout import LAYERS, OWN_AXES_BELOW
from .glb import Glb

STEPS = 255
"""The largest whole number: eight bits and a sign. Of what a surface shows that leaves an error of two or three thousandths."""

EXTRAS = "prt_relight"
"""Key in the extras of a primitive: `view`, where its packed transport lies; `scale`, by which numbers are multiplied; `tints`, how red
and blue are foretold; `space`, whose axes they are in; `direct`, whether the direct part is told apart, as of what is glossy or lit by suns."""

_ONE = 256
"""What stands for 1 in tints."""

_MOST_TINT = 8 * _ONE
"""Beyond it a hue is so pure that green foretells nothing, and numbers would leave two bytes."""


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
    layers = np.stack([glb.values(primitive["attributes"].pop(name)) for name in LAYERS], axis=1).astype(np.float64)
    own_axes = bool(layers[0, 0, 3] < OWN_AXES_BELOW)
    materials = glb.document.get("materials", ())
    direct = suns or ("material" in primitive and is_glossy(materials[primitive["material"]]))
    layers[:, 0, 3] += 2.0 if own_axes else 1.0  # its marks
    numbers, scale = rounded(told_apart(layers) if direct else layers[..., :3])
    tints = tints_of(numbers)
    primitive.setdefault("extras", {})[EXTRAS] = {
        "view": glb.add_view(to_bytes(numbers, tints)),
        "scale": scale,
        "tints": tints,
        "space": "OBJECT" if own_axes else "SCENE",
        "direct": direct,
    }
    return len(layers)


def is_glossy(material: dict[str, Any]) -> bool:
    """Whether a material of glTF mirrors anything."""
    surface, extensions = material.get("pbrMetallicRoughness"), material.get("extensions", {})
    if surface is None:
        return False
    specular = extensions.get("KHR_materials_specular", {}).get("specularFactor", 1.0)
    ior = extensions.get("KHR_materials_ior", {}).get("ior", 1.5)
    return bool(surface.get("metallicFactor", 1.0) > 0.0 or (specular > 0.0 and ior != 1.0))


def told_apart(layers: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Layers (N, 9, 4) of transport and its direct part as the bounces, coloured, and the direct part.

    Rounded apart they suit suns, whose direct light pages reckon without the bake: with the sum rounded its error would be times the
    whole sky, and once more where suns are taken out. Bounces are small, and 0 of shadowed bakes: the pair takes little more room.
    """
    apart = layers.copy()
    apart[..., :3] -= layers[..., 3:]
    return apart


def rounded(parts: npt.NDArray[np.float64]) -> tuple[npt.NDArray[np.int32], float]:
    """Transport, or its parts, (N, 9, channels) as whole numbers up to `STEPS`, and their scale.

    One for all layers, as what lights is as strong in the one as in the other where it is sharp: layers that hold little take few bits.
    """
    scale = float(np.abs(parts).max(initial=0.0)) / STEPS or 1.0
    return np.rint(parts / scale).astype(np.int32), scale


def tints_of(numbers: npt.NDArray[np.int32]) -> list[int]:
    """By how many 256ths of green red and blue are foretold best, over all numbers (N, 9, channels).

    What one colour sends on is in proportion, noise and all.
    """
    red, green, blue = np.moveaxis(numbers[..., :3].astype(np.float64), -1, 0)
    whole = float((green**2).sum())
    if not whole:
        return [_ONE, _ONE]
    shares = (round(_ONE * float((green * other).sum()) / whole) for other in (red, blue))
    return [min(max(share, -_MOST_TINT), _MOST_TINT) for share in shares]


def to_bytes(numbers: npt.NDArray[np.int32], tints: list[int]) -> bytes:
    """Whole numbers (N, 9, channels), three of them a colour, as bytes, the low ones of all numbers and then the high ones.

    Red and blue are kept as what they differ by from what green foretells, each number as what it differs by from that of the vertex
    before, the sign in the lowest bit: neighbours are alike, so that most bytes are small and most high ones 0.
    """
    coded = numbers.copy()
    for channel, tint in zip((0, 2), tints, strict=True):
        coded[:, :, channel] -= foretold(numbers[:, :, 1], tint)
    steps = np.diff(coded.reshape(len(numbers), -1), axis=0, prepend=0).T
    signless = ((steps << 1) ^ (steps >> 31)).astype(np.uint16)
    return (signless & 255).astype(np.uint8).tobytes() + (signless >> 8).astype(np.uint8).tobytes()


def foretold(green: npt.NDArray[np.int32], tint: int) -> npt.NDArray[np.int32]:
    """A share of green, rounded as `web/packages/viewer/src/transport.ts` rounds it, too."""
    return (green * tint + _ONE // 2) // _ONE
