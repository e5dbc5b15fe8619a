# SPDX-License-Identifier: GPL-3.0-or-later
"""What takes part in a bake: checks the objects, and reads them and all that shades them into one plan."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import bpy
import numpy as np
import numpy.typing as npt

from ..core.bake import Occluders
from ..core.errors import MeshError
from .meshes import ObjectReceivers, Surface, read_receivers, read_surface, same_topology

SURFACE_TYPES = {"MESH", "CURVE", "SURFACE", "FONT", "META", "CURVES"}


@dataclass(frozen=True)
class BakePlan:
    """Everything a bake needs, as arrays: no bpy data, so that a thread may work on it."""

    receivers: list[ObjectReceivers]
    occluders: Occluders


def renderable_objects(view_layer: bpy.types.ViewLayer) -> set[bpy.types.Object]:
    """The objects of a view layer that its renders show."""
    found: set[bpy.types.Object] = set()
    pending = [view_layer.layer_collection]
    while pending:
        layer = pending.pop()
        if layer.exclude or layer.collection.hide_render:
            continue
        found.update(ob for ob in layer.collection.objects if not ob.hide_render)
        pending.extend(layer.children)
    return found


def objects_to_bake(context: bpy.types.Context) -> list[bpy.types.Object]:
    """The selected meshes, or all meshes visible to render if none is selected; sorted by name.

    Raises:
        MeshError: if there is none.
    """
    chosen = [ob for ob in context.selected_objects if ob.type == "MESH"]
    if not chosen:
        chosen = [ob for ob in renderable_objects(context.view_layer) if ob.type == "MESH"]
    if not chosen:
        raise MeshError(f"Scene '{context.scene.name}' has no mesh to bake: select one, or make one visible to render.")
    return sorted(chosen, key=lambda ob: ob.name_full)


def check_bakeable(ob: bpy.types.Object, evaluated: bpy.types.Mesh) -> None:
    """Raises MeshError, saying what to do, unless the transport of `ob` can be stored on its mesh."""
    mesh = ob.data
    if not mesh.is_editable:
        raise MeshError(f"Mesh '{mesh.name}' of '{ob.name}' is linked from a library: make it local, then bake.")
    if mesh.users > 1 and len(_users_of(mesh)) > 1:
        others = ", ".join(sorted(f"'{user.name}'" for user in _users_of(mesh) if user != ob))
        raise MeshError(
            f"Mesh '{mesh.name}' is shared by '{ob.name}' and {others}, which see different shadows: make it "
            "single-user (Object > Relations > Make Single User > Object & Data), then bake."
        )
    if not len(mesh.polygons):
        raise MeshError(f"Object '{ob.name}' has no faces: add some or deselect it.")
    if not same_topology(mesh, evaluated):
        raise MeshError(
            f"Modifiers of '{ob.name}' change its topology, so that vertex values cannot be stored: apply them "
            "(Object > Apply > Visual Geometry to Mesh), then bake."
        )


def check_unchanged(ob: bpy.types.Object, receivers: ObjectReceivers) -> None:
    """Raises MeshError if the mesh was edited since its receivers were read."""
    elements = len(ob.data.vertices if receivers.domain == "POINT" else ob.data.loops)
    if elements != len(receivers.element_receiver):
        raise MeshError(f"Mesh of '{ob.name}' was edited during the bake; nothing was changed: bake again.")


def _users_of(mesh: bpy.types.Mesh) -> list[bpy.types.Object]:
    return [ob for ob in bpy.data.objects if ob.data == mesh]


def gather(context: bpy.types.Context, objects: Sequence[bpy.types.Object]) -> BakePlan:
    """Read receivers of `objects`, and the surfaces of these and of everything visible to render.

    Raises:
        MeshError: for the first object that cannot be baked.
    """
    depsgraph = context.evaluated_depsgraph_get()
    receivers = []
    surfaces = []
    for ob in objects:
        evaluated = ob.evaluated_get(depsgraph)
        check_bakeable(ob, evaluated.data)
        matrix = np.array(evaluated.matrix_world)
        surface = read_surface(evaluated.data, matrix)
        if not np.isfinite(surface.vertices).all():
            raise MeshError(f"Mesh of '{ob.name}' holds NaN or infinite coordinates: remove those vertices, then bake.")
        surfaces.append(surface)
        receivers.append(read_receivers(ob.name_full, evaluated.data, matrix))
    surfaces.extend(_other_surfaces(context.view_layer, depsgraph, set(objects)))
    return BakePlan(receivers, _joined(surfaces))


def _other_surfaces(
    view_layer: bpy.types.ViewLayer, depsgraph: bpy.types.Depsgraph, receivers: set[bpy.types.Object]
) -> Iterator[Surface]:
    """Surfaces of every renderable object and instance beside the receivers themselves."""
    renderable = renderable_objects(view_layer)
    for instance in depsgraph.object_instances:
        ob = instance.object.original
        owner = instance.parent.original if instance.is_instance and instance.parent else ob
        if owner not in renderable or ob.hide_render or not ob.visible_shadow:
            continue
        if instance.object.type not in SURFACE_TYPES or (ob in receivers and not instance.is_instance):
            continue
        mesh = instance.object.to_mesh()
        if mesh is not None:
            surface = read_surface(mesh, np.array(instance.matrix_world))
            instance.object.to_mesh_clear()
            if np.isfinite(surface.vertices).all():
                yield surface


def _joined(surfaces: Sequence[Surface]) -> Occluders:
    first = np.cumsum([0, *(len(surface.vertices) for surface in surfaces)])
    triangles: list[npt.NDArray[np.int32]] = [
        (surface.triangles + start).astype(np.int32) for surface, start in zip(surfaces, first, strict=False)
    ]
    return Occluders(np.concatenate([surface.vertices for surface in surfaces]), np.concatenate(triangles))
