# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads the scene as it renders: receivers of the objects to bake, and all that blocks light or bounces it.

Reading has two steps, as Cycles cannot evaluate a material while another render goes on. While Blender shows the scene as
it renders, everything becomes arrays; after that, Cycles evaluates the colours that are still missing.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace

import bpy
import numpy as np
import numpy.typing as npt

from ...core.files import digest
from ...core.layout import Space
from ...core.notices import Kind, Notice
from ...core.problem import BakeSettings
from ..blender.rendered import as_rendered
from ..material.albedo import AlbedoDraft
from ..material.opacity import OpacityDraft
from ..material.readers import MaterialReaders
from ..mesh.carrier import Geometry, is_shared, transport_mesh
from ..mesh.layers import is_baked, space_of
from ..mesh.meshes import ObjectReceivers, Surface, own_axes, read_receivers, read_surface, same_topology
from ..mesh.record import Evidence, Identity, IdentitySum, mesh_identity, surface_identity
from ..mesh.strands import strands
from . import choose
from .assemble import ReadObject, bake_plan
from .blocking import blocking_faces, blocks_light, shows_backs
from .islands import Read
from .plan import BakePlan

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
class _Draft:
    """The same while the scene is shown as it renders: albedo and opacity may still wait for Cycles.

    blocks: whether it blocks light; what does not may still receive it.
    """

    surface: Surface
    identity: Identity
    blocks: bool
    receivers: ObjectReceivers | None = None
    albedo: AlbedoDraft | None = None
    opacity: OpacityDraft | None = None

    @property
    def is_finite(self) -> bool:
        return bool(np.isfinite(self.surface.vertices).all())

    def complete(self) -> Read:
        """To be called when nothing renders any more."""
        albedo = self.albedo.complete() if self.albedo else None
        opacity = self.opacity.complete() if self.opacity else None
        known = replace(self.identity, colours=albedo.identity) if albedo else self.identity
        if opacity:
            known = replace(known, shape=digest(known.shape, opacity.identity))
        return Read(self.surface, known, self.blocks, self.receivers, albedo, opacity)


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

    chosen: of the objects to bake, those that render.
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
    with_others: whether to read all that stands around them.
    receives: whether to read receivers of the objects; those of all else if light bounces, too.
    bounces: whether to read colours.
    """

    spaces: Mapping[bpy.types.Object, Space]
    with_others: bool
    receives: bool
    bounces: bool


def read_bake(
    context: bpy.types.Context, objects: Sequence[bpy.types.Object], settings: BakeSettings = SHADOWED
) -> BakePlan:
    """Read receivers of `objects`, and the surfaces of these and of everything that renders.

    Args:
        context: whose scene and view layer render.
        objects: to bake.
        settings: of the bake; if light bounces, all surfaces also need albedo and receivers of their own.

    Raises:
        MeshError: if none of the objects can be baked. Where only some cannot, the plan's notices say so.
    """
    bounces = settings.bounces_light
    wanted, notices = choose.sorted_out(objects)
    spaces: dict[bpy.types.Object, Space] = {ob: ob.prt.space for ob in wanted}
    with MaterialReaders() as materials:
        request = _Request(spaces, "SCENE" in spaces.values(), True, bounces)
        found = as_rendered(context, lambda depsgraph: _read_all(depsgraph, request, materials))
        baked = {ob: one for ob in wanted if (one := found.chosen.get(ob)) and one.draft and not one.why_not}
        chosen = {ob: one.draft.complete() for ob, one in baked.items() if one.draft}
        others = [draft.complete() for _, draft in found.others] if "SCENE" in map(spaces.get, baked) else []
    notices += _left_out(wanted, found)
    if not chosen:
        raise choose.nothing_chosen(context, notices)
    notices += [notice for read in (*chosen.values(), *others) for notice in read.notices]
    notices += (
        choose.instance_notices(found.instances) + choose.strand_notices(context) + choose.no_mesh_notices(context)
    )
    objects = [ReadObject(ob, read, spaces[ob], baked[ob].matrix, baked[ob].carried) for ob, read in chosen.items()]
    return bake_plan(objects, others, settings, notices)


def survey(
    context: bpy.types.Context, objects: Sequence[bpy.types.Object], others: bool, bounces: bool
) -> list[Evidence | None]:
    """Find what each bake of `objects` would depend on, without reading receivers; None for what does not render.

    Args:
        context: whose scene and view layer render.
        objects: whose bakes are looked at.
        others: whether to look at all that stands around them.
        bounces: whether to look at colours.
    """
    spaces: dict[bpy.types.Object, Space] = dict.fromkeys(objects, "SCENE")
    with MaterialReaders() as materials:
        request = _Request(spaces, others, False, bounces)
        found = as_rendered(context, lambda depsgraph: _read_all(depsgraph, request, materials))
        drafts = {ob: one.draft for ob, one in found.chosen.items() if one.draft}
        identities = {ob: draft.complete().identity for ob, draft in drafts.items()}
        blocking = {ob: draft.blocks for ob, draft in drafts.items()}
        everything = IdentitySum.of(
            [
                *(one for ob, one in identities.items() if blocking[ob]),
                *(draft.complete().identity for _, draft in found.others),
            ]
        )
    return [
        Evidence(
            identities[ob], found.chosen[ob].matrix, everything.without(identities[ob]) if blocking[ob] else everything
        )
        if ob in identities
        else None
        for ob in objects
    ]


def _own_axes_matrix(world: npt.NDArray[np.float64]) -> npt.NDArray[np.float64] | None:
    """(4, 4) what is left of an object's matrix in its own axes: its scale, positive, without turn and place.

    A bake with this matrix is the same wherever the object is turned to. None if the axes are not at right angles: light cannot be
    turned into them.
    """
    axes = own_axes(world)
    if not np.allclose(axes.T @ axes, np.eye(3), rtol=0.0, atol=_RIGHT_ANGLE):
        return None
    return np.diag([*np.linalg.norm(world[:3, :3], axis=0), 1.0])


def _read_all(depsgraph: bpy.types.Depsgraph, request: _Request, materials: MaterialReaders) -> _Found:
    """Everything that a depsgraph of renders shows."""
    found = _Found()
    for instance in depsgraph.object_instances:
        if not instance.show_self:
            continue
        ob, is_own_place = instance.object.original, not instance.is_instance
        blocks, matrix = blocks_light(instance), np.array(instance.matrix_world)
        if is_own_place and ob in request.spaces:
            found.chosen[ob] = _read_chosen(ob, instance.object, matrix, blocks, request, materials)
            if request.spaces[ob] == "SCENE":
                continue
        if not request.with_others or not blocks or not np.isfinite(matrix).all():
            continue
        draft = _read_other(instance.object, matrix, request.bounces and request.receives, request.bounces, materials)
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
    materials: MaterialReaders,
) -> _Chosen:
    """An object to bake: in world space, or in its own axes and with its own surface as its occluder."""
    chosen, matrix = _Chosen(matrix=world), world
    if not np.isfinite(world).all():
        chosen.why_not = _NOT_FINITE
        return chosen
    if np.linalg.matrix_rank(world[:3, :3]) < 2:
        chosen.why_not = _FLAT
    if request.spaces[ob] == "OBJECT":
        in_own_axes = _own_axes_matrix(world)
        matrix, blocks = (world, blocks) if in_own_axes is None else (in_own_axes, True)
        chosen.why_not = _SHEARED if in_own_axes is None else None
    with _as_mesh(evaluated) as mesh:
        if not len(mesh.polygons):
            chosen.why_not = _NO_FACES
        if request.receives and chosen.why_not:
            return chosen
        chosen.draft = _read_mesh(evaluated, mesh, matrix, world, blocks, request.receives, request.bounces, materials)
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
    shown: bpy.types.Object, matrix: npt.NDArray[np.float64], receives: bool, bounces: bool, materials: MaterialReaders
) -> _Draft | None:
    """Something that blocks light; None if it has no surface."""
    if shown.type != "MESH":
        surface = strands(shown, matrix)
        return _Draft(surface, surface_identity(surface.vertices, surface.triangles), True) if surface else None
    with _as_mesh(shown) as mesh:
        return _read_mesh(shown, mesh, matrix, matrix, True, receives, bounces, materials) if mesh else None


def _read_mesh(
    evaluated: bpy.types.Object,
    mesh: bpy.types.Mesh,
    matrix: npt.NDArray[np.float64],
    place: npt.NDArray[np.float64],
    blocks: bool,
    receives: bool,
    bounces: bool,
    materials: MaterialReaders,
) -> _Draft:
    """Read what is wanted; `place` is where colours are looked up, if that is not the matrix."""
    original = evaluated.original
    derived = original.type == "MESH" and not same_topology(original.data, mesh)
    surface, sides = blocking_faces(evaluated, mesh, read_surface(mesh, matrix))
    both_sides = shows_backs(original, mesh, surface)
    return _Draft(
        surface,
        mesh_identity(mesh, matrix, sides, original if derived else None, both_sides),
        blocks,
        _receivers(original, mesh, matrix, surface, both_sides) if receives else None,
        materials.albedo.read(evaluated, mesh, surface, place) if bounces else None,
        materials.opacity.read(evaluated, mesh, surface, place),
    )


def _receivers(
    ob: bpy.types.Object, mesh: bpy.types.Mesh, matrix: npt.NDArray[np.float64], surface: Surface, both_sides: bool
) -> ObjectReceivers:
    """The receivers of an object's mesh, and the triangles between them."""
    found = read_receivers(ob.name_full, mesh, matrix)
    fronts = replace(found, group=replace(found.group, faces=found.at_corners(surface).astype(np.int32)))
    return fronts.with_backs() if both_sides else fronts


def _can_hold(ob: bpy.types.Object, evaluated: bpy.types.Mesh) -> bool:
    """Whether an object's own mesh has room for its transport: as many vertices as render, and no other object shows it."""
    return not is_shared(ob) and same_topology(ob.data, evaluated)


def _is_unlit(instance: bpy.types.DepsgraphObjectInstance, spaces: Mapping[bpy.types.Object, Space]) -> bool:
    """Whether an instance shows no transport: that of its source fits where it is baked for its own axes."""
    source, parent = instance.object.original, instance.parent
    if parent is None or instance.object.type != "MESH" or parent.original.type in choose.SOLID_TYPES:
        return False
    carries = source.type == "MESH" and is_baked(transport_mesh(source))
    return spaces.get(source) != "OBJECT" and not (carries and space_of(transport_mesh(source)) == "OBJECT")


def _left_out(wanted: Sequence[bpy.types.Object], found: _Found) -> list[Notice]:
    """A notice on each object that was to be baked and cannot be."""
    notices = []
    for ob in wanted:
        one = found.chosen.get(ob)
        kind = one.why_not if one else _HIDDEN
        if kind:
            notices.append(Notice(kind, ob.name))
    return notices
