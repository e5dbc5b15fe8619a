# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes that cannot hold transport as they are, and the copies that can: shared meshes, and modifiers that add vertices.

Both are offered as explicit settings. The receivers of a bake are read from the evaluated mesh, so that nothing has to
be changed before the whole bake is there; then each such object gets a mesh of its own. Nothing is lost: an object
whose modifiers were applied leaves a copy of itself behind, in no collection and with a fake user, that keeps its
mesh, shape keys and modifiers.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field

import bpy

from ...core.errors import MeshError
from ..blender.libraries import check_own
from ..mesh import layers
from ..mesh.meshes import same_topology
from ..mesh.record import check_version
from ..settings import Preparation

NOTHING = Preparation()


@dataclass
class OwnMeshes:
    """The meshes that some objects are about to get.

    meshes: of those objects that need another one, not yet theirs.
    applied: those of them whose modifiers it replaces.
    notes: what was done, one sentence each; filled when it is done.
    """

    meshes: dict[bpy.types.Object, bpy.types.Mesh] = field(default_factory=dict)
    applied: set[bpy.types.Object] = field(default_factory=set)
    notes: list[str] = field(default_factory=list)

    def mesh_of(self, ob: bpy.types.Object) -> bpy.types.Mesh:
        """The mesh that will be the object's."""
        return self.meshes.get(ob, ob.data)


def check_bakeable(ob: bpy.types.Object, evaluated: bpy.types.Mesh, allowed: Preparation = NOTHING) -> None:
    """Raises MeshError, saying what to do, unless `ob` has, or may be given, a mesh that can hold its transport."""
    mesh = ob.data
    check_own(mesh, f"Mesh '{mesh.name}' of '{ob.name}'", "bake", MeshError)
    check_version(ob)
    keeps_topology = same_topology(mesh, evaluated)
    if keeps_topology and not allowed.make_single_user:
        _check_single_user(ob)
    if not len(mesh.polygons if keeps_topology else evaluated.polygons):
        raise MeshError(f"Object '{ob.name}' has no faces: add some, deselect it, or hide it from renders.")
    if keeps_topology:
        return
    if not allowed.apply_modifiers:
        raise MeshError(
            f"Modifiers of '{ob.name}' change its topology, so that vertex values cannot be stored: turn on 'Apply "
            "Modifiers' or apply them yourself (Object > Apply > Visual Geometry to Mesh), then bake."
        )
    if ob.particle_systems:
        raise MeshError(
            f"Object '{ob.name}' has particles, which applying its modifiers would change: apply the modifiers that "
            "change its topology yourself, then bake."
        )


def _check_single_user(ob: bpy.types.Object) -> None:
    others = users_of(ob.data) - {ob} if ob.data.users > 1 else set()
    if others:
        names = ", ".join(sorted(f"'{user.name}'" for user in others))
        raise MeshError(
            f"Mesh '{ob.data.name}' is shared by '{ob.name}' and {names}, which see different shadows: turn on 'Make "
            "Single User' or make it single-user yourself (Object > Relations > Make Single User > Object & Data), "
            "then bake."
        )


def users_of(mesh: bpy.types.Mesh) -> set[bpy.types.Object]:
    """The objects that show a mesh; those in no collection show nothing."""
    return {ob for ob in bpy.data.objects if ob.data == mesh and ob.users_collection}


@contextmanager
def own_meshes(
    context: bpy.types.Context, objects: Sequence[bpy.types.Object], allowed: Preparation
) -> Iterator[OwnMeshes]:
    """Meshes of their own for the objects that need them: made on entry, theirs on exit, gone after an error.

    The checks that may still find a reason not to write go inside. To be used in Object Mode.
    """
    own = OwnMeshes()
    try:
        if allowed != NOTHING:
            _make(context, objects, allowed, own)
        yield own
    except BaseException:
        for mesh in own.meshes.values():
            bpy.data.meshes.remove(mesh)
        raise
    for ob, mesh in own.meshes.items():
        if ob in own.applied:
            own.notes.append(_take_applied(ob, mesh))
        else:
            own.notes.append(f"'{ob.name}' got a copy '{mesh.name}' of its own of mesh '{ob.data.name}'.")
            ob.data = mesh


def _make(
    context: bpy.types.Context, objects: Iterable[bpy.types.Object], allowed: Preparation, own: OwnMeshes
) -> None:
    """The new meshes. Of the objects that share one, the last keeps it if all others got copies."""
    depsgraph = context.evaluated_depsgraph_get()
    users: dict[bpy.types.Mesh, set[bpy.types.Object]] = {}
    for ob in objects:
        evaluated = ob.evaluated_get(depsgraph)
        mesh, seen = ob.data, evaluated.to_mesh()
        check_bakeable(ob, seen, allowed)
        sharing = users.setdefault(mesh, users_of(mesh))
        if not same_topology(mesh, seen):
            own.meshes[ob] = _applied(mesh, evaluated, depsgraph)
            own.applied.add(ob)
        elif len(sharing) > 1:
            own.meshes[ob] = mesh.copy()
        else:
            continue
        sharing.discard(ob)


def _applied(mesh: bpy.types.Mesh, evaluated: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> bpy.types.Mesh:
    """The evaluated mesh with all layers, and what evaluation leaves behind: name, custom properties."""
    new = bpy.data.meshes.new_from_object(evaluated, preserve_all_data_layers=True, depsgraph=depsgraph)
    new.name = mesh.name
    for key, value in mesh.items():
        new[key] = value
    return new


def _take_applied(ob: bpy.types.Object, mesh: bpy.types.Mesh) -> str:
    """Give an object the mesh that its modifiers made, and drop those; a copy of the object keeps the former state."""
    kept = ob.copy()
    kept.name = f"{ob.name} (before PRT)"
    kept.use_fake_user = True
    original = ob.data
    materials = [(slot.link, slot.material) for slot in ob.material_slots]
    ob.data = mesh
    for modifier in [each for each in ob.modifiers if each.show_viewport]:  # hidden ones were not evaluated: they stay
        ob.modifiers.remove(modifier)
    for slot, (link, material) in zip(ob.material_slots, materials, strict=False):
        slot.link = link
        if link == "OBJECT":
            slot.material = material
    if not users_of(original):  # an earlier bake of it could never be removed any more: nothing shows it
        layers.remove(original)
    return (
        f"Applied the modifiers of '{ob.name}': object '{kept.name}', in no collection, keeps its mesh "
        f"'{original.name}' and its modifiers."
    )
