# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads baked objects and the world's light for a report, and keeps the last report with the scene."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np
import numpy.typing as npt

from ...core.errors import LightError, MeshError
from ...core.notices import Notice
from ...core.problem import BakeProblem, BakeSettings
from ...core.report.subject import Lighting, Scenery, Subject
from ...core.sky.sampler import reduced
from ..bake import choose
from ..bake.read import read_bake
from ..blender.libraries import is_local
from ..light import light
from ..mesh import layers
from ..mesh.carrier import transport_mesh
from ..mesh.meshes import ObjectReceivers, own_axes
from ..mesh.record import BakeRecord, read_record
from ..sky.projection import lamp_rule, sky_picture
from ..sky.sky import read_sky

LAST_REPORT = "prt_report"
"""Custom property of the scene: the latest report, as JSON."""


@dataclass(frozen=True)
class Baked:
    """One baked object: its full name, what a report measures of it, and where its receivers show.

    carried: whether that is on a carrier.
    """

    name: str
    subject: Subject
    receivers: ObjectReceivers
    carried: bool


def baked_objects(context: bpy.types.Context) -> list[bpy.types.Object]:
    """The objects with a bake, among the selected meshes or all that render.

    Raises:
        MeshError: if none is baked.
    """
    objects = [ob for ob in choose.objects_to_bake(context) if layers.is_baked(transport_mesh(ob))]
    if not objects:
        raise MeshError("None of these objects is baked: press Bake PRT (prt.bake), then report.")
    return objects


def read_baked(context: bpy.types.Context, objects: Sequence[bpy.types.Object]) -> tuple[list[Baked], list[Notice]]:
    """Read baked objects and their stored transport, to be measured. To be called in Object Mode.

    Returns:
        Those that can be read, and a notice on each of the others.

    Raises:
        MeshError: for an object that was changed since its bake so that the layers fit it no more.
    """
    records = {ob.name_full: _record(ob) for ob in objects}
    bounces = any(record.settings.bounces_light for record in records.values())
    plan = read_bake(context, objects, BakeSettings("INTERREFLECTED" if bounces else "SHADOWED"))
    stored = {one.group: _per_receiver(bpy.data.objects[one.name], one.receivers) for one in plan.objects}
    stored |= {
        one.group + 1: _per_back(bpy.data.objects[one.name], one.receivers)
        for one in plan.objects
        if one.receivers.backs
    }
    sceneries = _sceneries(plan.problem, stored)
    baked = []
    for one in plan.objects:
        surface = one.surface
        subject = Subject(
            one.receivers.group,
            records[one.name].settings,
            stored[one.group],
            surface.vertices[surface.triangles],
            one.receivers.at_corners(surface),
            sceneries[one.group],
            own_axes(one.evidence.matrix) if one.space == "OBJECT" else np.eye(3),
        )
        baked.append(Baked(one.name, subject, one.receivers, one.carried is not None))
    return baked, [notice for notice in plan.notices if notice.kind.level == "WARNING"]


def _sceneries(problem: BakeProblem, stored: dict[int, npt.NDArray[np.float32]]) -> list[Scenery]:
    """What surrounds each group of a problem; groups of one island share it."""
    sceneries: list[Scenery] = []
    for island, first, _ in problem.numbered():
        transport = [
            stored.get(first + k, np.full((len(group), 9, 3), np.nan, dtype=np.float32))
            for k, group in enumerate(island.groups)
        ]
        if transport:
            sceneries += [Scenery(island.occluders, island.groups, np.concatenate(transport))] * len(transport)
    return sceneries


def read_lighting(scene: bpy.types.Scene) -> Lighting:
    """Read the SH light that is on the scene's world, and the sky that it stands for.

    Raises:
        LightError: if the world carries no light, or one that is not its sky's.
        PictureError: if the sky's picture cannot be read.
    """
    picture, turn = sky_as_projected(scene)
    stored = light.shown_light(scene.world)
    wanted = light.light_settings_of(scene.world).lamps if shows_lamps(scene.world) else "AUTO"
    picture = reduced(picture) * np.float32(light.strength_of(scene.world))
    has_disc = read_sky(scene).has_sun_disc
    found = Lighting(picture, turn, stored, lamp_rule(wanted), wide=not has_disc)
    if found.lamps.lamps or not has_disc:
        return found
    return Lighting(picture, turn, stored, lamp_rule("ONE"), wide=False)  # as the projection has it


def shows_lamps(world: bpy.types.World) -> bool:
    """Whether lamps of its sky light in EEVEE, in place of their part of the stored light. It must have a light."""
    return bool(light.read_lamps(world).any())


def sky_as_projected(scene: bpy.types.Scene) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float64]]:
    """The sky of the scene's world in full resolution: (H, W, 3) equirectangular radiance at strength 1, row 0 at the
    bottom, and the (3, 3) turn R under which the world shows along w what the picture holds along R w.

    Raises:
        LightError, PictureError: if it cannot be read; the message says why.
    """
    sky = read_sky(scene)
    if not light.has_light(scene.world) or not light.is_projected(scene.world):
        raise LightError(
            f"World '{scene.world.name}' carries no light that follows its sky: press Project World (prt.project_light)."
        )
    bpy.context.view_layer.update()  # the drivers' latest word
    return sky_picture(sky), light.read_turn(scene.world)


def keep(scene: bpy.types.Scene, document: dict[str, Any]) -> None:
    """Store a report with the scene, for the panel and for scripts."""
    scene[LAST_REPORT] = json.dumps(document)


def forget_all() -> None:
    """Drop the reports of all scenes."""
    for scene in bpy.data.scenes:
        if is_local(scene) and LAST_REPORT in scene:
            del scene[LAST_REPORT]


def _record(ob: bpy.types.Object) -> BakeRecord:
    record = read_record(transport_mesh(ob))
    if record is None or not record.settings.samples:
        raise MeshError(f"The transport of '{ob.name}' was not baked here: bake it, then report on it.")
    if record.space != ob.prt.space:
        was, now = record.space.title(), ob.prt.space.title()
        raise MeshError(f"'{ob.name}' was baked for '{was}' and is now set to '{now}': bake it again.")
    return record


def _per_receiver(ob: bpy.types.Object, receivers: ObjectReceivers) -> npt.NDArray[np.float32]:
    """(receivers, 9, 3) the stored transport."""
    mesh = transport_mesh(ob)
    stored = layers.read(mesh)
    if layers.domain_of(mesh) != receivers.domain or len(stored) != len(receivers.element_receiver):
        raise MeshError(f"The transport of '{ob.name}' does not fit its mesh as it is now: bake it again.")
    transport = np.zeros((len(receivers.group), *stored.shape[1:]), dtype=np.float32)
    transport[receivers.element_receiver] = stored
    return transport


def _per_back(ob: bpy.types.Object, receivers: ObjectReceivers) -> npt.NDArray[np.float32]:
    """(receivers, 9, 3) the stored transport of backs; NaN where there is none."""
    mesh = transport_mesh(ob)
    transport = np.full((len(receivers.group), 9, 3), np.nan, dtype=np.float32)
    if layers.has_backs(mesh):
        transport[receivers.element_receiver] = layers.read_backs(mesh)
    return transport
