# SPDX-License-Identifier: GPL-3.0-or-later
"""Packs transport for the web: nine bits a number, in an order that compresses well."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ..layout import BACKS, BAKED_BELOW, LAYERS, MARK, OWN_AXES_BELOW
from .glb import Glb

STEPS = 255
"""The largest whole number: eight bits and a sign.

Of what a surface shows that leaves an error of two or three thousandths.
"""

EXTRAS = "prt_relight"
"""Key in the extras of a primitive whose transport is packed, an object of these entries:

- `view`: the buffer view that holds the packed numbers
- `scale`: by which numbers are multiplied
- `tints`: by how many 256ths of green red and blue are foretold
- `space`: whose axes the transport is in, "SCENE" or "OBJECT"
- `direct`: whether bounces and direct part are kept separately, in place of their sum; so they are where the surface
  is glossy, has normals that a picture bends, or is lit by suns
- `backs`: a `view` and a `scale` again, of meshes whose backs have transport and may be seen
"""

SHARES = 255
"""What stands for 1 in the colours and direct shares of backs."""

_MOST_SHARE = 3.0
"""Of a colour whose mean is 1; what is beyond it, or below 0, is noise where hardly any light arrives."""

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
    layers = _taken(glb, primitive, LAYERS)
    backs = _taken(glb, primitive, BACKS) if BACKS[0] in primitive["attributes"] else None
    own_axes = bool(layers[0, 0, 3] < OWN_AXES_BELOW)
    material = glb.document["materials"][primitive["material"]] if "material" in primitive else None
    direct = suns or (material is not None and (is_glossy(material) or "normalTexture" in material))
    layers[:, 0, 3] += 2.0 if own_axes else 1.0  # its marks
    numbers, scale = rounded(separated(layers) if direct else layers[..., :3])
    tints = tints_of(numbers)
    primitive.setdefault("extras", {})[EXTRAS] = {
        "view": glb.add_view(to_bytes(numbers, tints)),
        "scale": scale,
        "tints": tints,
        "space": "OBJECT" if own_axes else "SCENE",
        "direct": direct,
    }
    backs_may_be_seen = material is None or material.get("doubleSided", False)
    if backs is not None and backs_may_be_seen and (backs[:, 0, 0] < BAKED_BELOW).all():
        numbers, scale = backs_rounded(backs, direct)
        primitive["extras"][EXTRAS]["backs"] = {"view": glb.add_view(in_planes(numbers)), "scale": scale}
    return len(layers)


def _taken(glb: Glb, primitive: dict[str, Any], names: tuple[str, ...]) -> npt.NDArray[np.float64]:
    """(N, layers, 4) the floats of some layers, which the primitive has no more."""
    return np.stack([glb.values(primitive["attributes"].pop(name)) for name in names], axis=1).astype(np.float64)


def is_glossy(material: dict[str, Any]) -> bool:
    """Whether a material of glTF mirrors anything."""
    surface, extensions = material.get("pbrMetallicRoughness"), material.get("extensions", {})
    if surface is None:
        return False
    specular = extensions.get("KHR_materials_specular", {}).get("specularFactor", 1.0)
    ior = extensions.get("KHR_materials_ior", {}).get("ior", 1.5)
    return bool(surface.get("metallicFactor", 1.0) > 0.0 or (specular > 0.0 and ior != 1.0))


def separated(layers: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Separate what bounces brought from the direct part of transport.

    Both are then rounded by themselves. Pages light by suns without the bake, and take them out of the light of the
    direct part: the rounding of that part is seen under the rest of the sky alone. Were the sum rounded, its error
    would be seen under the whole sky, and that of the direct part again under the suns. Bounces are small, and 0 in
    shadowed bakes: separated, transport takes little more room.

    Args:
        layers: (N, 9, 4) transport, red, green and blue, and its direct part, without marks.

    Returns:
        (N, 9, 4) transport less its direct part, and the direct part as it is.
    """
    parts = layers.copy()
    parts[..., :3] -= layers[..., 3:]
    return parts


def rounded(parts: npt.NDArray[np.float64]) -> tuple[npt.NDArray[np.int32], float]:
    """Transport, or its parts, (N, 9, channels) or (N, 9), as whole numbers up to `STEPS`, and their scale.

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
    """Whole numbers (N, 9, channels), three of them a colour, as bytes: red and blue as what they differ by from what green foretells."""
    coded = numbers.copy()
    for channel, tint in zip((0, 2), tints, strict=True):
        coded[:, :, channel] -= foretold(numbers[:, :, 1], tint)
    return in_planes(coded.reshape(len(numbers), -1))


def backs_rounded(layers: npt.NDArray[np.float64], direct: bool) -> tuple[npt.NDArray[np.int32], float]:
    """The layers of backs (N, 3, 4) as whole numbers (N, 11), or (N, 12) with the direct share: nine of transport, which times the
    scale that is returned, too, are B_i; then red and green of its colour, and the share, as so many of `SHARES`.
    """
    transport = layers[:, :, :3].reshape(len(layers), len(LAYERS)).copy()
    transport[:, 0] += MARK["SCENE"]
    numbers, scale = rounded(transport)
    shares = layers[:, [1, 2, 0] if direct else [1, 2], 3]
    whole = np.rint(np.clip(shares, 0.0, _MOST_SHARE) * SHARES).astype(np.int32)
    return np.concatenate([numbers, whole], axis=1), scale


def in_planes(numbers: npt.NDArray[np.int32]) -> bytes:
    """Whole numbers (N, columns) as bytes, the low ones of all numbers and then the high ones, column after column.

    Each is kept as what it differs by from that of the vertex before, the sign in the lowest bit: neighbours are alike, so that most
    bytes are small and most high ones 0.
    """
    steps = np.diff(numbers, axis=0, prepend=0).T
    signless = ((steps << 1) ^ (steps >> 31)).astype(np.uint16)
    return (signless & 255).astype(np.uint8).tobytes() + (signless >> 8).astype(np.uint8).tobytes()


def foretold(green: npt.NDArray[np.int32], tint: int) -> npt.NDArray[np.int32]:
    """A share of green, rounded as `web/packages/viewer/src/transport.ts` rounds it, too."""
    return (green * tint + _ONE // 2) // _ONE
