# SPDX-License-Identifier: GPL-3.0-or-later
"""Decides what blocks light, by the rules of Cycles: which objects, and which of their faces."""

from __future__ import annotations

import bpy
import numpy as np
import numpy.typing as npt

from ..material.albedo import used_materials
from ..material.reading import has_surface
from ..mesh.meshes import Surface, is_open

_TYPES = {"MESH", "CURVES", "POINTCLOUD"}
"""Curves, text and metaballs are shown as what they are, and once more as meshes."""


def blocks_light(instance: bpy.types.DepsgraphObjectInstance) -> bool:
    """Whether something that renders show keeps light from receivers.

    Light of the sky that reaches a matte surface is seen by diffuse rays, and its shadows by shadow rays: what is hidden
    from either (Object > Visibility > Ray Visibility) does not count. What is hidden from the camera alone does, and so do
    holdouts.
    """
    shown = instance.object
    ob = shown.original
    return shown.type in _TYPES and bool(ob.visible_shadow and ob.visible_diffuse)


def blocking_faces(
    ob: bpy.types.Object, mesh: bpy.types.Mesh, surface: Surface
) -> tuple[Surface, npt.NDArray[np.int8] | None]:
    """The faces of an evaluated object that light stops at, by their materials.

    Volumes without a surface have none. Those with Backface Culling let light through from behind, as in EEVEE: Cycles
    has no such rule, but outlines made of turned-over hulls would blacken what they enclose.

    Returns:
        The surface of those faces; and of all triangles the number of sides that block light, None if that is always two.
    """
    materials = {index: one for index, one in used_materials(ob, mesh, surface).items() if one}
    none = {index for index, material in materials.items() if not has_surface(material)}
    culled = {index for index, material in materials.items() if is_one_sided(material)} - none
    if not none and not culled:
        return surface, None
    sides = 2 - np.isin(surface.material, list(culled)) - 2 * np.isin(surface.material, list(none))
    return surface.with_sides(culled).without(none), sides.astype(np.int8)


def shows_backs(ob: bpy.types.Object, mesh: bpy.types.Mesh, surface: Surface) -> bool:
    """Whether the backs of an object's faces receive light and return it.

    As its setting says. By itself, where the evaluated mesh is open; never where light passes through all backs.
    """
    sides = ob.prt.sides
    if sides == "FRONTS" or surface.one_sided.all():
        return False
    return sides == "BOTH" or is_open(mesh)


def is_one_sided(material: bpy.types.Material) -> bool:
    """Whether a material's faces have fronts alone."""
    return bool(material.use_backface_culling or material.use_backface_culling_shadow)
