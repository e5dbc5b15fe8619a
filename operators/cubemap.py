# SPDX-License-Identifier: GPL-3.0-or-later
"""Loads a cube map: six faces become the world, and its light."""

from pathlib import Path

import bpy
from bpy.props import BoolProperty, EnumProperty, IntProperty, StringProperty

from ..prt_addon.core.sky.cube_layout import face_of
from ..prt_addon.core.sky.cube_map import FACES, project_cubemap, to_equirect, with_light
from ..prt_addon.scene.light import light
from ..prt_addon.scene.settings import LightProperties, absolute_path, light_settings
from ..prt_addon.scene.sky import cube_maps, projection, sky
from .folder import FolderBrowser, folder_property
from .reporting import reports_errors

TABLES = [
    ("OPENGL", "OpenGL", "As the graphics interfaces hold cube maps. .png and .jpg are decoded as sRGB"),
    (
        "GAMES202",
        "GAMES202",
        "As the GAMES202 course's precomputation reads them, which swaps and mirrors some faces: for its light.txt. "
        ".png and .jpg are decoded by a gamma of 2.2",
    ),
]


class PRT_OT_import_cubemap(FolderBrowser, LightProperties, bpy.types.Operator):
    """Light the scene by a cube map: the six pictures of a folder, or one that is a cross or a strip. The world before is kept"""

    bl_idname = "prt.import_cubemap"
    bl_label = "Import Cube Map"
    bl_options = {"UNDO"}

    directory: folder_property(  # type: ignore[valid-type]
        "Folder with posx, negx, posy, negy, posz and negz, or by other usual names: .exr or .hdr, which are linear, or "
        "encoded pictures such as .png and .jpg"
    )
    filepath: StringProperty(  # type: ignore[valid-type]
        name="Picture",
        description="One picture that holds all faces, as a cross or a strip; in place of the folder",
        subtype="FILE_PATH",
        options={"PATH_SUPPORTS_BLEND_RELATIVE", "SKIP_SAVE"},
    )
    filter_image: BoolProperty(  # type: ignore[valid-type]
        name="Show Pictures", description="Show pictures in the file browser", default=True, options={"HIDDEN"}
    )
    table: EnumProperty(  # type: ignore[valid-type]
        name="Faces", description="How the faces lie, and how their colours are encoded", items=TABLES, default="OPENGL"
    )
    max_height: IntProperty(  # type: ignore[valid-type]
        name="Largest Height",
        description="Rows of the panorama made for the world; twice the width of a face if that is less. The SH light "
        "comes from the faces themselves",
        default=2048,
        min=16,
        max=16384,
    )

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        source = self._source()
        faces = cube_maps.read_faces(source, self.table)
        whole = project_cubemap(faces, self.table)
        size = len(faces[FACES[0]])
        picture = to_equirect(faces, self.table, min(2 * size, self.max_height))
        world = cube_maps.set_up_world(context.scene, source.stem or "Cube Map", with_light(picture, whole))
        here = sky.read_sky(context.scene)
        by = f"Six faces of {size} x {size} texels light the scene as world '{world.name}'"
        projected = projection.projected(here, whole, by, light_settings(context.scene, self))
        light.write_light(here, projected)
        for sentence in projected.sentences:
            self.report({"INFO"}, sentence)
        return {"FINISHED"}

    def _source(self) -> Path:
        """The one picture, or the folder of six: the file browser gives both, whatever was chosen."""
        path = absolute_path(self.filepath) if self.filepath else None
        if path and (path.is_file() or not self.directory):
            chosen = face_of(path.stem)
            return path.parent if chosen and self.directory else path
        return self._folder()


CLASSES = (PRT_OT_import_cubemap,)
