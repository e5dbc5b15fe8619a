# SPDX-License-Identifier: GPL-3.0-or-later
"""What takes part in a bake: checks the objects, and reads them and all that shades them into one plan."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import bpy
import numpy as np
import numpy.typing as npt

from ...core.digest import digest
from ...core.errors import MeshError
from ...core.problem import BakeProblem, BakeSettings, Island, Occluders
from ...core.surface import Albedo
from ..material.albedo import SurfaceAlbedo, read_albedo
from ..material.cycles_colour import remember_instances
from ..mesh.layers import Space
from ..mesh.meshes import ObjectReceivers, Surface, own_axes, read_receivers, read_surface
from ..mesh.record import Crowd, Evidence, Identity, identity
from ..settings import Preparation
from ..shading.probe import is_probe
from .prepare import NOTHING, check_bakeable

SURFACE_TYPES = {"MESH", "CURVE", "SURFACE", "FONT", "META", "CURVES"}
SHADOWED = BakeSettings("SHADOWED")
_RIGHT_ANGLE = 1e-3  # largest cosine between the axes of an object that counts as unsheared


@dataclass(frozen=True)
class ObjectToBake:
    """One object of a plan: no bpy data.

    receivers: where its transport is computed and stored.
    space: what it is baked for, SCENE or OBJECT.
    evidence: what its bake depends on.
    group: number of its receivers in the problem.
    """

    receivers: ObjectReceivers
    space: Space
    evidence: Evidence
    group: int


@dataclass(frozen=True)
class BakePlan:
    """A bake of some objects of a scene.

    objects: in the order that was asked for.
    problem: for the engine. Its first island is the scene; each object that may move has one of its own.
    warnings: sentences for the person.
    """

    objects: list[ObjectToBake]
    problem: BakeProblem
    warnings: list[str]

    @property
    def scene(self) -> Island:
        """All that stays in its place."""
        return self.problem.islands[0]


@dataclass(frozen=True)
class _Read:
    """One object or instance: its surface, and what light that bounces needs of it."""

    surface: Surface
    identity: Identity
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


def is_subject(ob: bpy.types.Object) -> bool:
    """Whether an object is a mesh that may be baked: light probes are none."""
    return ob.type == "MESH" and not is_probe(ob.data)


def selected_meshes(context: bpy.types.Context) -> list[bpy.types.Object]:
    """The selected objects that are meshes."""
    return [ob for ob in context.selected_objects if ob.type == "MESH"]


def chosen_meshes(context: bpy.types.Context) -> list[bpy.types.Object]:
    """The selected meshes that may be baked. Cheap enough to be drawn."""
    return list(filter(is_subject, context.selected_objects))


def objects_to_bake(context: bpy.types.Context) -> list[bpy.types.Object]:
    """The chosen meshes, or all that renders show if none is selected; sorted by name.

    Raises:
        MeshError: if there is none.
    """
    chosen = chosen_meshes(context)
    if not chosen:
        shown = renderable_objects(context.view_layer)
        chosen = [ob for ob in shown if is_subject(ob) and (ob.data.polygons or ob.modifiers)]
    if not chosen:
        raise MeshError(f"Scene '{context.scene.name}' has no mesh to bake: select one, or make one visible to render.")
    return sorted(chosen, key=lambda ob: ob.name_full)


def check_unchanged(ob: bpy.types.Object, mesh: bpy.types.Mesh, receivers: ObjectReceivers) -> None:
    """Raises MeshError if the mesh that is to hold the transport was edited since the receivers were read."""
    elements = len(mesh.vertices if receivers.domain == "POINT" else mesh.loops)
    if elements != len(receivers.element_receiver):
        raise MeshError(f"Mesh of '{ob.name}' was edited during the bake; nothing was changed: bake again.")


@remember_instances()
def gather(
    context: bpy.types.Context,
    objects: Sequence[bpy.types.Object],
    settings: BakeSettings = SHADOWED,
    allowed: Preparation = NOTHING,
) -> BakePlan:
    """Read receivers of `objects`, and the surfaces of these and of everything visible to render.

    Args:
        settings: of the bake; if light bounces, all surfaces also need albedo and receivers of their own.
        allowed: what may be done, when the bake is written, to meshes that cannot hold it.

    Raises:
        MeshError: for the first object that cannot be baked.
    """
    bounces = settings.mode == "INTERREFLECTED"
    depsgraph = context.evaluated_depsgraph_get()
    chosen = [_read_chosen(ob, ob.evaluated_get(depsgraph), bounces, allowed) for ob in objects]
    staying = {ob: read for ob, read in zip(objects, chosen, strict=True) if ob.prt.space == "SCENE"}
    left_out = set(staying)
    others = [read for _, read in _read_others(context, left_out, bounces, bounces)] if staying else []
    crowd = Crowd.of(read.identity for read in (*staying.values(), *others))
    warnings = {warning: None for read in chosen + others if read.albedo for warning in read.albedo.warnings}
    if staying:
        warnings |= dict.fromkeys(_unseen(context.view_layer, set(objects)))
    groups = _numbers([ob in staying for ob in objects], sum(read.receivers is not None for read in others))
    return BakePlan(
        objects=[
            ObjectToBake(
                read.receivers,
                ob.prt.space,
                Evidence(
                    read.identity,
                    np.array(ob.evaluated_get(depsgraph).matrix_world),
                    crowd.without(read.identity) if ob in staying else Crowd(),
                ),
                number,
            )
            for ob, read, number in zip(objects, chosen, groups, strict=True)
            if read.receivers
        ],
        problem=BakeProblem(
            islands=[
                _island([*staying.values(), *others], bounces),
                *(_island([read], bounces) for ob, read in zip(objects, chosen, strict=True) if ob not in staying),
            ],
            settings=settings,
            fingerprint=_fingerprint(
                [*zip((ob.prt.space for ob in objects), chosen, strict=True), *(("SCENE", read) for read in others)],
                crowd,
            ),
        ),
        warnings=list(warnings),
    )


@remember_instances()
def survey(
    context: bpy.types.Context, objects: Sequence[bpy.types.Object], others: bool, bounces: bool
) -> list[Evidence]:
    """What bakes of `objects` would depend on, each on its own: without its receivers, and refusing none.

    Args:
        others: whether to look at all that stands around them.
        bounces: whether to look at colours.
    """
    depsgraph = context.evaluated_depsgraph_get()
    around = list(_read_others(context, set(), False, bounces)) if others else []
    shading = {ob: read.identity for ob, read in around if ob}
    crowd = Crowd.of(read.identity for _, read in around)
    evidence = []
    for ob in objects:
        evaluated = ob.evaluated_get(depsgraph)
        matrix = np.array(evaluated.matrix_world)
        own = shading.get(ob) or _read(evaluated, evaluated.to_mesh(), matrix, False, bounces).identity
        evidence.append(Evidence(own, matrix, crowd.without(own) if ob in shading else crowd))
    return evidence


def own_axes_matrix(ob: bpy.types.Object) -> npt.NDArray[np.float64]:
    """(4, 4) what is left of an object's matrix in its own axes: its scale, positive, without turn and place.

    A bake with this matrix is the same wherever the object is turned to.

    Raises:
        MeshError: if the axes are not at right angles: light cannot be turned into them.
    """
    axes = own_axes(ob.matrix_world)
    if not np.allclose(axes.T @ axes, np.eye(3), rtol=0.0, atol=_RIGHT_ANGLE):
        raise MeshError(
            f"Object '{ob.name}' is sheared or scaled to zero, so that its transport cannot turn with it: apply its "
            "scale and its parents' (Object > Apply > Scale), or choose 'Baked For: Scene', then bake."
        )
    return np.diag([*np.linalg.norm(np.array(ob.matrix_world)[:3, :3], axis=0), 1.0])


def _read_chosen(ob: bpy.types.Object, evaluated: bpy.types.Object, bounces: bool, allowed: Preparation) -> _Read:
    """An object to bake: in world space, or in its own axes and with its own surface as its occluder."""
    mesh = evaluated.to_mesh()  # with GPU subdivision on, `evaluated.data` may be coarser than what is seen
    check_bakeable(ob, mesh, allowed)
    moves = ob.prt.space == "OBJECT"
    matrix = own_axes_matrix(evaluated) if moves else evaluated.matrix_world
    found = _read(evaluated, mesh, matrix, True, bounces, place=evaluated.matrix_world)
    evaluated.to_mesh_clear()
    if not np.isfinite(found.surface.vertices).all():
        raise MeshError(f"Mesh of '{ob.name}' holds NaN or infinite coordinates: remove those vertices, then bake.")
    return found


def _read(
    evaluated: bpy.types.Object,
    mesh: bpy.types.Mesh,
    matrix: npt.ArrayLike,
    receives: bool,
    bounces: bool,
    place: npt.ArrayLike | None = None,
) -> _Read:
    """Read what is asked for; `place` is where colours are looked up, if that is not the matrix."""
    world = np.array(matrix)
    surface = read_surface(mesh, world)
    albedo = read_albedo(evaluated, mesh, surface, world if place is None else np.array(place)) if bounces else None
    return _Read(
        surface,
        identity(mesh, world, albedo),
        read_receivers(evaluated.original.name_full, mesh, world) if receives else None,
        albedo,
    )


def _read_others(
    context: bpy.types.Context, chosen: set[bpy.types.Object], receives: bool, bounces: bool
) -> Iterator[tuple[bpy.types.Object | None, _Read]]:
    """Every renderable object, and instance (of no object), beside the chosen ones themselves.

    Broken ones take no part.
    """
    renderable = renderable_objects(context.view_layer)
    for instance in context.evaluated_depsgraph_get().object_instances:
        ob = instance.object.original
        if not _casts_shadows(instance, renderable) or (ob in chosen and not instance.is_instance):
            continue
        mesh = instance.object.to_mesh()
        if mesh is not None:
            found = _read(instance.object, mesh, instance.matrix_world, receives, bounces)
            instance.object.to_mesh_clear()
            if np.isfinite(found.surface.vertices).all():
                yield (None if instance.is_instance else ob), found


def _numbers(stay: Sequence[bool], others: int) -> list[int]:
    """The number of each object's group: those that stay come first, then what stands around them, then each of the rest."""
    counts = {True: iter(range(len(stay))), False: iter(range(sum(stay) + others, len(stay) + others))}
    return [next(counts[one]) for one in stay]


def _island(read: Sequence[_Read], bounces: bool) -> Island:
    """Of objects that shade each other."""
    return Island([one.receivers.group for one in read if one.receivers], _joined(read, bounces))


def _fingerprint(receiving: Iterable[tuple[str, _Read]], crowd: Crowd) -> str:
    """Of those that receive light and what they are baked for, and of all that blocks it. Colours play no part."""
    parts = [f"{crowd.occluders:x}".encode()]
    for space, read in receiving:
        if read.receivers:
            own = read.identity
            parts += [space.encode(), own.shape, own.normals, own.placement]
    return digest(*parts).hex()


def _unseen(view_layer: bpy.types.ViewLayer, chosen: set[bpy.types.Object]) -> Iterator[str]:
    """A sentence for each object that renders, but that Blender evaluates for renders only."""
    for ob in sorted(renderable_objects(view_layer) - chosen, key=lambda ob: ob.name_full):
        if ob.type in SURFACE_TYPES and not ob.visible_get(view_layer=view_layer):
            yield f"Object '{ob.name}' renders but is hidden in the viewport: unhide it, or it casts no shadow in the bake."


def _casts_shadows(instance: bpy.types.DepsgraphObjectInstance, renderable: set[bpy.types.Object]) -> bool:
    """Whether renders show an evaluated object or instance, by the rules of Cycles, as a surface that casts shadows.

    Curves, text and metaballs come twice: as what they are, which has no mesh or the same again, and as a mesh.
    """
    shown = instance.object
    ob = shown.original
    if shown.type != "MESH" or ob.hide_render or not ob.visible_shadow:
        return False
    if instance.is_instance:
        return (instance.parent.original if instance.parent else ob) in renderable
    instances_only = shown.is_instancer and not ob.show_instancer_for_render
    by_its_parent = ob.parent is not None and ob.parent.instance_type in {"VERTS", "FACES"}
    return ob in renderable and not instances_only and not by_its_parent


def _joined(read: Sequence[_Read], bounces: bool) -> Occluders:
    """All surfaces as one; with bounces, also the receivers at their corners and their albedo.

    Receivers are counted as they are given, but surfaces are laid out by what they are: sums over what rays hit then
    run in the same order, and have the same bits, whichever objects were selected.
    """
    if not read:
        return Occluders(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int32))
    first_receiver = _starts(len(one.receivers.group) if one.receivers else 0 for one in read)
    order = sorted(range(len(read)), key=lambda i: read[i].identity.numbers)
    laid_out = [read[i] for i in order]
    surfaces = [one.surface for one in laid_out]
    vertices = np.concatenate([surface.vertices for surface in surfaces])
    first_vertex = _starts(len(surface.vertices) for surface in surfaces)
    triangles = np.concatenate(
        [surface.triangles + start for surface, start in zip(surfaces, first_vertex, strict=True)], dtype=np.int32
    )
    if not bounces:
        return Occluders(vertices, triangles)
    corner_receiver = np.concatenate(
        [
            one.receivers.at_corners(one.surface) + first_receiver[i]
            for i, one in zip(order, laid_out, strict=True)
            if one.receivers
        ]
    )
    return Occluders(vertices, triangles, corner_receiver, _joined_albedo(laid_out))


def _joined_albedo(read: Sequence[_Read]) -> Albedo:
    first_triangle = _starts(len(one.surface.triangles) for one in read)
    albedos = [one.albedo for one in read if one.albedo]
    patterns = tuple(
        replace(pattern, triangles=pattern.triangles + start)
        for albedo, start in zip(albedos, first_triangle, strict=True)
        for pattern in albedo.patterns
    )
    return Albedo(np.concatenate([albedo.constant for albedo in albedos]), patterns)


def _starts(sizes: Iterable[int]) -> npt.NDArray[np.int64]:
    """Where each of some runs begins when they are laid end to end."""
    ends = np.cumsum(list(sizes))
    return np.concatenate([[0], ends[:-1]])
