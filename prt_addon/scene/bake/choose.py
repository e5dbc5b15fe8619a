# SPDX-License-Identifier: GPL-3.0-or-later
"""Chooses the objects of a bake: the selected meshes, or all that render. What cannot be baked is left out and named."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import bpy

from ...core.errors import MeshError
from ...core.layout import BACKS, LAYERS
from ...core.notices import Kind, Notice, counted
from ..blender.libraries import is_local
from ..mesh.carrier import is_carrier, transport_mesh
from ..mesh.record import is_newer
from ..shading.probe import is_probe

_LINKED = Kind(
    "{name} is linked from a library, or overrides it: make it and its mesh local (Object > Relations > Make Local) to bake it.",
    "{count} objects are linked from libraries, or override them: make them and their meshes local (Object > Relations > "
    "Make Local) to bake them: {names}.",
    fix="object.make_local",
)
_NEWER = Kind(
    "{name} was baked by a newer version of PRT Relight, and is left as it is: use a newer version of the extension here.",
    "{count} objects were baked by a newer version of PRT Relight, and are left as they are: {names}.",
)
_NO_MESH = Kind(
    "{name} is no mesh: it blocks light but is not relit. Convert it (Object > Convert > Mesh) to bake it.",
    "{count} objects are no meshes: they block light but are not relit. Convert them (Object > Convert > Mesh) to bake "
    "them: {names}.",
    "INFO",
)
_INSTANCES = Kind(
    "{name} shows {number} instances: they block light and bounce it, but are not relit. Make them real (Object > Apply > Make "
    "Instances Real), or bake their source for 'Object'.",
    "{count} objects show instances: they block light and bounce it, but are not relit. Make them real (Object > Apply > "
    "Make Instances Real), or bake their sources for 'Object': {names}.",
    "INFO",
)
_TAKEN = Kind(
    "{name} has a vertex group or UV map {taken}, a name that its transport needs: rename that, then bake.",
    "{count} objects have vertex groups or UV maps with names that their transport needs (_PRT_0 ...): rename those, then "
    "bake: {names}.",
)
_STRANDS = Kind(
    "{name} has hair of particles, which renders as strands and blocks no light here: convert it to curves or a mesh for that.",
    "{count} objects have hair of particles, which renders as strands and blocks no light here: convert it to curves or "
    "meshes for that: {names}.",
)
SOLID_TYPES = {"CURVE", "SURFACE", "FONT", "META", "CURVES", "POINTCLOUD"}


def is_subject(ob: bpy.types.Object) -> bool:
    """Whether an object is a mesh that may be baked: light probes and carriers are none."""
    return ob.type == "MESH" and not is_probe(ob.data) and not is_carrier(ob)


def selected_meshes(context: bpy.types.Context) -> list[bpy.types.Object]:
    """The selected objects that are meshes."""
    return [ob for ob in context.selected_objects if ob.type == "MESH"]


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
    """The selected meshes, or all that renders show if nothing is selected; sorted by name.

    Raises:
        MeshError: if there is none.
    """
    selected = list(context.selected_objects)
    chosen = list(filter(is_subject, selected))
    if not chosen and any(not is_carrier(ob) for ob in selected) and not all(is_probe(ob.data) for ob in selected):
        raise MeshError(
            "None of the selected objects is a mesh: select meshes, or deselect all to take all that renders show."
        )
    if not chosen:
        shown = renderable_objects(context.view_layer)
        chosen = [ob for ob in shown if is_subject(ob) and (ob.data.polygons or ob.modifiers)]
    if not chosen:
        raise nothing_chosen(context, no_mesh_notices(context))
    return sorted(chosen, key=lambda ob: ob.name_full)


def nothing_chosen(context: bpy.types.Context, notices: Iterable[Notice], done: str = "baked") -> MeshError:
    """Make the error that says why nothing is left to bake."""
    found = counted(notices)
    if not found:
        return MeshError(
            f"Scene '{context.scene.name}' has no mesh to bake: select one, or make one visible to render."
        )
    return MeshError(f"Nothing can be {done}: " + " ".join(one.sentence for one in found))


def sorted_out(objects: Iterable[bpy.types.Object]) -> tuple[list[bpy.types.Object], list[Notice]]:
    """Sort out the objects that a bake can be written to; a notice on each of the others."""
    kept, notices = [], []
    for ob in objects:
        if not is_local(ob) or not is_local(ob.data):
            notices.append(Notice(_LINKED, ob.name))
        elif is_newer(transport_mesh(ob)):
            notices.append(Notice(_NEWER, ob.name))
        elif taken := _taken(ob):
            notices.append(Notice(_TAKEN, ob.name, {"taken": f"'{taken}'"}))
        else:
            kept.append(ob)
    return kept, notices


def _taken(ob: bpy.types.Object) -> str:
    """A layer's name that something else of a mesh has; empty if none has."""
    others = {group.name for group in ob.vertex_groups} | {layer.name for layer in ob.data.uv_layers}
    return next((name for name in LAYERS + BACKS if name in others), "")


def check_writable(ob: bpy.types.Object) -> None:
    """Raises MeshError if transport cannot be written to an object."""
    _, notices = sorted_out([ob])
    for notice in notices:
        raise MeshError(notice.sentence)


def no_mesh_notices(context: bpy.types.Context) -> list[Notice]:
    """A notice on each chosen object that has a surface but is no mesh: all that render, if nothing is selected."""
    chosen = list(context.selected_objects) or renderable_objects(context.view_layer)
    found = [ob.name for ob in chosen if ob.type in SOLID_TYPES]
    return [Notice(_NO_MESH, name) for name in sorted(found)]


def strand_notices(context: bpy.types.Context) -> list[Notice]:
    """A notice on each rendered object with hair that only renders know how to draw."""
    found = [
        ob.name
        for ob in renderable_objects(context.view_layer)
        if any(
            system.settings.type == "HAIR" and system.settings.render_type == "PATH" and system.settings.count
            for system in ob.particle_systems
        )
    ]
    return [Notice(_STRANDS, name) for name in sorted(found)]


def instance_notices(numbers: Mapping[bpy.types.Object, int]) -> list[Notice]:
    """A notice on each object that shows instances, by their number."""
    return [
        Notice(_INSTANCES, ob.name, {"number": f"{number:,}"})
        for ob, number in sorted(numbers.items(), key=lambda one: one[0].name)
    ]
