# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes and reads the record of a bake on its mesh: the settings, and digests of all that the bake depended on.

One digest per cause, so that a stale bake can say why. Names play no part in them, nor does the order of objects. They
are made of what Blender stores rather than of what it derives from that (sharp edges, not normals): what is computed
may differ in its last bit between machines.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass, fields
from functools import cached_property
from typing import Any, get_args

import bpy
import numpy as np
import numpy.typing as npt

from ...core.files import digest
from ...core.problem import BOUNCING, CASTING, MOST_BOUNCES, MOST_SAMPLES, BakeSettings, Mode
from ...core.sphere import sh
from ..blender.versions import refuse_newer, version_of
from .derived import derived_sources
from .meshes import face_starts

RECORD = "prt_bake"
FORMAT_VERSION = 2
"""Of the record, and of the layers beside it: see `core.layout`."""
_FINGERPRINT, _PREVIEW_OF = "fingerprint", "preview_of"
_ROUNDING = 2e-6  # of matrices, relative
_LAYER_TYPES = {
    "FLOAT_VECTOR": ("vector", np.float32, 3),
    "INT": ("value", np.int32, 1),
    "INT16_2D": ("value", np.int16, 2),
    "BOOLEAN": ("value", np.bool_, 1),
}
"""Property, type and width of the layers that a mesh is made of."""

Array = npt.NDArray[Any]


@dataclass(frozen=True)
class Identity:
    """Digests of one object or instance, without its name.

    shape: positions and faces, in its own axes.
    normals: flat faces, sharp edges and custom normals, and whether backs receive light.
    placement: its matrix.
    colours: what light takes on where it bounces off it; empty if that was not read.
    """

    shape: bytes
    normals: bytes
    placement: bytes
    colours: bytes

    @cached_property
    def numbers(self) -> tuple[int, int, int]:
        """What this object adds to an `IdentitySum`: as an occluder, as what light bounces off, and with its colours."""
        occluder = self.shape + self.placement
        reflector = occluder + self.normals
        occludes, reflects, colours = map(digest, (occluder, reflector, reflector + self.colours))
        return int.from_bytes(occludes), int.from_bytes(reflects), int.from_bytes(colours)


@dataclass(frozen=True)
class IdentitySum:
    """Identifies many objects together, whatever their order, by sums of their numbers.

    Sums and not exclusive ors: two of a kind must not cancel.
    """

    occluders: int = 0
    reflectors: int = 0
    colours: int = 0

    @classmethod
    def of(cls, identities: Iterable[Identity]) -> IdentitySum:
        """The sum of some objects."""
        numbers = [identity.numbers for identity in identities]
        return cls(*map(sum, zip(*numbers, strict=True)))

    def without(self, one: Identity) -> IdentitySum:
        """The sum of all objects but one: what surrounds that one."""
        occludes, reflects, colours = one.numbers
        return IdentitySum(self.occluders - occludes, self.reflectors - reflects, self.colours - colours)


@dataclass(frozen=True)
class Fingerprint:
    """What the bake of one object depended on; empty what it did not depend on.

    geometry: its own.
    transform: of its matrix, what matters: see `transform_of`.
    others: what stood around it.
    colours: that light bounced off, its own included; these can only be compared where all else is equal.
    """

    geometry: str
    transform: tuple[float, ...]
    others: str
    colours: str


@dataclass(frozen=True)
class Evidence:
    """All that a bake of one object may depend on, whatever its mode: pure data.

    matrix: (4, 4), the object's in the world.
    others: all that stands around it.
    """

    own: Identity
    matrix: npt.NDArray[np.float64]
    others: IdentitySum

    def fingerprint(self, mode: str, space: str) -> Fingerprint:
        """The part that matters to a bake in a mode, for the scene or for the object itself."""
        bounces = mode in BOUNCING
        others = colours = ""
        if space == "OBJECT":
            colours = self.own.colours.hex() if bounces else ""
        elif bounces:
            others = f"{self.others.reflectors:x}"
            colours = digest(self.own.colours, f"{self.others.colours:x}".encode()).hex()
        elif mode in CASTING:
            others = f"{self.others.occluders:x}"
        geometry = digest(self.own.shape, self.own.normals).hex()
        return Fingerprint(geometry, transform_of(self.matrix, mode, space), others, colours)


@dataclass(frozen=True)
class BakeRecord:
    """A bake that a mesh carries.

    version: of its format; 0 if it is of unknown origin.
    elements: vertices and face corners of the object's own mesh then.
    fingerprint: None if another version baked it, or another program.
    preview_of: rays per receiver of the bake that this is a preview of; 0 if it is none.
    """

    settings: BakeSettings
    space: str
    version: int = 0
    elements: tuple[int, ...] = ()
    fingerprint: Fingerprint | None = None
    preview_of: int = 0


def transform_of(matrix: npt.ArrayLike, mode: str, space: str) -> tuple[float, ...]:
    """The part of an object's world matrix that a bake depends on.

    Turn, scale and place; without shadows the place is all the same; in the object's own axes only their lengths and
    angles matter, which are the same however it is turned or mirrored.
    """
    whole = np.array(matrix, dtype=np.float64)
    linear = whole[:3, :3]
    parts = [linear, whole[:3, 3]]
    if space == "OBJECT":
        parts = [linear.T @ linear]
    elif mode not in CASTING:
        parts = [linear]
    return tuple(value for part in parts for value in part.ravel().tolist())


def same_transform(one: tuple[float, ...], other: tuple[float, ...]) -> bool:
    """Whether two results of `transform_of` are equal but for the rounding of Blender's single precision."""
    if len(one) != len(other):
        return False
    size = max(map(abs, one[:9]))
    return all(abs(a - b) <= _ROUNDING * max(size, abs(a)) for a, b in zip(one, other, strict=True))


def mesh_identity(
    mesh: bpy.types.Mesh,
    matrix: npt.ArrayLike,
    sides: npt.NDArray[np.int8] | None = None,
    ob: bpy.types.Object | None = None,
    both_sides: bool = False,
) -> Identity:
    """Digest an evaluated mesh under a matrix, without its colours.

    Args:
        mesh: that was evaluated.
        matrix: (4, 4) where it stands.
        sides: (triangles,) from how many sides each blocks light; from both if None.
        ob: the original object, if modifiers made the mesh of another: see `derived`.
        both_sides: whether its backs receive light, too.
    """
    faces: list[Any] = [] if sides is None else [sides]
    shape = [_layer(mesh, "position"), _layer(mesh, ".corner_vert"), face_starts(mesh)]
    return Identity(
        shape=digest(*(derived_sources(ob, mesh) if ob else shape), *faces),
        normals=digest(*_normal_sources(ob.data if ob else mesh), *([b"both sides"] if both_sides else [])),
        placement=digest(np.asarray(matrix, dtype=np.float32) + np.float32(0.0)),  # -0 becomes 0
        colours=b"",
    )


def surface_identity(vertices: Array, triangles: Array) -> Identity:
    """Digest world-space triangles that have no mesh."""
    return Identity(digest(vertices.astype(np.float32), triangles), b"", b"", b"")


def write_record(
    mesh: bpy.types.Mesh,
    domain: str,
    settings: BakeSettings,
    space: str,
    evidence: Evidence | None,
    elements: tuple[int, int],
    preview_of: int = 0,
) -> None:
    """Note on a mesh how it was baked and, with evidence, what that depended on.

    Args:
        mesh: that holds the transport.
        domain: POINT or CORNER.
        settings: of the bake.
        space: whose axes the transport is in.
        evidence: what the bake depended on; None if that is not known.
        elements: vertices and face corners of the mesh that people edit.
        preview_of: rays per receiver of the bake that this is a preview of; 0 if it is none.
    """
    record = {"version": FORMAT_VERSION, "order": sh.ORDER, "domain": domain, "space": space, **asdict(settings)}
    if evidence:
        record["elements"] = list(elements)
        record[_FINGERPRINT] = asdict(evidence.fingerprint(settings.mode, space))
    if preview_of:
        record[_PREVIEW_OF] = preview_of
    mesh[RECORD] = record


def is_newer(mesh: bpy.types.Mesh) -> bool:
    """Whether a newer version baked onto a mesh: its transport is neither read, changed nor removed."""
    return version_of(mesh.get(RECORD)) > FORMAT_VERSION


def check_version(ob: bpy.types.Object, mesh: bpy.types.Mesh) -> None:
    """Raises VersionError if a newer version baked an object, whose transport lies on a mesh."""
    refuse_newer(f"Object '{ob.name}' was baked", version_of(mesh.get(RECORD)), FORMAT_VERSION)


def read_record(mesh: bpy.types.Mesh) -> BakeRecord | None:
    """Read the record of a mesh, if it has one; of another version's record, what this version understands."""
    stored = mesh.get(RECORD)
    if stored is None:
        return None
    try:
        return _record(stored)
    except (KeyError, TypeError, ValueError, AttributeError):  # written by a user, or another program
        return BakeRecord(BakeSettings(), "SCENE")


def _record(stored: Any) -> BakeRecord:
    version = version_of(stored)
    if not 0 < version <= FORMAT_VERSION:
        return BakeRecord(BakeSettings(), "SCENE", version)
    settings = BakeSettings(
        **{
            field.name: _like(field.default, stored[field.name])
            for field in fields(BakeSettings)
            if field.name in stored
        }
    )
    space = stored.get("space", "SCENE")
    if settings.mode not in get_args(Mode) or space not in {"SCENE", "OBJECT"}:
        raise ValueError("an unknown mode or space")
    if not (0 <= settings.samples <= MOST_SAMPLES and 0 <= settings.bounces <= MOST_BOUNCES and settings.seed >= 0):
        raise ValueError("settings that no bake has")
    preview_of = _like(0, stored.get(_PREVIEW_OF, 0))
    found = stored.get(_FINGERPRINT)
    if version != FORMAT_VERSION or found is None:
        return BakeRecord(settings, space, version, preview_of=preview_of)
    fingerprint = Fingerprint(
        str(found["geometry"]), tuple(map(float, found["transform"])), str(found["others"]), str(found["colours"])
    )
    return BakeRecord(settings, space, version, tuple(map(int, stored["elements"])), fingerprint, preview_of)


def _like(example: Any, value: Any) -> Any:
    """A value, if it is of the kind of another."""
    if isinstance(value, bool) or not isinstance(value, (int, float) if isinstance(example, float) else type(example)):
        raise TypeError(f"{value!r} is not of the kind of {example!r}")
    return value


def _normal_sources(mesh: bpy.types.Mesh) -> Iterator[bytes | Array]:
    """What shading normals come from; a layer of zeros is as good as none."""
    for name in ("sharp_face", "sharp_edge", "custom_normal"):
        values = _layer(mesh, name)
        if values.any():
            yield f"{name} {mesh.attributes[name].domain}".encode()
            yield values
            if name == "sharp_edge":
                yield _layer(mesh, ".corner_edge")


def _layer(mesh: bpy.types.Mesh, name: str) -> Array:
    """Flat values of a layer, empty without it: many times as fast as `foreach_get` on vertices and corners."""
    layer = mesh.attributes.get(name)
    if layer is None or layer.data_type not in _LAYER_TYPES:
        return np.empty(0)
    key, kind, width = _LAYER_TYPES[layer.data_type]
    values = np.empty(len(layer.data) * width, dtype=kind)
    layer.data.foreach_get(key, values)
    return values
