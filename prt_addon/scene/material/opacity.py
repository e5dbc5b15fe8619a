# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads the opacity of materials: which share of the light the faces of cut-outs, veils and panes stop.

What lets light through is that of the `reading`: a constant, the alpha or the grey of an image, or a colour attribute.
What other nodes make is evaluated by Cycles all over the faces. Where that is impossible, they stop all light, which is said.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import bpy
import numpy as np
import numpy.typing as npt

from ...core.arrays import Float32
from ...core.notices import Kind, Notice
from ...core.surface import TexturePatch
from ..blender.nodes import has_loop
from ..mesh.meshes import Surface
from .albedo import used_materials
from .cycles_colour import CyclesRequest, CyclesRequests, Unread
from .cycles_texels import FacePicture
from .lost_pictures import why_not_shown
from .patterns import NotRead, PatternReader, ReadPattern, SurfaceValues
from .reading import Colour, Constant, Mixed, Source

_LUMINANCE = np.array([0.2126, 0.7152, 0.0722], dtype=np.float32)
"""How Blender makes a number of a colour: Rec. 709."""

_OPAQUE = Kind(
    "Material {name} lets light through, but by nodes that cannot be evaluated ({why}): the bake takes its faces as opaque.",
    "{count} materials let light through by nodes that cannot be evaluated: the bake takes their faces as opaque ({names}).",
)


class OpacityReader:
    """Reads the opacity of one state of the scene. As with the `AlbedoReader`, what other nodes make waits for Cycles."""

    def __init__(self, patterns: PatternReader, requests: CyclesRequests) -> None:
        self._patterns, self._requests = patterns, requests

    def read(
        self, ob: bpy.types.Object, mesh: bpy.types.Mesh, surface: Surface, matrix: npt.NDArray[np.float64]
    ) -> OpacityDraft | None:
        """Opacity of an evaluated object's surface, material slot by material slot; None if it stops all light.

        Args:
            ob: the evaluated object.
            mesh: of the object.
            surface: of the mesh.
            matrix: (4, 4) where it stands; an instance's object does not know.
        """
        materials = {index: one for index, one in used_materials(ob, mesh, surface).items() if one}
        through = {index: self._patterns.reading(one).through for index, one in materials.items()}
        through = {index: colour for index, colour in through.items() if _number(colour) != 0.0}
        if not through:
            return None
        draft = OpacityDraft(np.ones((len(surface.triangles), 1), dtype=np.float32), surface)
        for index, colour in through.items():
            self._read_slot(draft, index, materials[index], colour, mesh)
        if draft.unread:
            draft.request = self._requests.add(ob, matrix, draft.unread)
        return draft

    def _read_slot(
        self, draft: OpacityDraft, index: int, material: bpy.types.Material, through: Colour, mesh: bpy.types.Mesh
    ) -> None:
        triangles = np.flatnonzero(draft.surface.material == index)
        number = _number(through)
        if number is not None:
            draft.constant[triangles] = 1.0 - number
            return
        lost = why_not_shown(material, through)
        if lost or has_loop(material.node_tree):
            draft.notices.append(_opaque(material, lost or "they run in a circle"))
            return
        try:
            found = self._pattern(through, mesh, draft.surface.corners[triangles], triangles)
        except NotRead:
            draft.unread[index] = Unread(material, through)
            return
        if isinstance(found, float):
            draft.constant[triangles] = found
        else:
            draft.patterns.append(found)

    def _pattern(
        self, through: Colour, mesh: bpy.types.Mesh, corners: npt.NDArray[np.int32], triangles: npt.NDArray[np.int64]
    ) -> ReadPattern | float:
        """The share that is stopped, where what lets light through is a mix of two numbers by one picture or attribute."""
        factor, none, all_ = through, 1.0, 0.0
        if isinstance(through, Mixed):
            first, second = _number(through.first), _number(through.second)
            if first is None or second is None:
                raise NotRead("it is mixed of several", through)
            factor, none, all_ = through.factor, 1.0 - first, 1.0 - second
        if not isinstance(factor, Source):
            raise NotRead("it is mixed of several", through)
        found = self._patterns.follow(factor, mesh, corners, triangles)
        if not isinstance(found, ReadPattern):
            return none + (all_ - none) * min(max(float(np.dot(found, _LUMINANCE)), 0.0), 1.0)
        if none and isinstance(found.pattern, TexturePatch) and found.pattern.extension == "CLIP":
            raise NotRead("its picture does not cover it", through)
        return found.mapped(lambda values: none + (all_ - none) * _grey(values), f"opacity {none:g} {all_:g}")


@dataclass
class OpacityDraft:
    """What was read of a surface's opacity, and what still waits for Cycles, by material slot."""

    constant: Float32
    surface: Surface
    patterns: list[ReadPattern] = field(default_factory=list)
    unread: dict[int, Unread] = field(default_factory=dict)
    notices: list[Notice] = field(default_factory=list)
    request: CyclesRequest | None = None

    def complete(self) -> SurfaceValues:
        """Have Cycles evaluate the rest. To be called once nothing renders any more."""
        picture: FacePicture | None = self.request.answer() if self.request else None
        for index, one in self.unread.items():
            if picture is None:
                self.notices.append(_opaque(one.material, "Cycles is off, or cannot bake now"))
            else:
                self.patterns.append(self._pictured(np.flatnonzero(self.surface.material == index), picture))
        return SurfaceValues.of(self.constant, self.patterns, self.notices)

    def _pictured(self, triangles: npt.NDArray[np.int64], picture: FacePicture) -> ReadPattern:
        """The opacity of some triangles, in a picture of what lets light through."""
        stopped = np.clip(1.0 - _grey(picture.texels), 0.0, 1.0).astype(np.float32)
        uv = picture.uv[self.surface.corners[triangles]]
        steps = np.rint(stopped * 255.0).astype(np.uint8)  # the last bits differ between processors
        return ReadPattern(TexturePatch(triangles, uv, stopped), [triangles, steps])


def _number(through: Colour) -> float | None:
    """The share of the light that a constant lets through, 0 to 1; None of what is none."""
    if not isinstance(through, Constant):
        return None
    return min(max(float(np.dot(through.rgb, _LUMINANCE)), 0.0), 1.0)


def _grey(values: Float32) -> Float32:
    """(..., 1) of values (..., 3) or (..., 1)."""
    return values @ _LUMINANCE[:, None] if values.shape[-1] == 3 else values


def _opaque(material: bpy.types.Material, why: str) -> Notice:
    return Notice(_OPAQUE, material.name, {"why": why})
