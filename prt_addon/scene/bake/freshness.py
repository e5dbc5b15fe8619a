# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds which bakes are stale, and why.

`freshness` reads the scene as a bake would, and is as slow; `glance` is for drawing: what can be seen at once, and what
the last check found. That is kept for the session and not in the file, which must not change because it was looked at.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, fields
from math import isclose
from typing import Literal

import bpy

from ...core.bake.previews import extent
from ...core.notices import Kind, Notice
from ...core.problem import BakeSettings
from ...session import session
from ..blender.modes import object_mode
from ..mesh.carrier import transport_mesh
from ..mesh.layers import is_baked
from ..mesh.record import FORMAT_VERSION, BakeRecord, Evidence, read_record, same_transform, transform_of
from ..settings import MODES, SPACES, scene_settings
from .read import survey

_PREVIEW = Kind(
    "{name} holds a preview, {rays}: bake it, or merge its shards, before it renders.",
    "{count} objects hold previews: bake them, or merge their shards, before they render: {names}.",
)
State = Literal["FRESH", "STALE", "NEVER", "UNKNOWN", "NEWER", "UNCHECKED"]
Cause = Literal["PREVIEW", "HIDDEN", "GEOMETRY", "MOVED", "OTHERS", "COLOURS", "SETTINGS"]

_HEADLINES: dict[State, str] = {
    "NEVER": "never baked",
    "UNKNOWN": "of unknown origin",
    "NEWER": "baked by a newer version",
    "UNCHECKED": "baked, not checked",
    "FRESH": "fresh",
    "STALE": "stale",
}
_ADVICE: dict[State, str] = {
    "UNKNOWN": "bake again to be able to check",
    "NEWER": "use a newer version of PRT Relight",
}
_PHRASES: dict[Cause, str] = {
    "HIDDEN": "it does not render any more",
    "GEOMETRY": "its geometry or its sides changed",
    "MOVED": "it was moved",
    "OTHERS": "other objects changed or moved",
    "COLOURS": "colours that light bounces off changed",
}


@dataclass(frozen=True)
class Freshness:
    """What is known of the bake of one object: whether it is stale, and why.

    state: NEVER baked, UNKNOWN because an older version or another program baked it, NEWER because a newer version
        did, UNCHECKED (only `glance`), FRESH or STALE.
    causes: why it is stale, as phrases.
    """

    name: str
    state: State
    causes: dict[Cause, str] = field(default_factory=dict)

    @property
    def lines(self) -> list[str]:
        """What users read: a headline, and then each cause."""
        details = [_ADVICE[self.state]] if self.state in _ADVICE else self.causes.values()
        return [_HEADLINES[self.state], *details]

    @property
    def text(self) -> str:
        """The lines as one."""
        headline, *details = self.lines
        return f"{headline}: {', '.join(details)}" if details else headline


def freshness(
    context: bpy.types.Context, objects: Iterable[bpy.types.Object], settings: BakeSettings | None = None
) -> list[Freshness]:
    """Compare what the bakes of objects depended on with what is there now.

    Args:
        context: whose scene and view layer render.
        objects: that may be baked.
        settings: what they should have been baked with; the scene's if None.
    """
    objects = list(objects)
    with object_mode(context):
        records = {ob: record for ob in objects if (record := _checkable(ob))}
        evidence = survey(
            context,
            list(records),
            others=any(record.settings.casts_rays for record in records.values() if record.space == "SCENE"),
            bounces=any(record.settings.bounces_light for record in records.values()),
        )
        for (ob, record), now in zip(records.items(), evidence, strict=True):
            session.checked[ob.session_uid] = record, _differences(record, now)
        found = [glance(context, ob, settings) for ob in objects]
    _list_stale(context.scene, zip(objects, found, strict=True))
    return found


def stale_objects(
    context: bpy.types.Context, settings: BakeSettings | None = None
) -> dict[bpy.types.Object, Freshness]:
    """The objects of the scene whose bakes are stale, selected or not, and why; as slow as `freshness`."""
    baked = sorted(filter(_checkable, context.scene.objects), key=lambda ob: ob.name_full)
    found = zip(baked, freshness(context, baked, settings), strict=True)
    return {ob: one for ob, one in found if one.state == "STALE"}


def listed_stale(scene: bpy.types.Scene) -> list[Freshness]:
    """The bakes of a scene that were stale when they were last checked, and were not baked since. Cheap enough to be drawn."""
    return list(session.stale.get(scene.session_uid, {}).values())


def note_baked(objects: Iterable[bpy.types.Object], as_read: bool = True) -> None:
    """Note that objects were baked just now: what a check would find is known without one, if they are as they were read."""
    for ob in objects:
        for listed in session.stale.values():
            listed.pop(ob.session_uid, None)
        record = _checkable(ob)
        if record and as_read:
            session.checked[ob.session_uid] = record, frozenset()
        else:
            session.checked.pop(ob.session_uid, None)


def preview_notices(objects: Iterable[bpy.types.Object]) -> list[Notice]:
    """Make a notice on each object that shows a preview: of a bake that runs, was kept, or was not over when the file was saved."""
    records = [(ob.name, _record(ob)) for ob in objects]
    return [
        Notice(_PREVIEW, name, {"rays": extent(record.settings, record.preview_of)})
        for name, record in records
        if record and record.preview_of
    ]


def glance(context: bpy.types.Context, ob: bpy.types.Object, settings: BakeSettings | None = None) -> Freshness:
    """Judge the bake of an object without reading its mesh: cheap enough to be drawn.

    Moves, other settings and other numbers of vertices are seen at once, all else as the last check found it.
    Arguments as those of `freshness`.
    """
    record = _record(ob)
    if record is None:
        return Freshness(ob.name, "NEVER")
    if record.fingerprint is None:
        return Freshness(ob.name, "NEWER" if record.version > FORMAT_VERSION else "UNKNOWN")
    judged, found = session.checked.get(ob.session_uid, (None, frozenset[Cause]()))
    checked = judged == record  # another bake since then is another matter
    causes: set[Cause] = set(found) if checked else set()
    if record.elements != (len(ob.data.vertices), len(ob.data.loops)):
        causes.add("GEOMETRY")
    if not same_transform(
        record.fingerprint.transform, transform_of(ob.matrix_world, record.settings.mode, record.space)
    ):
        causes.add("MOVED")
    phrases: dict[Cause, str] = {cause: phrase for cause, phrase in _PHRASES.items() if cause in causes}
    other_settings = _other_settings(record, settings or scene_settings(context.scene), ob.prt.space)
    if record.preview_of:
        phrases = {"PREVIEW": f"it is a preview, {extent(record.settings, record.preview_of)}", **phrases}
    elif other_settings:
        phrases["SETTINGS"] = f"baked with other settings ({other_settings})"
    if phrases:
        return Freshness(ob.name, "STALE", phrases)
    return Freshness(ob.name, "FRESH" if checked else "UNCHECKED")


def _list_stale(scene: bpy.types.Scene, checked: Iterable[tuple[bpy.types.Object, Freshness]]) -> None:
    """Keep what a check of some objects found, beside what is known of the others that are still there."""
    there = {ob.session_uid for ob in scene.objects}
    known = {uid: one for uid, one in session.stale.get(scene.session_uid, {}).items() if uid in there}
    for ob, one in checked:
        known.pop(ob.session_uid, None)
        if one.state == "STALE":
            known[ob.session_uid] = one
    session.stale[scene.session_uid] = known


def _record(ob: bpy.types.Object) -> BakeRecord | None:
    """The record of an object's bake, which counts only with its layers; they count without it, as of unknown origin."""
    if ob.type != "MESH":
        return None
    mesh = transport_mesh(ob)
    record = read_record(mesh)
    if record and record.version > FORMAT_VERSION:  # whose layers may be others
        return record
    return (record or BakeRecord(BakeSettings(), "SCENE")) if is_baked(mesh) else None


def _checkable(ob: bpy.types.Object) -> BakeRecord | None:
    record = _record(ob)
    return record if record and record.fingerprint else None


def _differences(record: BakeRecord, evidence: Evidence | None) -> frozenset[Cause]:
    """Find the causes that only the whole scene shows."""
    if evidence is None:
        return frozenset({"HIDDEN"})
    was, now = record.fingerprint, evidence.fingerprint(record.settings.mode, record.space)
    assert was, "only such records are checked"
    causes: set[Cause] = set()
    if was.geometry != now.geometry:
        causes.add("GEOMETRY")
    if was.others != now.others:
        causes.add("OTHERS")
    if was.colours != now.colours and not causes:  # colours of other surfaces cannot be compared
        causes.add("COLOURS")
    return frozenset(causes)


def _other_settings(record: BakeRecord, settings: BakeSettings, space: str) -> str:
    """What differs between the settings of a bake and those of the next, or an empty string."""
    changes = []
    if record.settings.mode != settings.mode:
        changes.append((_name(MODES, record.settings.mode), _name(MODES, settings.mode)))
    else:
        used = record.settings.used | settings.used
        for entry in fields(BakeSettings):
            was, now = (getattr(one, entry.name) for one in (record.settings, settings))
            same = isclose(was, now, rel_tol=1e-6) if isinstance(was, float) else was == now
            if entry.name in used and not same:
                changes.append(_changed(entry.name, was, now))
    if record.space != space:
        changes.append((f"for {_name(SPACES, record.space)}", _name(SPACES, space)))
    return "; ".join(f"{was}, now {now}" for was, now in changes)


def _changed(name: str, was: float, now: float) -> tuple[str, str]:
    """A changed setting in words: `256 samples`, now `512`."""
    before, after = (f"{value:g}" if isinstance(value, float) else str(value) for value in (was, now))
    return (f"{before} {name}" if name in {"samples", "bounces"} else f"{name} {before}", after)


def _name(items: list[tuple[str, str, str]], identifier: str) -> str:
    return next((name.lower() for found, name, _ in items if found == identifier), identifier)
