# SPDX-License-Identifier: GPL-3.0-or-later
"""What takes part in a bake: checks the objects, and reads them and all that shades them into one plan."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import bpy
import numpy as np
import numpy.typing as npt

from ..core.albedo import Albedo
from ..core.bake import Occluders, ReceiverGroup
from ..core.errors import MeshError
from .albedo import SurfaceAlbedo, read_albedo
from .meshes import ObjectReceivers, Surface, read_receivers, read_surface, same_topology

SURFACE_TYPES = {"MESH", "CURVE", "SURFACE", "FONT", "META", "CURVES"}


@dataclass(frozen=True)
class BakePlan:
    """Everything a bake needs, as arrays: no bpy data, so that a thread may work on it.

    receivers: of the objects to bake, in their order.
    bystanders: receivers of all else, which light bounces off; empty unless the mode bounces light.
    warnings: sentences for the person.
    """

    receivers: list[ObjectReceivers]
    bystanders: list[ObjectReceivers]
    occluders: Occluders
    warnings: list[str]

    @property
    def groups(self) -> list[ReceiverGroup]:
        """What `core.bake` takes; the results of the first `len(receivers)` are wanted."""
        return [found.group for found in (*self.receivers, *self.bystanders)]


@dataclass(frozen=True)
class _Read:
    """One object or instance: its surface, and what light that bounces needs of it."""

    surface: Surface
    receivers: ObjectReceivers | None = None
    albedo: SurfaceAlbedo | None = None


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


def gather(context: bpy.types.Context, objects: Sequence[bpy.types.Object], bounces: bool = False) -> BakePlan:
    """Read receivers of `objects`, and the surfaces of these and of everything visible to render.

    Args:
        bounces: whether all surfaces also need albedo and receivers of their own.

    Raises:
        MeshError: for the first object that cannot be baked.
    """
    depsgraph = context.evaluated_depsgraph_get()
    chosen = []
    for ob in objects:
        evaluated = ob.evaluated_get(depsgraph)
        check_bakeable(ob, evaluated.data)
        found = _read(evaluated, evaluated.data, evaluated.matrix_world, True, bounces)
        if not np.isfinite(found.surface.vertices).all():
            raise MeshError(f"Mesh of '{ob.name}' holds NaN or infinite coordinates: remove those vertices, then bake.")
        chosen.append(found)
    others = list(_read_others(context.view_layer, depsgraph, set(objects), bounces))
    everything = chosen + others
    warnings = {warning: None for read in everything if read.albedo for warning in read.albedo.warnings}
    return BakePlan(
        receivers=[read.receivers for read in chosen if read.receivers],
        bystanders=[read.receivers for read in others if read.receivers],
        occluders=_joined(everything, bounces),
        warnings=list(warnings),
    )


def _read(
    evaluated: bpy.types.Object, mesh: bpy.types.Mesh, matrix: Sequence[Sequence[float]], receives: bool, bounces: bool
) -> _Read:
    world = np.array(matrix)
    surface = read_surface(mesh, world)
    return _Read(
        surface,
        read_receivers(evaluated.original.name_full, mesh, world) if receives or bounces else None,
        read_albedo(evaluated, mesh, surface) if bounces else None,
    )


def _read_others(
    view_layer: bpy.types.ViewLayer,
    depsgraph: bpy.types.Depsgraph,
    chosen: set[bpy.types.Object],
    bounces: bool,
) -> Iterator[_Read]:
    """Every renderable object and instance beside the chosen ones themselves; broken ones take no part."""
    renderable = renderable_objects(view_layer)
    for instance in depsgraph.object_instances:
        ob = instance.object.original
        owner = instance.parent.original if instance.is_instance and instance.parent else ob
        if owner not in renderable or ob.hide_render or not ob.visible_shadow:
            continue
        if instance.object.type not in SURFACE_TYPES or (ob in chosen and not instance.is_instance):
            continue
        mesh = instance.object.to_mesh()
        if mesh is not None:
            found = _read(instance.object, mesh, instance.matrix_world, False, bounces)
            instance.object.to_mesh_clear()
            if np.isfinite(found.surface.vertices).all():
                yield found


def _joined(read: Sequence[_Read], bounces: bool) -> Occluders:
    """All surfaces as one; with bounces, also the receivers at their corners and their albedo."""
    surfaces = [one.surface for one in read]
    vertices = np.concatenate([surface.vertices for surface in surfaces])
    first_vertex = _starts(len(surface.vertices) for surface in surfaces)
    triangles = np.concatenate(
        [surface.triangles + start for surface, start in zip(surfaces, first_vertex, strict=True)], dtype=np.int32
    )
    if not bounces:
        return Occluders(vertices, triangles)
    receivers = [one.receivers for one in read if one.receivers]
    albedos = [one.albedo for one in read if one.albedo]
    first_receiver = _starts(len(found.group) for found in receivers)
    corner_receiver = np.concatenate(
        [
            found.at_corners(surface) + start
            for found, surface, start in zip(receivers, surfaces, first_receiver, strict=True)
        ]
    )
    first_triangle = _starts(len(surface.triangles) for surface in surfaces)
    patterns = tuple(
        replace(pattern, triangles=pattern.triangles + start)
        for albedo, start in zip(albedos, first_triangle, strict=True)
        for pattern in albedo.patterns
    )
    albedo = Albedo(np.concatenate([albedo.constant for albedo in albedos]), patterns)
    return Occluders(vertices, triangles, corner_receiver, albedo)


def _starts(sizes: Iterable[int]) -> npt.NDArray[np.int64]:
    """Where each of some runs begins when they are laid end to end."""
    ends = np.cumsum(list(sizes))
    return np.concatenate([[0], ends[:-1]])
