# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes a scene once: checks and reads everything first, and writes once the whole result is there. Previews of it may
be shown in between, and are taken back before anything else is written.

Nothing of the user's is applied or refused: an object whose own mesh cannot hold its transport gets a carrier, and what
cannot be baked at all is left out and named.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from math import inf

import bpy

from ...core.bake.bake import BakeResult
from ...core.bake.previews import Preview, open_sky
from ...core.errors import MeshError, PRTError
from ...core.layout import packed_backs
from ...core.notices import Kind, Notice
from ...core.problem import BakeSettings
from ...core.transport import raycast
from ...session import session
from ..blender.modes import Place, by_uid, found_again, object_mode
from ..light import light
from ..light.receivers import follow_receivers
from ..mesh import carrier, layers
from ..mesh.meshes import positions
from ..shading import shading
from ..shading.relight_material import relight
from ..sky import sky
from ..sky.identity import sky_identity
from ..sky.projection import LightSettings, Projection, project
from . import choose, freshness, lent_light
from .before import Before, take_back
from .coarse import coarse_objects
from .plan import ObjectToBake
from .read import read_bake

_NO_LIGHT = Kind(
    "{why} Until then a white sky lights the bake where the world has no light yet.",
    "{count} worlds cannot be projected: {names}.",
    fix="prt.use_sky",
)
_UNIFORM = Kind(
    "World {name} looks the same in all directions, so that turning it shows nothing: choose a sky.",
    "{count} worlds look the same in all directions: {names}.",
    "INFO",
    "prt.use_sky",
)


class WholeBake:
    """Bakes the objects that it reads when it is made; `show` writes previews into the file, `write` the result.

    settings: of the bake.
    plan: what takes part.
    """

    def __init__(
        self,
        context: bpy.types.Context,
        settings: BakeSettings,
        projected: LightSettings | None = None,
        with_shading: bool = False,
        objects: Sequence[bpy.types.Object] | None = None,
    ) -> None:
        """
        Args:
            context: whose scene is baked.
            settings: of the bake.
            projected: how the world is projected, too; not if None, nor if its light is keyframed or imported.
            with_shading: whether materials are relit, too.
            objects: to be baked; the selected ones, or all that render, if None.

        Raises:
            PRTError: whatever is wrong with the scene, before any work.
        """
        if settings.casts_rays:
            raycast.require()
        chosen = choose.objects_to_bake(context) if objects is None else list(objects)
        self._light: Projection | None = None
        self._notes, self._about_light = list[str](), list[Notice]()
        if projected:
            self._project(context, projected)
        with object_mode(context):
            self.plan = read_bake(context, chosen, settings)
        self.settings = settings
        self._with_shading = with_shading
        self._place = Place.of(context)
        self._shown: Preview | None = None
        self._pieces: Iterator[None] = iter(())
        context.view_layer.update()  # what reading has left to evaluate is no edit
        session.shapes_changed, self._as_read = False, True

    def _project(self, context: bpy.types.Context, light_settings: LightSettings) -> None:
        """Project the world. What keeps it from that keeps nothing else from being baked."""
        name = context.scene.world.name if context.scene.world else ""
        try:
            here = sky.read_sky(context.scene)
            light.check_world(here.holder)
            if why := light.why_it_stays(here.holder):
                self._notes.append(f"The light of world '{name}' {why}, and stays: Project World replaces it.")
            else:
                self._light = project(here, light_settings)
            if here.is_uniform:
                self._about_light.append(Notice(_UNIFORM, name))
        except PRTError as error:
            self._about_light.append(Notice(_NO_LIGHT, name or context.scene.name, {"why": str(error)}))

    @property
    def summary(self) -> str:
        """What is baked, in words."""
        count = sum(len(one.receivers) for one in self.plan.objects)
        return f"{len(self.plan.objects)} object(s), {count:,} receivers"

    def notices(self, result: BakeResult) -> list[Notice]:
        """What was left out, and what the engine found of the objects that were to be baked: not of those that only
        bounced light at them.
        """
        wanted = {one.group for one in self.plan.objects}
        found = [notice for number, notice in result.findings if number in wanted]
        return [*self.plan.notices, *found, *coarse_objects(self.plan), *self._about_light]

    def look(self) -> None:
        """Check that the objects are what was read, if anything has moved since the last look; not yet those in Edit Mode.

        Raises:
            MeshError: if one is not.
        """
        if session.shapes_changed:
            session.shapes_changed, self._as_read = False, False
            for ob, one in self._objects():
                if ob.mode != "EDIT":
                    _check_unchanged(ob, one)

    def can_show(self, context: bpy.types.Context) -> bool:
        """Whether Blender is ready for a preview: neither rendering, nor in a mode that works on the meshes themselves."""
        rendering = bpy.app.is_job_running("RENDER")
        return not rendering and context.mode == "OBJECT" and all(ob.mode == "OBJECT" for ob, _ in self._objects())

    def first_preview(self) -> Preview | None:
        """What can be shown before a ray is cast; None where an earlier bake shows more."""
        if any(layers.is_baked(carrier.transport_mesh(ob)) for ob, _ in self._objects()):
            return None
        return open_sky(self.plan.problem)

    def show(self, context: bpy.types.Context, preview: Preview, seconds: float = inf) -> bool:
        """Write a preview until something else is written, or it is taken back (`before.take_back`); whether all of it is there.

        A light is lent to a world that has none.

        Args:
            context: of the window that is open now.
            preview: of the plan's problem.
            seconds: after which no other piece is begun; the next call goes on.

        Raises:
            PRTError: if the scene is no longer what was read.
        """
        until = time.monotonic() + seconds
        if preview is not self._shown:
            self._shown, self._pieces = preview, self._pieces_of(context, preview)
        with self._place.again(context):
            self.look()
            is_whole = all(time.monotonic() < until for _ in self._pieces)
            context.view_layer.update()
            session.shapes_changed = False  # all that has changed since the look is ours
        return is_whole

    def _pieces_of(self, context: bpy.types.Context, preview: Preview) -> Iterator[None]:
        """Write a preview piece by piece. None uses what an earlier one has found: undo may have replaced that meanwhile."""
        if session.before is None:
            session.before = Before([ob for ob, _ in self._objects()])
            session.before.hold()
            yield
        before = session.before
        for one in self.plan.objects:
            _store(_found(one), one, preview.result, preview.settings, preview.samples)
            yield
        carrier.sweep(but=before.carriers)
        before.light = before.light or self._lend(context)
        if self._with_shading:
            yield from self._shading_pieces(before)

    def _shading_pieces(self, before: Before) -> Iterator[None]:
        """Relight the materials that are not yet."""
        objects = [ob for ob, _ in self._objects()]
        wanted = [(one.session_uid, two_sided) for one, two_sided in shading.to_relight(objects, anew=False)]
        for uid, two_sided in wanted:
            if material := by_uid(bpy.data.materials, uid):
                relight(material, two_sided)
                before.note_relit(material)
            yield
        follow_receivers()

    def _lend(self, context: bpy.types.Context) -> lent_light.LentLight | None:
        world = context.scene.world
        if self._light and not light.has_light((here := sky.read_sky(context.scene)).holder):
            return lent_light.lend(here, self._light)
        return lent_light.lend_white(world) if self._about_light and light.may_stand_in(world) else None

    def write(
        self, context: bpy.types.Context, result: BakeResult, preview: Preview | None = None
    ) -> tuple[list[Notice], list[str]]:
        """Write the transport of all objects of the plan, and light and shading if they are wanted.

        Into the scene that was read, whichever the window shows by now.

        Args:
            context: of the window that is open now.
            result: of the plan's problem.
            preview: what the result is of, if it is to stay.

        Returns:
            Notices about materials, and sentences about the light.

        Raises:
            PRTError: before anything is written, if the scene is no longer what was read.
        """
        with self._place.again(context):
            self._as_read &= not session.shapes_changed
            if lost := take_back():
                raise MeshError(
                    f"Mesh '{lost[0]}' was edited during the bake: its earlier transport is gone. Bake again."
                )
            return self._write(context, result, preview)

    def _write(
        self, context: bpy.types.Context, result: BakeResult, preview: Preview | None
    ) -> tuple[list[Notice], list[str]]:
        found = self._objects()
        objects = [ob for ob, _ in found]
        here = sky.read_sky(context.scene) if self._light else None  # refuses before writing, as all that follows
        if here and self._light:
            light.check_world(here.holder)
            if sky_identity(here) != self._light.identity:  # the world was edited, or is another, since the bake began
                self._light = project(here, self._light.settings)
        with object_mode(context):
            for ob, one in found:
                _check_unchanged(ob, one)
            before = Before(objects)
            try:
                for ob, one in found:
                    _store(
                        ob,
                        one,
                        result,
                        preview.settings if preview else self.settings,
                        preview.samples if preview else 0,
                    )
            except BaseException:  # whatever happens, all of it is there or none
                before.put_back()
                raise
            carrier.sweep()
            context.view_layer.update()
        freshness.note_baked(objects, self._as_read)
        notes = list(self._notes)
        if here and self._light:
            light.write_light(here, self._light)
            notes += self._light.sentences
        elif self._about_light and light.may_stand_in(context.scene.world):
            light.write_stand_in(context.scene.world)
        return shading.add_shading(objects) if self._with_shading else [], notes

    def _objects(self) -> list[tuple[bpy.types.Object, ObjectToBake]]:
        """Those of the plan, each with what it is to get.

        Raises:
            MeshError: if one is no more.
        """
        return [(_found(one), one) for one in self.plan.objects]


def _found(one: ObjectToBake) -> bpy.types.Object:
    """Raises MeshError if it is no more."""
    return found_again(bpy.data.objects, "Object", one.name)


def _check_unchanged(ob: bpy.types.Object, one: ObjectToBake) -> None:
    """Raises MeshError if an object was edited since it was read."""
    mesh = ob.data
    if (len(mesh.vertices), len(mesh.loops)) != one.elements or positions(mesh) != one.positions:
        raise MeshError(f"Mesh of '{ob.name}' was edited during the bake; nothing was changed: bake again.")


def _store(
    ob: bpy.types.Object,
    one: ObjectToBake,
    result: BakeResult,
    settings: BakeSettings,
    preview_of: int = 0,
) -> None:
    """Put the transport of an object where it shows it: on its own mesh, or on a carrier.

    Args:
        ob: the object.
        one: what was read of it.
        result: of the bake of all objects.
        settings: of that bake.
        preview_of: rays of the bake that the result is a preview of; 0 if it is none.
    """
    back = one.group + 1
    backs = packed_backs(result.transport[back], result.direct[back]) if one.receivers.backs else None
    if one.carried:
        mesh = carrier.hang(ob, one.carried, one.receivers.domain, with_backs=backs is not None)
        if ob.data.users == 1:
            layers.remove(ob.data)  # of an earlier bake, which nothing shows any more
    else:
        mesh = ob.data
        carrier.take_off(ob)
    layers.write(
        mesh,
        one.receivers.domain,
        result.transport[one.group],
        result.direct[one.group],
        one.receivers.element_receiver,
        settings,
        one.space,
        one.evidence,
        one.elements,
        preview_of,
        backs,
    )
