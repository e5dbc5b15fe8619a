# SPDX-License-Identifier: GPL-3.0-or-later
"""Stores the SH light on the World: nine RGB custom properties, and drivers that carry its turn and strength.

The light is stored with the world's rotation at zero. Its turn is stored as the images of the three axes under
the world's Mapping node, by drivers that need no Python (simple expressions): a saved file turns and renders in a
Blender that has never heard of this extension. Shaders read all of it with Attribute nodes of type View Layer.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import bpy
import numpy as np

from ...core.arrays import Float64
from ...core.errors import LightError
from ...core.sphere import sh
from ...core.sphere.rotation import rotation_matrix
from ..blender.animation import channels, interpolate_linearly
from ..blender.libraries import check_local, is_local
from ..blender.nodes import feeding_socket
from ..blender.versions import refuse_newer, version_of
from ..sky.projection import LightSettings, Projection
from ..sky.sky import Sky
from .drivers import DRIVEN, STRENGTH, TURN, follow, remove_drivers, write_rest
from .lamps import follow_scenes, place_lamps, remove_lamps, suns_of, turn_lamps

LIGHT_VERSION = 2
LIGHT = tuple(f"prt_light_{i}" for i in range(sh.coefficient_count(sh.ORDER)))
_KEYFRAMED = {f'["{name}"]' for name in (*LIGHT, *TURN)}
RECORD = "prt_light"
FRAMES, REPAINTED, SOURCE, STAND_IN, SUN = "frames", "repainted", "source", "stand_in", "sun_threshold"
LAMP_COUNT = "lamp_count"
"""Keys of the record: the first and last keyframe of a keyframed light; the picture whose texels have changed since; the
world whose sky it is, if that is a view layer's and not the one that carries the light; whether a white sky stands in;
above what EEVEE took texels of the sky for a sun; how many lamps show what is left out of the light."""


@dataclass(frozen=True)
class Followed:
    """The sockets and nodes that a light follows; None where it follows none.

    rotation: the socket of a Mapping node.
    sun: the Sky Texture whose Sun Rotation it is instead.
    """

    rotation: bpy.types.NodeSocket | None
    sun: bpy.types.Node | None
    strength: bpy.types.NodeSocket | None


def write_light(sky: Sky, projection: Projection, insert: bool = True) -> None:
    """Store a light on the sky's world and let it follow the world's nodes.

    Args:
        sky: that was projected.
        projection: the light of it.
        insert: whether to insert a Mapping node if the world has none and there is one place for it, so that there is
            something to turn.

    Raises:
        LightError, VersionError: see `check_world`.
    """
    world = sky.holder
    check_world(world)
    _remove_properties(world)
    mapping = sky.mapping or (insert_mapping(sky.entry) if insert and sky.entry else None)
    write_rest(world, _light_of_eevee(sky, projection))
    _store_projected(world, projection)
    world[RECORD] = {
        "version": LIGHT_VERSION,
        "order": sh.ORDER,
        "mapping": node.name if (node := mapping or sky.sun) else "",
        "strength": sky.strength.node.name if sky.strength else "",
        **({SOURCE: sky.world.name} if sky.world.name != world.name else {}),
        **asdict(projection.identity),
        **asdict(projection.settings),
        "factors": projection.factors.tolist(),
        "negative": list(projection.negative),
        LAMP_COUNT: len(projection.lamps.lamps),
    }
    _keep_sun_in_sky(sky.world, world[RECORD])
    follow(sky, mapping)
    place_lamps(sky, projection.lamps, mapping)
    world.update_tag()


def _store_projected(world: bpy.types.World, projection: Projection) -> None:
    """Write light, and what lamps show of it, with their colour."""
    lamps = projection.lamps
    store_light(world, projection.light, lamps.light() * sh.per_coefficient(projection.factors))
    for name, channel in zip(TURN, lamps.colour if lamps.lamps else (0.0,) * 3, strict=True):
        world[name][3] = 1.0 + channel


def _light_of_eevee(sky: Sky, projection: Projection) -> float:
    """The last of the strength: see `drivers`. Without lamps of the sky, nothing says what EEVEE lacks of one with a Sun Disc."""
    band_1 = float(projection.factors[1])
    if not band_1 or (sky.has_sun_disc and not projection.lamps.lamps):
        return 0.0
    return (-1.0 if sky.has_sun_disc else 1.0) / band_1


def _keep_sun_in_sky(source: bpy.types.World, record: Any) -> None:
    """Keep EEVEE from making a lamp of the sky's brightest texels: it would light relit surfaces a second time."""
    if is_local(source) and source.sun_threshold:
        record[SUN], source.sun_threshold = source.sun_threshold, 0.0


def check_world(world: bpy.types.World) -> None:
    """Raises LightError if a world cannot be changed, VersionError if it carries a light of a newer version."""
    check_local(world, f"World '{world.name}'", "project it", LightError)
    check_version(world)


def check_version(world: bpy.types.World) -> None:
    """Raises VersionError if a newer version projected a world."""
    refuse_newer(f"World '{world.name}' was projected", version_of(world.get(RECORD)), LIGHT_VERSION)


_KINDS: dict[str, type | tuple[type, ...]] = {
    "version": int,
    "graph": str,
    "pictures": str,
    "mapping": str,
    "strength": str,
    "window": str,
    "cutoff": (int, float),
    "lamps": str,
    REPAINTED: str,
    SOURCE: str,
    SUN: (int, float),
    LAMP_COUNT: int,
}


def light_record(world: bpy.types.World) -> Mapping[str, Any]:
    """The record of a world's light; empty if there is none that we wrote: then the light is of unknown origin."""
    record = world.get(RECORD)
    if not hasattr(record, "keys"):
        return {}
    frames = record.get(FRAMES, (0, 0))
    fits = all(isinstance(record[name], kind) for name, kind in _KINDS.items() if name in record)
    return record if fits and not isinstance(frames, str) and hasattr(frames, "__len__") and len(frames) == 2 else {}


def light_settings_of(world: bpy.types.World) -> LightSettings:
    """The settings that a world's light was projected with."""
    record = light_record(world)
    return LightSettings(record["window"], record["cutoff"], record.get("lamps", "NONE"))


def store_light(world: bpy.types.World, light: Float64, lamps: Float64 | None = None) -> None:
    """Write coefficients as the world's custom properties.

    Args:
        world: that carries the light from now on.
        light: (9, 3).
        lamps: (9,) what lamps show of it, before their colour.
    """
    for name, rgb, part in zip(LIGHT, light, np.zeros(len(LIGHT)) if lamps is None else lamps, strict=True):
        world[name] = [*(float(channel) for channel in rgb), float(part)]


def read_light(world: bpy.types.World) -> Float64:
    """The stored (9, 3) light of a world that `has_light`."""
    return np.array([list(world[name])[:3] for name in LIGHT])


def read_lamps(world: bpy.types.World) -> Float64:
    """(9, 3) the part of a world's stored light that lamps show instead. The world must have a light (`has_light`)."""
    if any(len(world[name]) < 4 for name in (*LIGHT, *TURN)):
        return np.zeros((len(LIGHT), 3))
    return np.multiply.outer([world[name][3] for name in LIGHT], [world[name][3] - 1.0 for name in TURN])


def read_turn(world: bpy.types.World) -> Float64:
    """The (3, 3) rotation R that the drivers hold: the sky seen along w is the picture's along R w."""
    return np.array([list(world[name])[:3] for name in TURN]).T


def strength_of(world: bpy.types.World) -> float:
    """The strength that scales the stored light now."""
    return float(value[0] if hasattr(value := world[STRENGTH], "__len__") else value)


def shown_light(world: bpy.types.World, update: bool = True) -> Float64:
    """(9, 3) the light as it is turned and scaled now; without an update, as Blender last evaluated it.

    Raises:
        LightError: if the world carries none.
        VersionError: if a newer version projected it.
    """
    check_version(world)
    if not has_light(world):
        raise LightError("The scene's world carries no SH light: press Project World (prt.project_light).")
    if update:
        bpy.context.view_layer.update()  # the drivers' latest word
    return strength_of(world) * (rotation_matrix(read_turn(world).T) @ read_light(world))


def write_still_light(world: bpy.types.World, light: Float64) -> None:
    """Store a light (9, 3) that follows no nodes: unturned, at strength 1."""
    check_world(world)
    remove_light(world)
    store_light(world, light)
    write_rest(world)
    world[RECORD] = {"version": LIGHT_VERSION, "order": sh.ORDER}
    world.update_tag()


def may_stand_in(world: bpy.types.World | None) -> bool:
    """Whether a world could carry a white sky until its own can be projected: it has no light, and belongs to this file."""
    return world is not None and is_local(world) and not has_light(world)


def write_stand_in(world: bpy.types.World) -> None:
    """Light a world by a white sky of radiance 1 in place of one that cannot be projected, as in black nothing is seen."""
    white = np.zeros((sh.coefficient_count(sh.ORDER), 3))
    white[0] = 2.0 * np.sqrt(np.pi)
    write_still_light(world, white)
    world[RECORD][STAND_IN] = True


def stands_in(world: bpy.types.World) -> bool:
    """Whether a world's light is that white sky."""
    return bool(light_record(world).get(STAND_IN))


def has_light(world: bpy.types.World | None) -> bool:
    """Whether a world carries a whole SH light: with a turn and a strength, and of numbers."""
    return (
        world is not None
        and all(_is_vector(world.get(name), 3, 4) for name in (*LIGHT, *TURN))
        and (isinstance(world.get(STRENGTH), (int, float)) or _is_vector(world.get(STRENGTH), 4))
    )


def _is_vector(value: object, *lengths: int) -> bool:
    """Whether a custom property holds so many numbers."""
    return hasattr(value, "typecode") and value.typecode in "fdi" and len(value) in lengths  # type: ignore[arg-type]


def is_projected(world: bpy.types.World) -> bool:
    """Whether the light of a world was made from its own sky, and not read from a file."""
    record = light_record(world)
    return all(name in record for name in ("graph", "pictures", "mapping", "strength", "window", "cutoff"))


def is_keyframed(world: bpy.types.World) -> bool:
    """Whether the light of a world was projected frame by frame, and is left alone until it is projected by hand."""
    return FRAMES in light_record(world)


def why_it_stays(world: bpy.types.World) -> str:
    """Why a bake leaves the light of a world alone, as part of a sentence; empty if it projects the world's sky anew."""
    if is_keyframed(world):
        return "is keyframed"
    imported = has_light(world) and not is_projected(world) and not stands_in(world)
    return "was imported" if imported else ""


def source_of(world: bpy.types.World) -> bpy.types.World:
    """The world whose sky the light of a world is: itself, save under a view layer with a world of its own."""
    return bpy.data.worlds.get(light_record(world).get(SOURCE, "")) or world


def followed(world: bpy.types.World) -> Followed:
    """The sockets that turn and scale the light of a world."""
    record, tree = light_record(world), source_of(world).node_tree
    if not record or not tree:
        return Followed(None, None, None)
    mapping, holder = (tree.nodes.get(record.get(key, "")) for key in ("mapping", "strength"))
    strength = (holder.inputs.get("Strength") or next(iter(holder.outputs), None)) if holder else None
    rotation = mapping.inputs.get("Rotation") if mapping else None
    return Followed(rotation, mapping if mapping and hasattr(mapping, "sun_rotation") else None, strength)


def lamps_are_lost(world: bpy.types.World) -> bool:
    """Whether lamps that a world's light counts on are not there: they were deleted, or the world is a copy of the one that has them."""
    return len(suns_of(world)) < light_record(world).get(LAMP_COUNT, 0)


def mend_drivers(sky: Sky) -> bool:
    """Have a light follow its sky's nodes again, where these were renamed; True if it does now. The light itself stays."""
    node = sky.mapping or sky.sun
    if not node and light_record(sky.holder).get("mapping"):
        return False
    remove_drivers(sky.holder)
    record = sky.holder[RECORD]
    record["mapping"] = node.name if node else ""
    record["strength"] = sky.strength.node.name if sky.strength else ""
    follow(sky, sky.mapping)
    turn_lamps(sky)
    return True


def remove_light(world: bpy.types.World) -> bool:
    """Remove light, lamps, record, drivers and keyframes from a world; True if there was any. An added Mapping node stays."""
    remove_lamps(world)
    return _remove_properties(world)


def _remove_properties(world: bpy.types.World) -> bool:
    remove_drivers(world)
    _remove_keyframes(world)
    source, threshold = source_of(world), light_record(world).get(SUN)
    if threshold and is_local(source):
        source.sun_threshold = threshold
    present = [name for name in (*LIGHT, *DRIVEN, RECORD) if name in world]
    for name in present:
        del world[name]
    return bool(present)


def remove_lights() -> None:
    """Remove the light from all worlds, save those of libraries and of newer versions."""
    for world in bpy.data.worlds:
        if is_local(world) and version_of(world.get(RECORD)) <= LIGHT_VERSION:
            remove_light(world)
    follow_scenes()  # which lets lamps go whose world was deleted


def keyframe_light(world: bpy.types.World, frames: Sequence[int], projections: Sequence[Projection]) -> None:
    """Keyframe a light at each frame; between keyframes it goes in straight lines, as light adds up."""
    for frame, projection in zip(frames, projections, strict=True):
        _store_projected(world, projection)
        for name in LIGHT:
            world.keyframe_insert(f'["{name}"]', frame=frame)
        for name in TURN:
            world.keyframe_insert(f'["{name}"]', index=3, frame=frame)
    interpolate_linearly(world, _KEYFRAMED)


def mark_keyframed(world: bpy.types.World, first: int, last: int) -> bool:
    """Note in the record that the light is keyframed; False if there is none, or it was noted before."""
    record = world.get(RECORD)
    if record is None or FRAMES in record:
        return False
    record[FRAMES], record[LAMP_COUNT] = [first, last], len(suns_of(world))
    return True


def unmark_keyframed(world: bpy.types.World) -> None:
    """Remove the note that the light is keyframed."""
    del world[RECORD][FRAMES]


def insert_mapping(entry: bpy.types.NodeSocket) -> bpy.types.Node:
    """Add Texture Coordinate > Mapping before an input that looks along the view; what is seen stays where it was."""
    tree = entry.id_data
    mapping = tree.nodes.new("ShaderNodeMapping")
    mapping.location = (entry.node.location.x - 200.0, entry.node.location.y)
    coordinate = feeding_socket(entry)
    if coordinate is None:
        node = tree.nodes.new("ShaderNodeTexCoord")
        node.location = (mapping.location.x - 200.0, mapping.location.y)
        coordinate = node.outputs["Generated"]
    tree.links.new(coordinate, mapping.inputs["Vector"])
    tree.links.new(mapping.outputs["Vector"], entry)
    return mapping


def _remove_keyframes(world: bpy.types.World) -> None:
    curves = channels(world)
    for curve in [curve for curve in curves or () if curve.data_path in _KEYFRAMED]:
        curves.remove(curve)
