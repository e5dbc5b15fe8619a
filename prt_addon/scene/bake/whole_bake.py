# SPDX-License-Identifier: GPL-3.0-or-later
"""One bake of a scene: everything is checked and read first, and written once the whole result is there."""

from __future__ import annotations

import bpy

from ...core.bake.bake import BakeResult
from ...core.problem import BakeSettings
from ...core.transport import raycast
from ..blender.modes import Place, found_again, object_mode
from ..light import light
from ..mesh import layers
from ..settings import Preparation
from ..shading import shading
from ..sky import sky
from ..sky.identity import identity
from ..sky.projection import Windowing, project
from . import freshness, gather, prepare


class WholeBake:
    """What is to be baked, read when this is made; `write` puts the result into the file.

    settings: of the bake.
    plan: what takes part.
    """

    def __init__(
        self,
        context: bpy.types.Context,
        settings: BakeSettings,
        allowed: Preparation,
        projected: Windowing | None = None,
        with_shading: bool = False,
    ) -> None:
        """
        Args:
            allowed: what may be done to meshes that cannot hold the result.
            projected: how the world is projected, too; not if None, nor if its light is keyframed or imported.
            with_shading: whether materials are relit, too.

        Raises:
            PRTError: whatever is wrong with the scene, before any work.
        """
        if settings.mode != "UNSHADOWED":
            raycast.require()
        objects = gather.objects_to_bake(context)
        if with_shading:
            shading.check_materials(objects)
        self._light, self._notes = None, list[str]()
        if projected:
            here = sky.read_sky(context.scene)
            light.check_world(here.world)
            if why := light.why_it_stays(here.world):
                self._notes.append(
                    f"The light of world '{here.world.name}' {why}, and stays: Project World replaces it."
                )
            else:
                self._light = project(here, projected)
        with object_mode(context):
            self.plan = gather.gather(context, objects, settings, allowed)
        self.settings = settings
        self._allowed, self._with_shading = allowed, with_shading
        self._names = [ob.name_full for ob in objects]
        self._place = Place.of(context)

    @property
    def summary(self) -> str:
        """What is baked, in words."""
        count = sum(len(one.receivers.group) for one in self.plan.objects)
        return f"{len(self._names)} object(s), {count:,} receivers"

    def findings(self, result: BakeResult) -> list[str]:
        """What the engine found of the objects that were to be baked, and not of those that only bounced light at them."""
        wanted = {one.group for one in self.plan.objects}
        return [sentence for number, sentence in result.findings if number in wanted]

    def write(self, context: bpy.types.Context, result: BakeResult) -> tuple[list[str], list[str]]:
        """Write the transport of all objects of the plan, and light and shading if asked for.

        Into the scene that was read, whichever the window shows by now.

        Returns:
            Sentences for the person: warnings, and what else there is to know.

        Raises:
            PRTError: before anything is written, if the scene is no longer what was read.
        """
        with self._place.again(context):
            return self._write(context, result)

    def _write(self, context: bpy.types.Context, result: BakeResult) -> tuple[list[str], list[str]]:
        objects = [found_again(bpy.data.objects, "Object", name) for name in self._names]
        here = sky.read_sky(context.scene) if self._light else None  # refuses before writing, as all that follows
        if here and self._light:
            light.check_world(here.world)
            if identity(here) != self._light.identity:  # the world was edited, or is another, since the bake began
                self._light = project(here, self._light.windowing)
        if self._with_shading:
            shading.check_materials(objects)
        with object_mode(context):
            with prepare.own_meshes(context, objects, self._allowed) as own:
                for ob, one in zip(objects, self.plan.objects, strict=True):
                    gather.check_unchanged(ob, own.mesh_of(ob), one.receivers)
            for ob, one in zip(objects, self.plan.objects, strict=True):
                layers.write(
                    ob.data,
                    one.receivers.domain,
                    result.transport[one.group],
                    one.receivers.element_receiver,
                    self.settings,
                    one.space,
                    one.evidence,
                )
        freshness.note_baked(objects)
        notes = [*own.notes, *self._notes]
        if here and self._light:
            light.write_light(here, self._light)
            notes += self._light.sentences
        warnings = shading.add_shading(objects) if self._with_shading else []
        return warnings, notes
