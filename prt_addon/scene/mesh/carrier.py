# SPDX-License-Identifier: GPL-3.0-or-later
"""Hangs carriers on objects: meshes that hold transport which an object's own mesh cannot.

Modifiers that add vertices leave no place for values per vertex, and objects that share a mesh see different shadows. Then
the layers lie on a carrier: a mesh object in no collection with the vertices and faces that were baked. One Geometry Nodes
modifier at the end of the object's stack copies them: vertex by vertex where the counts agree, else from the nearest
point of the surface (another level of subdivision in the viewport, an edit since). Nothing is applied, and the file shows
the same without the extension.
"""

from __future__ import annotations

from collections.abc import Container
from dataclasses import dataclass

import bpy
import numpy as np
import numpy.typing as npt

from ...core.layout import BACKS, LAYERS
from ..blender.libraries import is_local
from ..blender.modes import by_uid
from .carrier_group import CARRIER_ENTRY, LightKind, carrier_group, is_carrier_group
from .meshes import Domain, corner_vertices, face_starts, layer_array

MODIFIER = "PRT"
_MARK = "prt_carrier"
_SET = ("show_viewport", "show_render", "show_in_editmode", "show_expanded")
"""Of the modifier: what is put back with it."""


@dataclass(frozen=True)
class Geometry:
    """A mesh for a carrier, in the object's own axes.

    positions: (V, 3) float32.
    corner_vertex: (corners,) int32 the vertex of each.
    face_start: (faces,) int32 the first corner of each.
    """

    positions: npt.NDArray[np.float32]
    corner_vertex: npt.NDArray[np.int32]
    face_start: npt.NDArray[np.int32]

    @classmethod
    def of(cls, mesh: bpy.types.Mesh) -> Geometry:
        """The geometry of an evaluated mesh."""
        return cls(layer_array(mesh, "position", "vector", 3), corner_vertices(mesh), face_starts(mesh))

    @property
    def counts(self) -> tuple[int, int]:
        """The numbers of vertices and face corners."""
        return len(self.positions), len(self.corner_vertex)


def is_carrier(ob: bpy.types.Object) -> bool:
    """Whether an object is a carrier, which users never handle."""
    return _MARK in ob


def carrier_of(ob: bpy.types.Object) -> bpy.types.Object | None:
    """The carrier whose layers an object shows; None if it has none."""
    modifier = _modifier(ob)
    carrier = _entry(modifier) if modifier else None
    return carrier if carrier and carrier.type == "MESH" else None


def transport_mesh(ob: bpy.types.Object) -> bpy.types.Mesh:
    """The mesh that an object's transport lies on, if it has any: its carrier's, or its own."""
    carrier = carrier_of(ob)
    return carrier.data if carrier else ob.data


def is_shared(ob: bpy.types.Object) -> bool:
    """Whether other objects show the same mesh."""
    return ob.data.users > 1 and any(
        other != ob and other.data == ob.data and not is_carrier(other) for other in bpy.data.objects
    )


def hang(ob: bpy.types.Object, geometry: Geometry, domain: Domain, with_backs: bool = False) -> bpy.types.Mesh:
    """Give an object a new carrier without layers, in place of an earlier one, and the modifier that shows it.

    Call `sweep` when all objects have theirs.

    Args:
        ob: the object.
        geometry: of the carrier.
        domain: of the layers.
        with_backs: whether those of backs are among them.

    Returns:
        The carrier's mesh, for layers on points or corners.
    """
    carrier = bpy.data.objects.new(f"{ob.name} PRT", _mesh(f"{ob.name} PRT", geometry))
    carrier[_MARK] = True
    carrier.hide_render = carrier.hide_viewport = carrier.hide_select = True
    carrier.scale = (0.0, 0.0, 0.0)  # appending an object puts its carrier into the scene, and in sight
    modifier = _modifier(ob) or ob.modifiers.new(MODIFIER, "NODES")
    modifier.node_group = carrier_group(domain, with_backs)
    modifier.show_viewport = modifier.show_render = True
    modifier.show_expanded = False
    _set_entry(modifier, carrier)
    ob.modifiers.move(ob.modifiers.find(modifier.name), len(ob.modifiers) - 1)
    return carrier.data


def show_light(ob: bpy.types.Object, light: LightKind) -> None:
    """Have an object's modifier copy frozen light, too, which lies on its carrier beside the layers. Call `sweep` afterwards."""
    modifier, carrier = _modifier(ob), carrier_of(ob)
    if modifier and carrier:
        layers = carrier.data.attributes
        domain: Domain = "POINT" if layers[LAYERS[0]].domain == "POINT" else "CORNER"
        modifier.node_group = carrier_group(domain, BACKS[0] in layers, light)
        _set_entry(modifier, carrier)


@dataclass(frozen=True)
class Snapshot:
    """How an object shows its carrier, to restore that; until `sweep`, nothing is gone.

    modifier: the name of the modifier that shows it; None if there is none.
    place: of the modifier in the stack.
    settings: what is set of it.
    group, carrier: by their identifiers in this session; 0 for none.
    """

    modifier: str | None = None
    place: int = 0
    settings: tuple[tuple[str, bool], ...] = ()
    group: int = 0
    carrier: int = 0

    @classmethod
    def of(cls, ob: bpy.types.Object) -> Snapshot:
        """Take the snapshot of an object as it is."""
        modifier = _modifier(ob)
        if modifier is None:
            return cls()
        entry = _entry(modifier)
        return cls(
            modifier.name,
            ob.modifiers.find(modifier.name),
            tuple((name, getattr(modifier, name)) for name in _SET),
            modifier.node_group.session_uid,
            entry.session_uid if entry else 0,
        )

    def restore(self, ob: bpy.types.Object) -> None:
        """Show that carrier again, or none."""
        if self.modifier is None:
            take_off(ob)
            return
        modifier = _modifier(ob) or ob.modifiers.new(self.modifier, "NODES")
        modifier.node_group = by_uid(bpy.data.node_groups, self.group)
        for name, value in self.settings:
            setattr(modifier, name, value)
        if modifier.node_group:
            _set_entry(modifier, by_uid(bpy.data.objects, self.carrier))
        ob.modifiers.move(ob.modifiers.find(modifier.name), self.place)


def take_off(ob: bpy.types.Object) -> bool:
    """Remove the modifier that shows a carrier, which `sweep` removes then; True if there was one."""
    modifier = _modifier(ob)
    if modifier:
        ob.modifiers.remove(modifier)
    return modifier is not None


def ours() -> set[int]:
    """The identifiers in this session of all carriers and their node groups."""
    blocks = [*filter(is_carrier, bpy.data.objects), *filter(is_carrier_group, bpy.data.node_groups)]
    return {block.session_uid for block in blocks}


def sweep(but: Container[int] = ()) -> None:
    """Remove carriers that no object shows any more, and node groups that no modifier uses; name the rest after their objects.

    Args:
        but: those of `ours` that are left as they are.
    """
    shown = {carrier: ob for ob in bpy.data.objects if (carrier := carrier_of(ob))}
    gone = [
        ob
        for ob in bpy.data.objects
        if is_carrier(ob) and is_local(ob) and ob not in shown and ob.session_uid not in but
    ]
    meshes = [ob.data for ob in gone]
    bpy.data.batch_remove(gone)
    bpy.data.batch_remove([mesh for mesh in meshes if not mesh.users])
    groups = [tree for tree in bpy.data.node_groups if is_carrier_group(tree) and is_local(tree)]
    bpy.data.batch_remove([tree for tree in groups if not tree.users and tree.session_uid not in but])
    for carrier, ob in shown.items():
        if is_local(carrier) and carrier.session_uid not in but:
            _name(carrier, ob)


def put_away() -> None:
    """Take carriers out of all collections, where appending brought them."""
    for carrier in filter(is_carrier, bpy.data.objects):
        for collection in carrier.users_collection if is_local(carrier) else ():
            if is_local(collection):
                collection.objects.unlink(carrier)


def _name(carrier: bpy.types.Object, ob: bpy.types.Object) -> None:
    """What it is called is a help for people alone."""
    name = f"{ob.name} PRT"
    if not carrier.name.startswith(name):
        carrier.name = name
    elif carrier.name != name and name not in bpy.data.objects:
        carrier.name = carrier.data.name = name


def _modifier(ob: bpy.types.Object) -> bpy.types.Modifier | None:
    for modifier in ob.modifiers:
        if modifier.type == "NODES" and is_carrier_group(modifier.node_group):
            return modifier
    return None


def _mesh(name: str, geometry: Geometry) -> bpy.types.Mesh:
    mesh = bpy.data.meshes.new(name)
    vertices, corners = geometry.counts
    mesh.vertices.add(vertices)
    mesh.loops.add(corners)
    mesh.polygons.add(len(geometry.face_start))
    mesh.vertices.foreach_set("co", geometry.positions.reshape(-1))
    mesh.loops.foreach_set("vertex_index", geometry.corner_vertex)
    mesh.polygons.foreach_set("loop_start", geometry.face_start)
    mesh.update(calc_edges=True)
    return mesh


_INPUTS_ARE_PROPERTIES = "properties" not in bpy.types.NodesModifier.bl_rna.properties
"""Before 5.2, a node modifier's inputs are its custom properties."""


def _identifier(tree: bpy.types.NodeTree) -> str:
    return next(str(item.identifier) for item in tree.interface.items_tree if item.name == CARRIER_ENTRY)


def _entry(modifier: bpy.types.Modifier) -> bpy.types.Object | None:
    """The object that a modifier of ours reads."""
    name = _identifier(modifier.node_group)
    if _INPUTS_ARE_PROPERTIES:
        return modifier.get(name)
    entry = getattr(modifier.properties.inputs, name, None)
    return entry.value if entry else None


def _set_entry(modifier: bpy.types.Modifier, carrier: bpy.types.Object) -> None:
    name = _identifier(modifier.node_group)
    if _INPUTS_ARE_PROPERTIES:
        modifier[name] = carrier
        modifier.id_data.update_tag()  # a custom property alone causes no update
    else:
        getattr(modifier.properties.inputs, name).value = carrier
