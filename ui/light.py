# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws the SH light of the world, and the nodes that turn it."""

from __future__ import annotations

from dataclasses import asdict

import bpy

from ..prt_addon.glances import light_glance
from ..prt_addon.scene.light import light
from ..prt_addon.scene.light.lamps import suns_of
from .tab import Tab, draw_text

_WITH_CUTOFF = {"HANN", "LANCZOS"}


class PRT_PT_light(Tab, bpy.types.Panel):
    """The SH light, which is the sky as nine coefficients of spherical harmonics, and the nodes that turn it"""

    bl_idname = "PRT_PT_light"
    bl_parent_id = "PRT_PT_bake"
    bl_label = "Light"

    def draw(self, context: bpy.types.Context) -> None:
        draw_light(self.layout, context)


def draw_light(layout: bpy.types.UILayout, context: bpy.types.Context) -> None:
    """How the light stands, and the buttons and nodes that change it."""
    layout.use_property_split = True
    world, settings = context.scene.world, context.scene.prt
    state = light_glance(world).state
    draw_text(context, layout.column(align=True), state.text, "ERROR" if state.stale else "WORLD")
    layout.operator("prt.project_light", icon="WORLD")
    if not _has_sky(world):
        layout.menu("PRT_MT_skies", icon="LIGHT_SUN")
    column = layout.column()
    column.use_property_decorate = False
    column.prop(settings, "auto_light")
    column.prop(settings, "window")
    if settings.window in _WITH_CUTOFF:
        column.prop(settings, "cutoff")
    column.prop(settings, "lamps")
    if hidden := hidden_lamps(context):
        draw_text(context, layout.column(align=True), hidden, "ERROR")
    if changed := changed_settings(context.scene):
        draw_text(context, layout.column(align=True), _sentence(changed, world), "INFO")
    if light.has_light(world):
        followed = light.followed(world)
        for socket, name in ((followed.rotation, "Rotation"), (followed.strength, "Strength")):
            if socket:
                layout.prop(socket, "default_value", text=name)
        if followed.sun:
            layout.prop(followed.sun, "sun_rotation", text="Rotation")
    for sentence in state.not_followed:
        draw_text(context, layout.column(align=True), f"{sentence[0].upper()}{sentence[1:]}.", "INFO")
    layout.operator("prt.keyframe_light", icon="KEYTYPE_KEYFRAME_VEC")


def _has_sky(world: bpy.types.World | None) -> bool:
    """Whether a world has a picture, or another texture of a sky, of its own."""
    nodes = world.node_tree.nodes if world and world.node_tree else ()
    return any(node.bl_idname in {"ShaderNodeTexEnvironment", "ShaderNodeTexSky"} for node in nodes)


def hidden_lamps(context: bpy.types.Context) -> str:
    """A sentence on lamps of the sky that are not seen in the view layer, whose light is missing then; empty if there are none."""
    world, layer = context.scene.world, context.view_layer
    suns = suns_of(world) if world else []
    if all(ob.name in layer.objects and ob.visible_get(view_layer=layer) and not ob.hide_render for ob in suns):
        return ""
    return "Lamps of this sky are hidden, and their light is missing: show the collection PRT Lamps."


def changed_settings(scene: bpy.types.Scene) -> list[str]:
    """Which settings, as the panel calls them, are others than the light of the scene's world was made with."""
    world, settings = scene.world, scene.prt
    if not light.has_light(world) or not light.is_projected(world):
        return []
    done = asdict(light.light_settings_of(world))
    if settings.window not in _WITH_CUTOFF:
        del done["cutoff"]
    return [settings.bl_rna.properties[name].name for name in done if getattr(settings, name) != done[name]]


def _sentence(changed: list[str], world: bpy.types.World) -> str:
    """What was changed, and what to do."""
    *some, last = changed
    names = f"{', '.join(some)} and {last} were" if some else f"{last} was"
    remedy = "keyframe the light again" if light.is_keyframed(world) else "project the world"
    return f"{names} changed since the light was made: {remedy}."


CLASSES = (PRT_PT_light,)
