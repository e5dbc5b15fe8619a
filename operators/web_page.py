# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the scene as a web page in which its sky can be turned."""

from pathlib import Path

import bpy
from bpy.props import BoolProperty, EnumProperty, StringProperty
from bpy_extras.io_utils import ExportHelper

from ..prt_addon.core.errors import PRTError
from ..prt_addon.core.notices import counted
from ..prt_addon.scene.bake import freshness
from ..prt_addon.scene.export.web_page import PageSettings, export_page
from ..prt_addon.scene.settings import absolute_path
from ..prt_addon.scene.sky.studio import studio_skies
from .job import WhenIdle
from .reporting import reports_errors

_SKIES = [
    (name, name.title(), f"Blender's own picture of that name: {path.name}", 1 << index)
    for index, (name, path) in enumerate(studio_skies().items())
]


class PRT_OT_export_web_page(WhenIdle, ExportHelper, bpy.types.Operator):
    """Write what renders as one web page, which needs no network: people look around in it, and turn the sky"""

    bl_idname = "prt.export_web_page"
    bl_label = "Export Web Page"

    filename_ext = ".html"
    filepath: StringProperty(  # type: ignore[valid-type]
        name="File Path",
        description="Where the page goes",
        subtype="FILE_PATH",
        options={"PATH_SUPPORTS_BLEND_RELATIVE"},  # without it Blender 5.2 crashes at a path that begins with //
    )
    filter_glob: StringProperty(default="*.html", options={"HIDDEN"})  # type: ignore[valid-type]

    title: StringProperty(  # type: ignore[valid-type]
        name="Title",
        description="What the page is called; if empty, as the file is, or the scene",
        options={"SKIP_SAVE"},
    )
    skies: EnumProperty(  # type: ignore[valid-type]
        name="More Skies",
        description="HDRIs that Blender ships, to choose from in the page beside the scene's own sky; about 0.5 MB each",
        items=_SKIES,
        options={"ENUM_FLAG"},
        default=set(),
    )
    sky_height: EnumProperty(  # type: ignore[valid-type]
        name="Sky",
        description="How finely the scene's own sky is shown. Its light is exact in any case",
        items=[
            ("256", "512 × 256", "About 0.5 MB"),
            ("512", "1024 × 512", "About 2 MB"),
            ("1024", "2048 × 1024", "About 7 MB"),
        ],
        default="512",
    )
    still: BoolProperty(  # type: ignore[valid-type]
        name="Still Picture",
        description="Render the camera's view in EEVEE, for browsers that cannot draw the scene and until it is there",
        default=True,
    )

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        path = self._path()
        settings = PageSettings(self.title, sorted(self.skies), int(self.sky_height), self.still)
        page = export_page(context, path, settings)
        for one in counted(page.notices):
            self.report({one.kind.level}, one.sentence)
        for ob in page.baked:
            causes = freshness.glance(context, ob).causes
            if stale := [phrase for cause, phrase in causes.items() if cause != "SETTINGS"]:
                self.report(
                    {"WARNING"}, f"The bake of '{ob.name}' is stale: {', '.join(stale)}. Bake and export again."
                )
        if self.still and not page.still:
            why = "could not be rendered" if context.scene.camera else "needs a camera, and the scene has none"
            self.report({"WARNING"}, f"The page has no still picture: it {why}.")
        self.report({"INFO"}, f"Wrote '{path}': {page.vertices:,} baked vertices, {page.size / 1e6:.1f} MB.")
        return {"FINISHED"}

    def _path(self) -> Path:
        if not self.filepath:
            raise PRTError("There is no file to write to: give its path as 'filepath'.")
        path = absolute_path(self.filepath)
        if path.is_dir():
            raise PRTError(f"'{self.filepath}' is a folder: give the page's file a name.")
        return path if path.suffix.lower() in {".html", ".htm"} else path.with_name(f"{path.name}.html")


CLASSES = (PRT_OT_export_web_page,)
