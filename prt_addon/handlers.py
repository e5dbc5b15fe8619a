# SPDX-License-Identifier: GPL-3.0-or-later
"""Owns all of `bpy.app.handlers`: they keep pace with what cannot be driven, and with what panels show. What drivers
can follow needs none of them.

A sky whose pictures or nodes have changed is projected again, which may take a second. With a window that waits for the
pause that follows, in a timer; without one, in scripts and background renders, it is done on the spot. While a window
renders, nothing is projected, as Blender calls handlers from the render's own thread then: the light of such animations is
to be keyframed.
"""

from __future__ import annotations

from contextlib import suppress

import bpy
from bpy.app.handlers import persistent

from . import glances
from .core.errors import PRTError
from .scene.blender.libraries import is_local
from .scene.light.drivers import drivers_work
from .scene.light.lamps import follow_scenes
from .scene.light.light import (
    has_light,
    is_keyframed,
    is_projected,
    lamps_are_lost,
    light_settings_of,
    mend_drivers,
    write_light,
)
from .scene.light.receivers import follow_receivers
from .scene.light.state import light_state, note_repainted
from .scene.material.reading import PART
from .scene.mesh.carrier import put_away, transport_mesh
from .scene.mesh.layers import is_baked
from .scene.settings import light_settings
from .scene.shading.follow_surface import follow_group, follow_surface
from .scene.shading.helper_groups import renew_lamps_group
from .scene.shading.probe import is_probe
from .scene.shading.surface_nodes import lamps_shine
from .scene.sky.projection import project
from .scene.sky.sky import lighting_world, objects_seen, read_world
from .session import session
from .worker.job import end_engine, running_job

_PAUSE = 0.2
"""Seconds without a change of the sky before it is projected again."""


@persistent
def _on_edit(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    """What was edited: base colours that are plain numbers are taken over, and skies looked at."""
    changed = {update.id.original for update in depsgraph.updates}
    session.shapes_changed |= any(
        update.is_updated_geometry or update.is_updated_transform for update in depsgraph.updates
    )
    if any(isinstance(ident, (bpy.types.World, bpy.types.Image, bpy.types.NodeTree)) for ident in changed):
        glances.forget()
    if session.projecting:
        return
    touches_sky = _touches_sky(scene, changed)
    groups = [ident for ident in changed if isinstance(ident, bpy.types.NodeTree) and PART not in ident]
    for material in [ident for ident in changed if isinstance(ident, bpy.types.Material)]:
        follow_surface(material)  # which may remove node groups of ours that were changed, too
    for group in groups:
        follow_group(group)
    for image in [ident for ident in changed if isinstance(ident, bpy.types.Image)] if has_light(scene.world) else ():
        note_repainted(scene.world, image)
    _follow_lamps()
    if scene in changed or _is_other_scene(scene):
        follow_scenes()
        follow_receivers(depsgraph)
    if touches_sky:
        _follow_sky(scene, depsgraph)


def _is_other_scene(scene: bpy.types.Scene) -> bool:
    """Whether this is not the scene of the last edit. Within one, Blender tags the scene itself whenever objects come, go or are
    put elsewhere.
    """
    before, session.scene = session.scene, scene.session_uid
    return session.scene != before


def _follow_lamps() -> None:
    """The first lamp of a file, or no lamp any more: surfaces are relit with their light, or without."""
    before, session.lamps = session.lamps, lamps_shine()
    if session.lamps == before:
        return
    for material in filter(is_local, bpy.data.materials):
        follow_surface(material)


@persistent
def _on_frame(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    """The same for what is keyframed: changing the frame reports no single updates."""
    glances.forget()
    session.shapes_changed = True
    if session.projecting:
        return
    for material in bpy.data.materials:
        if material.node_tree and material.node_tree.animation_data:
            follow_surface(material)
    _follow_sky(scene, depsgraph)


def _touches_sky(scene: bpy.types.Scene, changed: set[bpy.types.ID]) -> bool:
    """Whether edits may have changed a scene's sky: a world, a picture, an object that its nodes look at; or another world
    was put in its place.
    """
    if any(isinstance(ident, (bpy.types.World, bpy.types.Image)) for ident in changed):
        return True
    if scene in changed and (not has_light(scene.world) or lamps_are_lost(scene.world)):
        return True
    objects = {ident for ident in changed if isinstance(ident, bpy.types.Object)}
    source = lighting_world(scene) if objects else None
    return bool(source and objects & set(objects_seen(source)))


def _follow_sky(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    """Project the scene's world again, now or soon, if it is to be followed and has changed."""
    if not scene.prt.auto_light or not _needs_light(scene):
        return
    if not bpy.app.background:
        if not bpy.app.is_job_running("RENDER") and _is_outdated(scene.world):
            _wait_for_pause()
        return
    source = lighting_world(scene)
    _project(scene, source.evaluated_get(depsgraph) if source else scene.world)


def _needs_light(scene: bpy.types.Scene) -> bool:
    """Whether a scene's world carries a light, or was put in the place of one that did while something shows it."""
    if scene.world is None or has_light(scene.world):
        return scene.world is not None
    return any(map(has_light, bpy.data.worlds)) and any(
        ob.type == "MESH" and not is_probe(ob.data) and is_baked(transport_mesh(ob)) for ob in scene.objects
    )


def _is_outdated(world: bpy.types.World) -> bool:
    if not has_light(world) or is_keyframed(world):
        return not has_light(world) or not drivers_work(world)
    return light_state(world).stale


def _wait_for_pause() -> None:
    if bpy.app.timers.is_registered(_after_pause):
        bpy.app.timers.unregister(_after_pause)
    bpy.app.timers.register(_after_pause, first_interval=_PAUSE)


def _after_pause() -> float | None:
    """Project the skies of all windows; later, if Blender is busy."""
    if running_job() or bpy.app.is_job_running("RENDER"):
        return _PAUSE
    for scene in {window.scene for window in bpy.context.window_manager.windows}:
        if scene.prt.auto_light and _needs_light(scene):
            _project(scene, lighting_world(scene) or scene.world)
    return None


def _project(scene: bpy.types.Scene, now: bpy.types.World) -> None:
    """Project a scene's world again if its light is stale: as it was projected, or as the scene says if it never was.

    Args:
        scene: on whose world the light is written.
        now: the world that lights, as it is now: itself, or as a depsgraph evaluates it at the frame of a render.
    """
    world = scene.world
    itself = now.original == world
    if is_keyframed(world):
        _mend(world, now.original)
        return
    if running_job() or not _is_outdated(now if itself else world):
        return
    session.projecting = True
    try:
        settings = light_settings_of(world) if is_projected(world) else light_settings(scene)
        projection = project(read_world(now, world), settings)
        write_light(
            read_world(now.original, world), projection, insert=False
        )  # no nodes turn up under the hands of who edits them
    except PRTError:
        pass  # the panel shows why the light is stale
    finally:
        session.projecting = False


def _mend(world: bpy.types.World, source: bpy.types.World) -> None:
    """Blender does not follow renamed nodes from outside of their tree. A keyframed light is projected by hand alone."""
    if drivers_work(world):
        return
    with suppress(PRTError):  # the panel says that it is stale
        mend_drivers(read_world(source, world))


@persistent
def _on_load(_path: str) -> None:
    """Another file is loaded: what the engine keeps is of no more use, nor what was looked up."""
    end_engine()
    session.forget_file()


@persistent
def _on_loaded(_path: str) -> None:
    """Another file is open: what depends on the version of Blender is made anew, and lamps look after what has changed without us."""
    renew_lamps_group()
    follow_scenes()
    follow_receivers()


@persistent
def _on_other_data(_scene: bpy.types.Scene | str) -> None:
    """Another file is open, or a step was undone: panels look again."""
    glances.forget()


@persistent
def _on_import(_context: bpy.types.BlendImportContext) -> None:
    """Objects were appended: Blender puts what they refer to into the scene, too."""
    put_away()
    follow_scenes()


_HANDLERS = (
    (bpy.app.handlers.blend_import_post, _on_import),
    (bpy.app.handlers.depsgraph_update_post, _on_edit),
    (bpy.app.handlers.frame_change_post, _on_frame),
    (bpy.app.handlers.load_pre, _on_load),
    (bpy.app.handlers.load_post, _on_loaded),
    (bpy.app.handlers.load_post, _on_other_data),
    (bpy.app.handlers.undo_post, _on_other_data),
    (bpy.app.handlers.redo_post, _on_other_data),
)


def register() -> None:
    """Add the handlers."""
    for handlers, handler in _HANDLERS:
        handlers.append(handler)


def unregister() -> None:
    """Remove the handlers, and the timers that they started."""
    for handlers, handler in _HANDLERS:
        handlers.remove(handler)
    glances.unregister()
    if bpy.app.timers.is_registered(_after_pause):
        bpy.app.timers.unregister(_after_pause)
