# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads the scene as it renders: receivers of the objects to bake, and all that blocks light or bounces it.

Reading has two steps, as Cycles cannot evaluate a material while another render goes on. While Blender shows the scene as
it renders, everything becomes arrays; after that, the colours that are still missing are asked for.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace

import bpy
import numpy as np
import numpy.typing as npt

from ...core.errors import MeshError
from ...core.files import digest
from ...core.layout import Space
from ...core.notices import Kind, Notice
from ...core.problem import BakeProblem, BakeSettings, Island, Occluders
from ...core.surface import Albedo
from ..blender.rendered import as_rendered
from ..material.albedo import AlbedoDraft, AlbedoReader, SurfaceAlbedo
from ..mesh.carrier import Geometry, is_shared, transport_mesh
from ..mesh.layers import is_baked, space_of
from ..mesh.meshes import ObjectReceivers, Surface, own_axes, read_receivers, read_surface, same_topology
from ..mesh.record import Evidence, Identity, IdentitySum, identity, surface_identity
from ..mesh.strands import strands
from . import choose
from .blocking import blocking_faces, blocks_light

SHADOWED = BakeSettings("SHADOWED")
_RIGHT_ANGLE = 1e-3  # largest cosine between the axes of an object that counts as unsheared

_HIDDEN = Kind(
    "{name} does not render, and is not baked: show it in renders (the camera in the Outliner).",
    "{count} objects do not render, and are not baked: show them in renders (the camera in the Outliner): {names}.",
)
_NO_FACES = Kind(
    "{name} has no faces, and is not baked.",
    "{count} objects have no faces, and are not baked: {names}.",
    "INFO",
)
_FLAT = Kind(
    "{name} is scaled to nothing, and is not baked: scale it up.",
    "{count} objects are scaled to nothing, and are not baked: scale them up: {names}.",
)
_NOT_FINITE = Kind(
    "The mesh of {name} holds NaN or infinite coordinates, and is not baked: remove those vertices, then bake.",
    "{count} meshes hold NaN or infinite coordinates, and are not baked: remove those vertices, then bake: {names}.",
)
_SHEARED = Kind(
    "{name} is sheared or scaled to zero, so that its transport cannot turn with it, and is not baked: apply its scale and its "
    "parents' (Object > Apply > Scale), or choose 'Baked For: Scene', then bake.",
    "{count} objects are sheared or scaled to zero, so that their transport cannot turn with them, and are not baked: apply "
    "their scale and their parents' (Object > Apply > Scale), or choose 'Baked For: Scene', then bake: {names}.",
)


@dataclass(frozen=True)
class ObjectToBake:
    """One object of a plan: no bpy data.

    name: its full name.
    surface: its own, as it renders, in the axes that it is baked in.
    receivers: where its transport is computed and stored.
    space: what it is baked for, SCENE or OBJECT.
    evidence: what its bake depends on.
    group: number of its receivers in the problem.
    elements: vertices and face corners of its own mesh.
    carried: what a carrier is to look like; None if the object's own mesh can hold the transport.
    """

    name: str
    surface: Surface
    receivers: ObjectReceivers
    space: Space
    evidence: Evidence
    group: int
    elements: tuple[int, int]
    carried: Geometry | None


@dataclass(frozen=True)
class BakePlan:
    """A bake of some objects of a scene.

    objects: in the order that was asked for.
    problem: for the engine. Its first island is the scene; each object that may move has one of its own.
    notices: what the person should know.
    radii: of all that stays in its place, with the name of the object, or none.
    """

    objects: list[ObjectToBake]
    problem: BakeProblem
    notices: list[Notice]
    radii: list[tuple[str, float]]

    @property
    def scene(self) -> Island:
        """All that stays in its place."""
        return self.problem.islands[0]


@dataclass(frozen=True)
class _Read:
    """One object or instance: its surface, and what light that bounces needs of it."""

    surface: Surface
    identity: Identity
    blocks: bool
    receivers: ObjectReceivers | None
    albedo: SurfaceAlbedo | None


@dataclass(frozen=True)
class _Draft:
    """The same while the scene is shown as it renders: the albedo may still wait for Cycles.

    blocks: whether it blocks light; what does not may still receive it.
    """

    surface: Surface
    identity: Identity
    blocks: bool
    receivers: ObjectReceivers | None = None
    albedo: AlbedoDraft | None = None

    @property
    def is_finite(self) -> bool:
        return bool(np.isfinite(self.surface.vertices).all())

    def complete(self) -> _Read:
        """To be called when nothing renders any more."""
        albedo = self.albedo.complete() if self.albedo else None
        known = replace(self.identity, colours=albedo.identity) if albedo else self.identity
        return _Read(self.surface, known, self.blocks, self.receivers, albedo)


@dataclass
class _Chosen:
    """One object to bake.

    draft: in world space, or in its own axes and place.
    matrix: (4, 4), the object's in the world.
    why_not: what keeps it from being baked.
    """

    draft: _Draft | None = None
    matrix: npt.NDArray[np.float64] = field(default_factory=lambda: np.eye(4))
    carried: Geometry | None = None
    why_not: Kind | None = None


@dataclass
class _Found:
    """All that renders.

    chosen: of those that were asked for, the ones that render.
    others: all else that blocks light, and the object whose it is; None for an instance.
    instances: how many each object shows that are not relit.
    """

    chosen: dict[bpy.types.Object, _Chosen] = field(default_factory=dict)
    others: list[tuple[bpy.types.Object | None, _Draft]] = field(default_factory=list)
    instances: Counter[bpy.types.Object] = field(default_factory=Counter)


@dataclass(frozen=True)
class _Request:
    """What is to be read of a scene.

    spaces: of the objects to bake.
    around: whether to read all that stands around them.
    receives: whether to read receivers of the objects; those of all else if light bounces, too.
    bounces: whether to read colours.
    """

    spaces: Mapping[bpy.types.Object, Space]
    around: bool
    receives: bool
    bounces: bool


def read_bake(
    context: bpy.types.Context, objects: Sequence[bpy.types.Object], settings: BakeSettings = SHADOWED
) -> BakePlan:
    """Read receivers of `objects`, and the surfaces of these and of everything that renders.

    Args:
        settings: of the bake; if light bounces, all surfaces also need albedo and receivers of their own.

    Raises:
        MeshError: if none of the objects can be baked. Where only some cannot, the plan's notices say so.
    """
    bounces = settings.mode == "INTERREFLECTED"
    wanted, notices = choose.sorted_out(objects)
    spaces: dict[bpy.types.Object, Space] = {ob: ob.prt.space for ob in wanted}
    with AlbedoReader() as albedos:
        request = _Request(spaces, "SCENE" in spaces.values(), True, bounces)
        found = as_rendered(context, lambda depsgraph: _read_all(depsgraph, request, albedos))
        baked = {ob: one for ob in wanted if (one := found.chosen.get(ob)) and one.draft and not one.why_not}
        chosen = {ob: one.draft.complete() for ob, one in baked.items() if one.draft}
        others = [draft.complete() for _, draft in found.others] if "SCENE" in map(spaces.get, baked) else []
    notices += _left_out(wanted, found)
    if not chosen:
        raise choose.nothing(context, notices)
    notices += [notice for read in (*chosen.values(), *others) if read.albedo for notice in read.albedo.notices]
    notices += choose.instances(found.instances) + choose.strands(context) + choose.no_meshes(context)
    staying = {ob: read for ob, read in chosen.items() if spaces[ob] == "SCENE"}
    everything = IdentitySum.of(read.identity for read in (*staying.values(), *others) if read.blocks)
    groups = _numbers([ob in staying for ob in chosen], sum(read.receivers is not None for read in others))
    return BakePlan(
        objects=[
            ObjectToBake(
                ob.name_full,
                read.surface,
                read.receivers,
                spaces[ob],
                Evidence(
                    read.identity, baked[ob].matrix, _around(everything, read) if ob in staying else IdentitySum()
                ),
                number,
                (len(ob.data.vertices), len(ob.data.loops)),
                baked[ob].carried,
            )
            for (ob, read), number in zip(chosen.items(), groups, strict=True)
            if read.receivers
        ],
        problem=BakeProblem(
            islands=[
                _island([*staying.values(), *others], bounces),
                *(_island([read], bounces) for ob, read in chosen.items() if ob not in staying),
            ],
            settings=settings,
            fingerprint=_fingerprint(
                [*((spaces[ob], read) for ob, read in chosen.items()), *(("SCENE", read) for read in others)],
                everything,
            ),
        ),
        notices=notices,
        radii=[(ob.name_full, _radius(read)) for ob, read in staying.items()]
        + [("", _radius(read)) for read in others],
    )


def survey(
    context: bpy.types.Context, objects: Sequence[bpy.types.Object], others: bool, bounces: bool
) -> list[Evidence | None]:
    """What bakes of `objects` would depend on, each on its own: without its receivers; None of what does not render.

    Args:
        others: whether to look at all that stands around them.
        bounces: whether to look at colours.
    """
    spaces: dict[bpy.types.Object, Space] = dict.fromkeys(objects, "SCENE")
    with AlbedoReader() as albedos:
        request = _Request(spaces, others, False, bounces)
        found = as_rendered(context, lambda depsgraph: _read_all(depsgraph, request, albedos))
        drafts = {ob: one.draft for ob, one in found.chosen.items() if one.draft}
        own = {ob: draft.complete().identity for ob, draft in drafts.items()}
        blocking = {ob: draft.blocks for ob, draft in drafts.items()}
        around = [draft.complete().identity for _, draft in found.others]
    everything = IdentitySum.of([*(own[ob] for ob in own if blocking[ob]), *around])
    return [
        Evidence(own[ob], found.chosen[ob].matrix, everything.without(own[ob]) if blocking[ob] else everything)
        if ob in own
        else None
        for ob in objects
    ]


def own_axes_matrix(ob: bpy.types.Object) -> npt.NDArray[np.float64]:
    """(4, 4) what is left of an object's matrix in its own axes: its scale, positive, without turn and place.

    A bake with this matrix is the same wherever the object is turned to.

    Raises:
        MeshError: if the axes are not at right angles: light cannot be turned into them.
    """
    matrix = _own_axes_matrix(np.array(ob.matrix_world))
    if matrix is None:
        raise MeshError(Notice(_SHEARED, ob.name).sentence)
    return matrix


def _own_axes_matrix(world: npt.NDArray[np.float64]) -> npt.NDArray[np.float64] | None:
    axes = own_axes(world)
    if not np.allclose(axes.T @ axes, np.eye(3), rtol=0.0, atol=_RIGHT_ANGLE):
        return None
    return np.diag([*np.linalg.norm(world[:3, :3], axis=0), 1.0])


def _read_all(depsgraph: bpy.types.Depsgraph, request: _Request, albedos: AlbedoReader) -> _Found:
    """Everything that a depsgraph of renders shows."""
    found = _Found()
    for instance in depsgraph.object_instances:
        if not instance.show_self:
            continue
        ob, is_own_place = instance.object.original, not instance.is_instance
        blocks, matrix = blocks_light(instance), np.array(instance.matrix_world)
        if is_own_place and ob in request.spaces:
            found.chosen[ob] = _read_chosen(ob, instance.object, matrix, blocks, request, albedos)
            if request.spaces[ob] == "SCENE":
                continue
        if not request.around or not blocks or not np.isfinite(matrix).all():
            continue
        draft = _read_other(instance.object, matrix, request.bounces and request.receives, request.bounces, albedos)
        if draft and draft.is_finite:
            found.others.append((ob if is_own_place else None, draft))
            if instance.is_instance and _is_unlit(instance, request.spaces):
                found.instances[instance.parent.original] += 1
    return found


def _read_chosen(
    ob: bpy.types.Object,
    evaluated: bpy.types.Object,
    world: npt.NDArray[np.float64],
    blocks: bool,
    request: _Request,
    albedos: AlbedoReader,
) -> _Chosen:
    """An object to bake: in world space, or in its own axes and with its own surface as its occluder."""
    chosen, matrix = _Chosen(matrix=world), world
    if not np.isfinite(world).all():
        chosen.why_not = _NOT_FINITE
        return chosen
    if np.linalg.matrix_rank(world[:3, :3]) < 2:
        chosen.why_not = _FLAT
    if request.spaces[ob] == "OBJECT":
        own = _own_axes_matrix(world)
        matrix, blocks = (world, blocks) if own is None else (own, True)
        chosen.why_not = _SHEARED if own is None else None
    with _as_mesh(evaluated) as mesh:
        if not len(mesh.polygons):
            chosen.why_not = _NO_FACES
        if request.receives and chosen.why_not:
            return chosen
        chosen.draft = _read_mesh(evaluated, mesh, matrix, world, blocks, request.receives, request.bounces, albedos)
        if not chosen.draft.is_finite:
            chosen.why_not = _NOT_FINITE
        if request.receives and not _can_hold(ob, mesh):
            chosen.carried = Geometry.of(mesh)
    return chosen


@contextmanager
def _as_mesh(evaluated: bpy.types.Object) -> Iterator[bpy.types.Mesh]:
    """The mesh of an evaluated object. Whatever happens it is given back: instances are copies of their object, and one
    that finds a mesh it has not made crashes Blender (5.2).
    """
    try:
        yield evaluated.to_mesh()
    finally:
        evaluated.to_mesh_clear()


def _read_other(
    shown: bpy.types.Object, matrix: npt.NDArray[np.float64], receives: bool, bounces: bool, albedos: AlbedoReader
) -> _Draft | None:
    """Something that blocks light; None if it has no surface."""
    if shown.type != "MESH":
        surface = strands(shown, matrix)
        return _Draft(surface, surface_identity(surface.vertices, surface.triangles), True) if surface else None
    with _as_mesh(shown) as mesh:
        return _read_mesh(shown, mesh, matrix, matrix, True, receives, bounces, albedos) if mesh else None


def _read_mesh(
    evaluated: bpy.types.Object,
    mesh: bpy.types.Mesh,
    matrix: npt.NDArray[np.float64],
    place: npt.NDArray[np.float64],
    blocks: bool,
    receives: bool,
    bounces: bool,
    albedos: AlbedoReader,
) -> _Draft:
    """Read what is asked for; `place` is where colours are looked up, if that is not the matrix."""
    original = evaluated.original
    derived = original.type == "MESH" and not same_topology(original.data, mesh)
    surface, sides = blocking_faces(evaluated, mesh, read_surface(mesh, matrix))
    return _Draft(
        surface,
        identity(mesh, matrix, sides, original if derived else None),
        blocks,
        _with_faces(read_receivers(evaluated.original.name_full, mesh, matrix), surface) if receives else None,
        albedos.read(evaluated, mesh, surface, place) if bounces else None,
    )


def _with_faces(receivers: ObjectReceivers, surface: Surface) -> ObjectReceivers:
    """The same receivers, and the triangles between them."""
    return replace(receivers, group=replace(receivers.group, faces=receivers.at_corners(surface).astype(np.int32)))


def _can_hold(ob: bpy.types.Object, evaluated: bpy.types.Mesh) -> bool:
    """Whether an object's own mesh has room for its transport: as many vertices as render, and nobody else to show it."""
    return not is_shared(ob) and same_topology(ob.data, evaluated)


def _is_unlit(instance: bpy.types.DepsgraphObjectInstance, spaces: Mapping[bpy.types.Object, Space]) -> bool:
    """Whether an instance shows no transport: that of its source fits where it is baked for its own axes."""
    source, parent = instance.object.original, instance.parent
    if parent is None or instance.object.type != "MESH" or parent.original.type in choose.SOLID_TYPES:
        return False
    carries = source.type == "MESH" and is_baked(transport_mesh(source))
    return spaces.get(source) != "OBJECT" and not (carries and space_of(transport_mesh(source)) == "OBJECT")


def _left_out(wanted: Sequence[bpy.types.Object], found: _Found) -> list[Notice]:
    """A notice on each object that was asked for and cannot be baked."""
    notices = []
    for ob in wanted:
        one = found.chosen.get(ob)
        kind = one.why_not if one else _HIDDEN
        if kind:
            notices.append(Notice(kind, ob.name))
    return notices


def _radius(read: _Read) -> float:
    """Half of the diagonal of its box."""
    return float(np.linalg.norm(np.ptp(read.surface.vertices, axis=0))) / 2.0 if len(read.surface.vertices) else 0.0


def _around(everything: IdentitySum, read: _Read) -> IdentitySum:
    """All that blocks light beside one that was read."""
    return everything.without(read.identity) if read.blocks else everything


def _numbers(stay: Sequence[bool], others: int) -> list[int]:
    """The number of each object's group: those that stay come first, then what stands around them, then each of the rest."""
    counts = {True: iter(range(len(stay))), False: iter(range(sum(stay) + others, len(stay) + others))}
    return [next(counts[one]) for one in stay]


def _island(read: Sequence[_Read], bounces: bool) -> Island:
    """Of objects that shade each other."""
    return Island([one.receivers.group for one in read if one.receivers], _joined(read, bounces))


def _fingerprint(receiving: Iterable[tuple[str, _Read]], everything: IdentitySum) -> str:
    """Of those that receive light and what they are baked for, and of all that blocks it. Colours play no part."""
    parts = [f"{everything.occluders:x}".encode()]
    for space, read in receiving:
        if read.receivers:
            own = read.identity
            parts += [space.encode(), own.shape, own.normals, own.placement]
    return digest(*parts).hex()


def _joined(read: Sequence[_Read], bounces: bool) -> Occluders:
    """All surfaces as one; with bounces, also the receivers at their corners and their albedo.

    Receivers are counted as they are given, but surfaces are laid out by what they are: sums over what rays hit then
    run in the same order, and have the same bits, whichever objects were selected.
    """
    first_receiver = _starts(len(one.receivers.group) if one.receivers else 0 for one in read)
    order = sorted((i for i, one in enumerate(read) if one.blocks), key=lambda i: read[i].identity.numbers)
    laid_out = [read[i] for i in order]
    if not laid_out:
        return Occluders(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int32))
    surfaces = [one.surface for one in laid_out]
    vertices = np.concatenate([surface.vertices for surface in surfaces])
    first_vertex = _starts(len(surface.vertices) for surface in surfaces)
    triangles = np.concatenate(
        [surface.triangles + start for surface, start in zip(surfaces, first_vertex, strict=True)], dtype=np.int32
    )
    one_sided = np.concatenate([surface.one_sided for surface in surfaces])
    if not bounces:
        return Occluders(vertices, triangles, one_sided=one_sided)
    corner_receiver = np.concatenate(
        [_receivers_at_corners(one, int(first_receiver[i])) for i, one in zip(order, laid_out, strict=True)]
    )
    return Occluders(vertices, triangles, corner_receiver, _joined_albedo(laid_out), one_sided)


def _receivers_at_corners(one: _Read, first: int) -> npt.NDArray[np.int64]:
    """(T, 3) counted from the first of its own; -1 where nothing was read that could bounce light, as at hair."""
    if one.receivers is None:
        return np.full(one.surface.triangles.shape, -1, dtype=np.int64)
    return one.receivers.at_corners(one.surface) + first


def _joined_albedo(read: Sequence[_Read]) -> Albedo:
    first_triangle = _starts(len(one.surface.triangles) for one in read)
    constants = [
        one.albedo.constant if one.albedo else np.zeros(one.surface.triangles.shape, dtype=np.float32) for one in read
    ]
    patterns = tuple(
        replace(pattern, triangles=pattern.triangles + start)
        for one, start in zip(read, first_triangle, strict=True)
        for pattern in (one.albedo.patterns if one.albedo else ())
    )
    return Albedo(np.concatenate(constants), patterns)


def _starts(sizes: Iterable[int]) -> npt.NDArray[np.int64]:
    """Where each of some runs begins when they are laid end to end."""
    ends = np.cumsum(list(sizes))
    return np.concatenate([[0], ends[:-1]])
