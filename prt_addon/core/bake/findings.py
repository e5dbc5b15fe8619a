# SPDX-License-Identifier: GPL-3.0-or-later
"""Says what the user should know of the transport of objects: what lies inside others, what no light reaches, what is tiny."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..arrays import Bools, Float32, Ints
from ..notices import Kind, Notice
from ..problem import Island
from ..transport.direct import Receivers
from ..transport.inside import Surroundings, is_dark
from ..transport.raycast import Hits
from ..workers import Workers

_TOO_DARK = 0.75  # share of an object's receivers that is worth a word
_IN_A_ROOM = 0.5  # share of what these see that is fronts of other objects
_LOOKED_AT = 256  # of these
_TOO_BLIND = 0.02  # skipped start of rays, as a share of their object's radius, that is worth a word

_FILLED = Kind(
    "{share} of the receivers of {name} lie inside other geometry, and take the light of open parts around them.",
    "{count} objects have receivers inside other geometry, which take the light of open parts around them: {names}.",
    "INFO",
)
_BLACK = Kind(
    "No light reaches {part}{name}: unless it is a closed room, its faces point inwards (Mesh > Normals > Recalculate Outside) "
    "or it lies inside other geometry.",
    "No light reaches {count} objects, or most of them: unless they are closed rooms, their faces point inwards (Mesh > Normals > "
    "Recalculate Outside) or they lie inside other geometry: {names}.",
)
_TINY = Kind(
    "{name} is tiny, and far from the finest part of the scene: shadows from closer than {blind} are lost on it; move what is "
    "fine closer together, or hide the one from renders while the other is baked.",
    "{count} objects are tiny, and far from the finest part of the scene, and lose shadows from close by: {names}; move what "
    "is fine closer together, or hide the one from renders while the other is baked.",
)


@dataclass(frozen=True)
class Findings:
    """What there is to say of the groups of an island.

    Attributes:
        island: whose groups they are.
        receivers: of all its groups.
        surroundings: the geometry about them.
        seed: as the bake's.
        workers: who casts what few rays it takes; they are not counted.
    """

    island: Island
    receivers: Receivers
    surroundings: Surroundings
    seed: int
    workers: Workers

    def of(self, direct: Float32, mended: Bools) -> Iterator[tuple[int, Notice]]:
        """Each with the number of its group.

        Args:
            direct: (N, 9) shadowed transport; what follows is not looked at.
            mended: (N,) which receivers were filled.
        """
        start = 0
        for number, group in enumerate(self.island.groups):
            part = slice(start, start + len(group))
            if len(group):
                for notice in self._about(number, part, is_dark(direct[part]), mended[part]):
                    yield number, notice
            start = part.stop

    def _about(self, number: int, part: slice, dark: Bools, mended: Bools) -> Iterator[Notice]:
        """Of the group of a number, which is a part of the receivers."""
        group = self.island.groups[number]
        if mended.any():
            share = f"{mended.mean():.0%}" if mended.mean() >= 0.01 else "Less than 1%"
            yield Notice(_FILLED, group.name, {"share": share})
        if dark.mean() > _TOO_DARK and not self._stands_in_a_room(number, part, dark):
            share = "" if dark.all() else f"{min(dark.mean(), 0.99):.0%} of the receivers of "
            yield Notice(_BLACK, group.name, {"part": share})
        scene = self.surroundings.scene
        blind = float(np.median(scene.skips(scene.normalised(group.points), group.radius))) * scene.radius
        if blind > _TOO_BLIND * group.radius > 0.0:
            yield Notice(_TINY, group.name, {"blind": f"{blind:.2g}"})

    def _stands_in_a_room(self, number: int, part: slice, dark: Bools) -> bool:
        """Whether the dark receivers of a group see, for the most part, the fronts of other objects.

        Walls, that is, from which light may come by a window. Faces that point inwards see one another, and what is buried sees backs.
        """
        if number not in self._owners or len(self._owners) == 1:
            return False  # whose faces these are is not known, or there are no others
        of_sides = self._owner_of_sides

        def fronts_of_others(hits: Hits) -> Bools:
            own = (of_sides[:, hits.triangle] == number).any(axis=0)
            return (hits.triangle >= 0) & hits.front & ~own

        looking = self.receivers[part.start + np.flatnonzero(dark)[:: int(dark.sum()) // _LOOKED_AT + 1]]
        share = self.surroundings.share(fronts_of_others, looking, self.seed, self.workers)
        return float(share.mean()) > _IN_A_ROOM

    @cached_property
    def _owner_of_sides(self) -> Ints:
        """(1 or 2, T) the number of the group that each triangle's front, and back, belongs to; -1 where that is not known."""
        receiver = self.island.occluders.receiver_at_corners.max(axis=1)
        ends = np.cumsum([len(group) for group in self.island.groups])
        owner = np.where(receiver >= 0, np.searchsorted(ends, receiver, side="right"), -1)
        return owner.reshape(-1, len(self.surroundings.triangles))

    @cached_property
    def _owners(self) -> set[int]:
        """All of them."""
        return set(np.unique(self._owner_of_sides).tolist())
