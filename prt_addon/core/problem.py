# SPDX-License-Identifier: GPL-3.0-or-later
"""Describes what is to be baked: receivers of several objects, what blocks their light, and the settings."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, field, fields
from functools import cached_property
from typing import Any, Literal, get_args

import numpy as np
import numpy.typing as npt

from .arrays import Float64
from .files import digest
from .monitor import Work
from .surface import Albedo, Opacity

Mode = Literal["UNSHADOWED", "SHADOWED", "INTERREFLECTED"]

TRACE_FORMAT = 4
"""To be counted up whenever the same `TraceKey` gets other bits, or the files of shards look different."""

BOUNCE_IN_RAYS = 0.1
"""Reading a hit takes as long as that share of its ray. Measured."""

THIN = 4
"""A bounce within others, whose result is not seen, reads one hit of so many."""


MOST_SAMPLES = 1 << 17
"""Rays per receiver."""

MOST_BOUNCES = 100

CASTING: tuple[Mode, ...] = ("SHADOWED", "INTERREFLECTED")
"""Modes that cast rays."""

BOUNCING: tuple[Mode, ...] = ("INTERREFLECTED",)
"""Modes in which light bounces."""


def _in(modes: tuple[Mode, ...], default: Any, changes_rays: bool = False) -> Any:
    """A setting that matters to some modes; with others that change the rays it is part of the `TraceKey`."""
    return field(default=default, metadata={"modes": modes, "changes_rays": changes_rays})


@dataclass(frozen=True)
class BakeSettings:
    """What a bake depends on beside the geometry.

    Attributes:
        samples: rays per receiver.
        bounces: of light, if tolerance is 0.
        tolerance: if above 0, bounce until no coefficient changes by as much.
    """

    mode: Mode = field(default="SHADOWED", metadata={"modes": get_args(Mode), "changes_rays": True})
    samples: int = _in(CASTING, 256, changes_rays=True)
    seed: int = _in(CASTING, 0, changes_rays=True)
    bounces: int = _in(BOUNCING, 3)
    tolerance: float = _in(BOUNCING, 0.0)

    @property
    def used(self) -> set[str]:
        """Names of the settings that this bake depends on: in its mode, and beside its tolerance."""
        names = {one.name for one in fields(self) if self.mode in one.metadata["modes"]}
        return names - {"bounces"} if self.tolerance > 0.0 else names

    @property
    def of_rays(self) -> dict[str, Any]:
        """The settings, by name, that decide what rays are cast."""
        return {one.name: getattr(self, one.name) for one in fields(self) if one.metadata["changes_rays"]}

    @property
    def casts_rays(self) -> bool:
        """Whether anything blocks light."""
        return self.mode in CASTING

    @property
    def bounces_light(self) -> bool:
        """Whether surfaces light each other."""
        return self.mode in BOUNCING

    @property
    def whole_bounces(self) -> float:
        """The number of bounces over all hits that take as long; approximate where a tolerance decides."""
        if not self.bounces_light:
            return 0.0
        bounces = self.bounces if "bounces" in self.used else BakeSettings.bounces
        return 1.0 + (bounces - 1) / THIN if bounces else 0.0


@dataclass(frozen=True)
class ReceiverGroup:
    """The receivers of one object, in the axes of its island.

    Attributes:
        name: the object's, for messages.
        points: (N, 3) float64.
        normals: (N, 3) float64 of unit length.
        radius: of the object, to scale the skipped start of rays.
        edges: (E, 2) pairs of receivers that are neighbours on the mesh, over which those inside other geometry are
            filled; without any, none is.
        faces: (F, 3) the receivers at the corners of each triangle, in whose open parts the values of covered corners are found;
            without any, these stay black.
        horizons: (N, 3) unit normals of the faces themselves, where the shading normals are bent away from these: light from
            below them is blocked, by single sheets too. Zero, or None, where it need not be looked at.
    """

    name: str
    points: Float64
    normals: Float64
    radius: float
    edges: npt.NDArray[np.int32] | None = None
    faces: npt.NDArray[np.integer[Any]] | None = None
    horizons: Float64 | None = None

    def __len__(self) -> int:
        return len(self.points)


@dataclass(frozen=True)
class Occluders:
    """All that blocks light, in the axes of its island.

    Attributes:
        vertices: (V, 3) float64.
        triangles: (T, 3), front = counter-clockwise.
        corner_receiver: (T, 3) int64, which receiver, counted through all groups of the island, stands at each corner of a triangle;
            -1 returns no light. All black if None. Only interreflection needs it.
        albedo: of the triangles; white if None.
        one_sided: (T,) whether light passes through the back of a triangle; through none if None.
        opacity: which share of the light a triangle stops; all if None.
        back_receiver: (T, 3) as `corner_receiver`, of the triangles' backs; None if no back returns light.
    """

    vertices: Float64
    triangles: npt.NDArray[np.int32]
    corner_receiver: npt.NDArray[np.int64] | None = None
    albedo: Albedo | None = None
    one_sided: npt.NDArray[np.bool_] | None = None
    opacity: Opacity | None = None
    back_receiver: npt.NDArray[np.int64] | None = None

    @property
    def receiver_at_corners(self) -> npt.NDArray[np.int64]:
        """(T, 3) as `corner_receiver`, -1 where there is none; (2 T, 3) with those of the backs after all fronts, if there are any."""
        if self.corner_receiver is None:
            return np.full(self.triangles.shape, -1, dtype=np.int64)
        if self.back_receiver is None:
            return self.corner_receiver
        return np.concatenate([self.corner_receiver, self.back_receiver])

    @property
    def albedo_of_sides(self) -> Albedo:
        """The albedo of the same T or 2 T sides: a back has its front's."""
        albedo = self.albedo or Albedo(np.ones_like(self.triangles, dtype=np.float32))
        return albedo if self.back_receiver is None else albedo.of_both_sides()


@dataclass(frozen=True)
class TraceKey:
    """What rays find depends on nothing but this key: the cache, checkpoints and shards know traces by it.

    Attributes:
        fingerprint: of all that receives and blocks light.
        receivers: of all objects.
    """

    fingerprint: str
    mode: str
    samples: int
    seed: int
    receivers: int
    format: int = TRACE_FORMAT

    def differences(self, other: dict[str, Any]) -> str:
        """What is different in another key, in words; empty if nothing is."""
        differences = [
            f"{name} {other.get(name)} instead of {value}"
            for name, value in asdict(self).items()
            if name != "fingerprint" and other.get(name) != value
        ]
        if not differences and other.get("fingerprint") != self.fingerprint:
            differences = ["another scene, or other objects of it"]
        return ", ".join(differences)


@dataclass(frozen=True)
class Island:
    """Receivers that share their occluders, and their axes.

    What stays in its place is one island, in world space. Each object that may move is one of its own: its surface
    alone blocks its light, in its own axes.

    Attributes:
        groups: also of objects that only bounce light at others.
    """

    groups: Sequence[ReceiverGroup]
    occluders: Occluders

    def __len__(self) -> int:
        """The number of receivers."""
        return sum(map(len, self.groups))

    def trace_key(self, settings: BakeSettings) -> TraceKey:
        """The key of this island's rays: a digest of all arrays but the colours, exactly."""
        occluders = self.occluders
        names = repr([(group.name, group.radius) for group in self.groups]).encode()
        parts: list[npt.NDArray[Any] | None] = [occluders.vertices, occluders.triangles, occluders.corner_receiver]
        parts.append(occluders.one_sided)
        parts += [] if occluders.back_receiver is None else [occluders.back_receiver]
        parts += occluders.opacity.arrays() if occluders.opacity else []
        for group in self.groups:
            parts += [group.points, group.normals, group.edges, group.faces, group.horizons]
        arrays: list[npt.NDArray[Any]] = [np.empty(0) if part is None else part for part in parts]
        return TraceKey(digest(names, *arrays).hex(), receivers=len(self), **settings.of_rays)


@dataclass(frozen=True)
class BakeProblem:
    """One bake: everything that its result depends on.

    Groups are numbered through all islands, and so are receivers, island by island.

    Attributes:
        fingerprint: of all that receives and blocks light, for the `TraceKey`; the reader of the scene makes it, the same on
            all machines.
    """

    islands: Sequence[Island]
    settings: BakeSettings
    fingerprint: str = ""

    @classmethod
    def of(cls, groups: Sequence[ReceiverGroup], occluders: Occluders, settings: BakeSettings) -> BakeProblem:
        """The problem of a single island."""
        return cls((Island(groups, occluders),), settings)

    @property
    def groups(self) -> list[ReceiverGroup]:
        """The groups of all islands."""
        return [group for island in self.islands for group in island.groups]

    @cached_property
    def receivers(self) -> int:
        """The number of receivers in all islands."""
        return sum(map(len, self.islands))

    @property
    def casts_rays(self) -> bool:
        """Whether there is anything to trace."""
        return self.settings.casts_rays

    @property
    def work(self) -> Work:
        """All that a monitor of the bake will see done; the number of bounces is approximate."""
        rays = self.settings.samples * self.receivers if self.casts_rays else 0
        return Work(rays, int(BOUNCE_IN_RAYS * self.settings.whole_bounces * rays))

    @property
    def trace_key(self) -> TraceKey:
        """The key by which checkpoints and shards know the rays of this bake."""
        return TraceKey(self.fingerprint, receivers=self.receivers, **self.settings.of_rays)

    def numbered(self) -> Iterator[tuple[Island, int, int]]:
        """The islands, each with the numbers of its first group and of its first receiver."""
        group = receiver = 0
        for island in self.islands:
            yield island, group, receiver
            group, receiver = group + len(island.groups), receiver + len(island)
