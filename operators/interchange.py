# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the GAMES202 course's files from the active mesh and the world, and reads them back."""

import bpy

from ..prt_addon.core.errors import LightError, MeshError
from ..prt_addon.core.notices import counted
from ..prt_addon.scene.bake import choose, freshness
from ..prt_addon.scene.blender.modes import object_mode
from ..prt_addon.scene.export import games202 as interchange
from ..prt_addon.scene.shading import shading
from .folder import FolderBrowser, folder_property
from .job import WhenIdle
from .reporting import reports_errors


class PRT_OT_export_games202(FolderBrowser, bpy.types.Operator):
    """Write light.txt and transport.txt, the world's light and the active mesh's transport as they are turned now, as the GAMES202 course's framework reads them"""

    bl_idname = "prt.export_games202"
    bl_label = "Export GAMES202"

    directory: folder_property("Folder to write light.txt and transport.txt into")  # type: ignore[valid-type]

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        ob = _active_mesh(context)
        with object_mode(context):
            interchange.export_files(ob, _world(context), self._folder())
        causes = freshness.glance(context, ob).causes
        if stale := [phrase for cause, phrase in causes.items() if cause != "SETTINGS"]:
            self.report(
                {"WARNING"}, f"The transport of '{ob.name}' is stale: {', '.join(stale)}. Bake and export again."
            )
        self.report({"INFO"}, f"Wrote light.txt and transport.txt into '{self._folder()}'.")
        return {"FINISHED"}


class PRT_OT_import_games202(WhenIdle, FolderBrowser, bpy.types.Operator):
    """Read transport.txt onto the active mesh and light.txt into the world, and relight the mesh with them"""

    bl_idname = "prt.import_games202"
    bl_label = "Import GAMES202"
    bl_options = {"REGISTER", "UNDO"}

    directory: folder_property("Folder with light.txt and transport.txt")  # type: ignore[valid-type]

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        ob = _active_mesh(context)
        choose.check_writable(ob)
        with object_mode(context):
            flavour = interchange.import_files(ob, _world(context), self._folder())
        for one in counted(shading.add_shading([ob])):
            self.report({one.kind.level}, one.sentence)
        scale = "with" if flavour == "RADIANCE" else "without"
        self.report({"INFO"}, f"Read light and transport, which was {scale} its 1/pi, onto '{ob.name}'.")
        return {"FINISHED"}


def _active_mesh(context: bpy.types.Context) -> bpy.types.Object:
    ob = context.view_layer.objects.active
    if ob is not None and ob.type == "MESH":
        return ob
    objects = choose.objects_to_bake(context)
    if len(objects) > 1:
        raise MeshError("These files hold one mesh: make the one that is meant active.")
    return objects[0]


def _world(context: bpy.types.Context) -> bpy.types.World:
    if context.scene.world is None:
        raise LightError(f"Scene '{context.scene.name}' has no world: add one in World properties.")
    return context.scene.world


CLASSES = (PRT_OT_export_games202, PRT_OT_import_games202)
