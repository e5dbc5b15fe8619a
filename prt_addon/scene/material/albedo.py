# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads the albedo of materials: the colour that light takes on where it bounces.

The colour is that of the `reading`: a constant, an image texture or a colour attribute. One that comes from other
nodes, or is mixed of several, is evaluated by Cycles at the vertices, which is said; where that is impossible the viewport
colour stands in, which is said, too.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import bpy
import numpy as np
import numpy.typing as npt

from ...core.arrays import Float32
from ...core.notices import Kind, Notice
from ..blender.nodes import has_loop
from ..mesh.meshes import Surface
from .cycles_colour import CyclesRequest, CyclesRequests, Unread
from .lost_pictures import why_not_shown
from .patterns import NotRead, PatternReader, ReadPattern, SurfaceValues
from .reading import BLACK, RGB, Colour, Constant

DEFAULT_COLOUR = (0.8, 0.8, 0.8)
"""Of surfaces without a material, as Blender shows them."""


_EVALUATED = Kind(
    "Material {name}: {why}; Cycles evaluated it at the vertices.",
    "{count} materials have colours from nodes that are not read: Cycles evaluated them at the vertices ({names}).",
    "INFO",
)
_GUESSED = Kind(
    "Material {name}: {why}; light takes on its viewport colour.",
    "{count} materials have colours that cannot be evaluated: light takes on their viewport colours ({names}).",
)
_LOST = Kind(
    _GUESSED.one,
    "{count} materials have lost their pictures, so that light takes on their viewport colours: find them with File > "
    "External Data > Find Missing Files ({names}).",
)


class AlbedoReader:
    """Reads albedo of one state of the scene: each texture once, and as far as materials can be read.

    The rest waits for Cycles, which cannot work while another render goes on: `AlbedoDraft.complete` has it evaluated.
    """

    def __init__(self, patterns: PatternReader, requests: CyclesRequests) -> None:
        self._patterns, self._requests = patterns, requests

    def read(
        self, ob: bpy.types.Object, mesh: bpy.types.Mesh, surface: Surface, matrix: npt.NDArray[np.float64]
    ) -> AlbedoDraft:
        """Albedo of an evaluated object's surface, material slot by material slot.

        Args:
            ob: the evaluated object.
            mesh: of the object.
            surface: of the mesh.
            matrix: (4, 4) where it stands; an instance's object does not know.
        """
        draft = AlbedoDraft(np.empty((len(surface.triangles), 3), dtype=np.float32), surface)
        draft.constant[:] = DEFAULT_COLOUR
        for index, material in used_materials(ob, mesh, surface).items():
            if material is not None:
                self._read_slot(draft, index, material, mesh)
        shown = {
            index: Unread(reason.material, reason.colour)
            for index, reason in draft.unread.items()
            if reason.shown and not has_loop(reason.material.node_tree)
        }
        if shown:
            draft.shown = set(shown)
            draft.request = self._requests.add(ob, matrix, shown)
        return draft

    def _read_slot(self, draft: AlbedoDraft, index: int, material: bpy.types.Material, mesh: bpy.types.Mesh) -> None:
        triangles = np.flatnonzero(draft.surface.material == index)
        corners = draft.surface.corners[triangles]
        try:
            found = self._material_albedo(material, mesh, corners, triangles)
        except NotRead as reason:
            lost = why_not_shown(material, reason.colour)
            draft.unread[index] = _UnreadSlot(material, lost or str(reason), reason.colour, not lost)
            found = tuple(material.diffuse_color[:3])
        if isinstance(found, tuple):
            draft.constant[triangles] = found
        else:
            draft.patterns.append(found)

    def _material_albedo(
        self,
        material: bpy.types.Material,
        mesh: bpy.types.Mesh,
        corners: npt.NDArray[np.int32],
        triangles: npt.NDArray[np.int64],
    ) -> RGB | ReadPattern:
        """One colour, or a pattern over the triangles."""
        reading = self._patterns.reading(material)
        colour = reading.colour
        if colour is None and not reading.why_not:
            return BLACK.rgb
        if colour is None:
            raise NotRead(reading.why_not)
        if isinstance(colour, Constant):
            return colour.rgb
        found = self._patterns.follow(colour, mesh, corners, triangles)
        if isinstance(found, ReadPattern) and found.channels == 1:
            return found.mapped(lambda number: np.repeat(number, 3, axis=-1), "grey")
        return found


@dataclass(frozen=True)
class _UnreadSlot:
    """What could not be read of a material, and why. Not shown: Cycles cannot show it either, as a picture is lost."""

    material: bpy.types.Material
    why: str
    colour: Colour | None
    shown: bool


@dataclass
class AlbedoDraft:
    """What was read of a surface's albedo, and what still waits for Cycles, by material slot.

    shown: the unread slots that Cycles evaluates.
    """

    constant: Float32
    surface: Surface
    patterns: list[ReadPattern] = field(default_factory=list)
    unread: dict[int, _UnreadSlot] = field(default_factory=dict)
    shown: set[int] = field(default_factory=set)
    request: CyclesRequest | None = None

    def complete(self) -> SurfaceValues:
        """Have Cycles evaluate the rest. To be called once nothing renders any more."""
        colours = self.request.answer() if self.request else None
        notices = []
        for index, one in self.unread.items():
            evaluated = colours is not None and index in self.shown
            kind = _EVALUATED if evaluated else _GUESSED if one.shown else _LOST
            notices.append(Notice(kind, one.material.name, {"why": one.why}))
            if colours is not None and evaluated:
                triangles = np.flatnonzero(self.surface.material == index)
                self.patterns.append(ReadPattern.at_corners(triangles, colours[self.surface.corners[triangles]]))
        return SurfaceValues.of(self.constant, self.patterns, notices)


def used_materials(
    ob: bpy.types.Object, mesh: bpy.types.Mesh, surface: Surface
) -> dict[int, bpy.types.Material | None]:
    """The original material of each slot that an evaluated object's surface shows.

    A node modifier may have set them: then they are the mesh's, and the object has no slot of its own for them.
    """
    slots = [slot.material for slot in ob.material_slots]
    materials = slots + list(mesh.materials)[len(slots) :]
    if not materials:
        return {}
    used = {index: materials[min(max(index, 0), len(materials) - 1)] for index in surface.slots}
    return {index: material and material.original for index, material in used.items()}
