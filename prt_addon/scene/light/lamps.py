# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes lamps that light relit surfaces in EEVEE in place of spots of the sky: suns in the collection "PRT Lamps".

They hang on an Empty which the sky's nodes turn by drivers, and follow the strength of the light, without Python. Cycles sees the
sky itself, so that their nodes emit nothing there. What is not relit gets all of EEVEE's own light of the sky, so that the lamps
are linked to what is (`receivers`). EEVEE's gloss mirrors the sky with all its spots, but clamps them: the lamps add what the clamp takes.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import pi, sin

import bpy
import numpy as np
from mathutils import Vector

from ...core.sky.lamps import Lamp, Lamps, tracked
from ..blender.animation import interpolate_linearly
from ..blender.libraries import is_local
from ..sky.sky import Sky
from .drivers import drive_energy, drive_gloss, drive_rotation
from .receivers import follow_receivers, receivers_with, remove_unused_receivers

NAME = "PRT Lamps"
_OF = "prt_lamps_of"
"""Custom property of a collection of lamps: the world whose they are."""
_IRRADIANCE = "prt_irradiance"
_RADIANCE = "prt_radiance"
"""Custom properties of a lamp: the sun's at strength 1, of its colour's brightest channel."""
_SMALLEST = 1e-9
"""Of the squared sine of a lamp's radius: a single texel has none."""
_NEITHER = ("volume_factor", "transmission_factor")
"""What a lamp does not light: that is lit by the sky."""


def place_lamps(sky: Sky, lamps: Lamps, mapping: bpy.types.Node | None) -> None:
    """Have lamps stand for spots of a sky, in all scenes of the world that carries its light; those of before are used again.

    Args:
        sky: whose spots they are.
        lamps: that were found in it.
        mapping: the node that turns the sky; None if there is none.
    """
    world = sky.holder
    if not lamps.lamps:
        remove_lamps(world)
    else:
        _place(sky, lamps, mapping)
    follow_scenes()
    follow_receivers()


def _place(sky: Sky, lamps: Lamps, mapping: bpy.types.Node | None) -> None:
    world = sky.holder
    scenes = [scene for scene in bpy.data.scenes if scene.world == world and is_local(scene)]
    collection = lamps_of(world) or _new_collection(world)
    empty = _empty(collection)
    drive_rotation(empty, sky, mapping)
    suns = suns_of(world)
    _remove(suns[len(lamps.lamps) :])
    for number, lamp in enumerate(lamps.lamps):
        sun = suns[number] if number < len(suns) else _new_sun(collection, empty, world)
        _set(sun, lamp, lamps.colour)
        _light_gloss(sun.data, sky, scenes)


def follow_scenes() -> None:
    """Have each scene hold the lamps of its own world and of no other, wherever people have put them; remove what no world has."""
    for collection in _ours():
        world = collection.get(_OF)
        if (
            world is None or lamps_of(world) != collection
        ):  # the world was deleted; or a scene was copied, with its lamps
            _remove_collection(collection)
    ours = set(_ours())
    for scene in filter(is_local, bpy.data.scenes):
        holders = [scene.collection, *scene.collection.children_recursive]
        own = lamps_of(scene.world) if scene.world else None
        for holder in filter(is_local, holders):
            for collection in [child for child in holder.children if child in ours and child != own]:
                holder.children.unlink(collection)
        if own and own not in holders:
            scene.collection.children.link(own)


def remove_lamps(world: bpy.types.World) -> None:
    """Remove the lamps of a world."""
    if collection := lamps_of(world):
        _remove_collection(collection)


def _remove_collection(collection: bpy.types.Collection) -> None:
    _remove(list(collection.objects))
    bpy.data.collections.remove(collection)
    remove_unused_receivers()


def turn_lamps(sky: Sky) -> None:
    """Have the lamps of a sky, if it has any, turned by the node that turns it now."""
    if collection := lamps_of(sky.holder):
        drive_rotation(_empty(collection), sky, sky.mapping)


def lamps_of(world: bpy.types.World) -> bpy.types.Collection | None:
    """The collection of a world's lamps; None if it has none."""
    return next((one for one in _ours() if one.get(_OF) == world), None)


def _ours() -> list[bpy.types.Collection]:
    return [one for one in bpy.data.collections if _OF in one and is_local(one)]


def suns_of(world: bpy.types.World) -> list[bpy.types.Object]:
    """The lamps of a world, the brightest spot's first."""
    collection = lamps_of(world)
    return [ob for ob in collection.objects if ob.type == "LIGHT"] if collection else []


def read_lamps_of(world: bpy.types.World) -> Lamps:
    """The lamps of a world as they stand now; what share of the sky they are is not known."""
    found, total = [], np.zeros(3)
    for sun in suns_of(world):
        irradiance = np.array(sun.data.color) * sun.data[_IRRADIANCE]
        direction = np.array(sun.rotation_quaternion.to_matrix().col[2])
        found.append(Lamp(direction, float(irradiance.mean()), sun.data.angle / 2.0))
        total += irradiance
    if not total.any():
        return Lamps()
    red, green, blue = (total / total.mean()).tolist()
    return Lamps(tuple(found), (red, green, blue))


def keyframe_lamps(sky: Sky, frames: Sequence[int], found: Sequence[Lamps]) -> None:
    """Have lamps go from frame to frame as they were found there: each to the nearest, in straight lines.

    Args:
        sky: whose spots they are.
        frames: at which they were found.
        found: the lamps at each of them.
    """
    rows = tracked([lamps.lamps for lamps in found])
    place_lamps(sky, Lamps(tuple(rows[0])), sky.mapping)
    suns = suns_of(sky.holder)
    for frame, row, lamps in zip(frames, rows, found, strict=True):
        for sun, lamp in zip(suns, row, strict=True):
            before = sun.rotation_quaternion.copy()
            _set(sun, lamp, lamps.colour)
            sun.rotation_quaternion.make_compatible(before)
            sun.keyframe_insert("rotation_quaternion", frame=frame)
            for path in ("angle", "color", f'["{_IRRADIANCE}"]', f'["{_RADIANCE}"]'):
                sun.data.keyframe_insert(path, frame=frame)
    for block in [*suns, *(sun.data for sun in suns)]:
        interpolate_linearly(block)


def is_lamp_of_sky(ob: bpy.types.Object) -> bool:
    """Whether an object is one of these lamps."""
    return ob.type == "LIGHT" and _IRRADIANCE in ob.data


def _new_collection(world: bpy.types.World) -> bpy.types.Collection:
    collection = bpy.data.collections.new(NAME)
    collection[_OF] = world
    return collection


def _empty(collection: bpy.types.Collection) -> bpy.types.Object:
    """What turns the lamps of a collection."""
    empty = next((ob for ob in collection.objects if ob.type == "EMPTY"), None)
    if empty is None:
        empty = bpy.data.objects.new(NAME, None)
        empty.empty_display_size, empty.hide_select = 0.25, True
        collection.objects.link(empty)
    return empty


def _new_sun(collection: bpy.types.Collection, empty: bpy.types.Object, world: bpy.types.World) -> bpy.types.Object:
    data = bpy.data.lights.new("PRT Lamp", "SUN")
    for factor in _NEITHER:
        setattr(data, factor, 0.0)
    data.use_shadow_jitter = True  # discs cast soft shadows
    if data.node_tree is None:  # before 5.1
        data.use_nodes = True
    for node in data.node_tree.nodes:
        if node.bl_idname == "ShaderNodeEmission":
            node.inputs["Strength"].default_value = 0.0  # for Cycles: EEVEE does not look at a lamp's nodes
    data[_IRRADIANCE] = 0.0
    drive_energy(data, f'["{_IRRADIANCE}"]', world)
    sun = bpy.data.objects.new("PRT Lamp", data)
    sun.parent, sun.hide_select, sun.rotation_mode = empty, True, "QUATERNION"
    sun.light_linking.receiver_collection = receivers_with(empty)
    collection.objects.link(sun)
    return sun


def _light_gloss(lamp: bpy.types.Light, sky: Sky, scenes: Sequence[bpy.types.Scene]) -> None:
    """Have a lamp add to gloss what EEVEE's mirror image of the sky lacks of it: all of the disc of a Sky Texture."""
    lamp.driver_remove("specular_factor")
    lamp.specular_factor = 1.0
    if scenes and not sky.sun:
        drive_gloss(lamp, f'["{_RADIANCE}"]', sky.holder, scenes[0])


def _set(sun: bpy.types.Object, lamp: Lamp, colour: tuple[float, float, float]) -> None:
    most = max(colour)
    sun.rotation_quaternion = Vector(lamp.direction).to_track_quat("Z", "Y")
    sun.data.angle = 2.0 * lamp.radius
    sun.data.color = [channel / most for channel in colour]
    sun.data[_IRRADIANCE] = lamp.irradiance * most
    sun.data[_RADIANCE] = most * (lamp.radiance or lamp.irradiance / (pi * max(sin(lamp.radius) ** 2, _SMALLEST)))


def _remove(objects: list[bpy.types.Object]) -> None:
    blocks = objects + [ob.data for ob in objects if ob.data]
    animated = [block.animation_data for block in blocks if block.animation_data]
    bpy.data.batch_remove(blocks + list({data.action for data in animated if data.action}))
