# SPDX-License-Identifier: GPL-3.0-or-later
"""Remembers what a bake changes of a file, to bring it back bit for bit: layers, carriers, materials, the light.

Blocks are known by their identifiers in this session, as undo may have replaced them, and people renamed them, since.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import bpy

from ...session import session
from ..blender.modes import by_uid, object_mode
from ..mesh import carrier, layers
from ..shading import our_nodes, shading
from .lent_light import LentLight


@dataclass(frozen=True)
class _Held:
    """Of one object."""

    uid: int
    mesh: int
    layers: layers.Snapshot
    carrier: carrier.Snapshot


class Before:
    """A file before a bake of some objects: what the bake will change of it.

    light: what was lent to a world that had none.
    """

    def __init__(self, objects: Iterable[bpy.types.Object]) -> None:
        objects = list(objects)
        self._held = [
            _Held(ob.session_uid, ob.data.session_uid, layers.Snapshot.of(ob.data), carrier.Snapshot.of(ob))
            for ob in objects
        ]
        self._newly_relit = set[int]()
        self._fake_users = set[int]()
        self.carriers = carrier.ours()
        self.light: LentLight | None = None

    def hold(self) -> None:
        """Have the file keep the carriers of now, though nothing shows them for a while: undo and saving drop others."""
        for held in self._held:
            found = by_uid(bpy.data.objects, held.carrier.carrier)
            if found and not found.use_fake_user:
                found.use_fake_user = True
                self._fake_users.add(held.carrier.carrier)

    def note_relit(self, material: bpy.types.Material) -> None:
        """Note that a material may have been relit that was not."""
        self._newly_relit.add(material.session_uid)

    def put_back(self) -> list[str]:
        """Bring all that was noted back.

        Returns:
            Names of objects whose meshes have other elements by now, so that their earlier layers are gone.
        """
        lost = []
        objects = {ob.session_uid: ob for ob in bpy.data.objects}
        meshes = {mesh.session_uid: mesh for mesh in bpy.data.meshes}
        with object_mode(bpy.context):
            for held in self._held:
                ob, mesh = objects.get(held.uid), meshes.get(held.mesh)
                if mesh and not held.layers.restore(mesh):
                    lost.append(mesh.name)
                if ob and ob.type == "MESH":
                    held.carrier.restore(ob)
            carrier.sweep(but=self.carriers)
        for uid in self._fake_users:
            if found := objects.get(uid):
                found.use_fake_user = False
        if self.light:
            self.light.take_back()
        materials = [material for material in bpy.data.materials if material.session_uid in self._newly_relit]
        shading.restore(
            filter(our_nodes.is_relit, materials), [objects[held.uid] for held in self._held if held.uid in objects]
        )
        return lost


def take_back() -> list[str]:
    """Bring back what a preview has replaced, if one is shown; returns as `Before.put_back`."""
    before, session.before = session.before, None
    return before.put_back() if before else []
