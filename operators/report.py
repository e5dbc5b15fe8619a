# SPDX-License-Identifier: GPL-3.0-or-later
"""How true the bakes are: measured, written as JSON, and shown in the panel."""

import json
import tempfile
from pathlib import Path
from typing import Any

import bpy
from bpy.props import BoolProperty, EnumProperty, StringProperty

from ..prt_addon.core.parallel import Workers
from ..prt_addon.core.report.document import PARTS, VERSION, advice_lines, picture_report, surface_report
from ..prt_addon.core.report.findings import Effort, find
from ..prt_addon.core.report.heat import receiver_errors
from ..prt_addon.core.report.subject import Light
from ..prt_addon.scene import compare, heat_map, report
from ..prt_addon.scene.freshness import freshness
from ..prt_addon.scene.modes import object_mode
from ..prt_addon.scene.settings import (
    REPORT_PARTS,
    ReportProperties,
    ReportSettings,
    absolute_path,
    report_settings,
)
from .job import WhenIdle
from .progress import counted
from .reporting import reports_errors


class PRT_OT_report(WhenIdle, ReportProperties, bpy.types.Operator):
    """Measure how far the selected bakes (all render-visible ones if none is selected) are from the truth, and why"""

    bl_idname = "prt.report"
    bl_label = "Report"
    bl_options = {"UNDO"}

    parts: EnumProperty(  # type: ignore[valid-type]
        name="Parts",
        description="What to measure",
        items=REPORT_PARTS,
        options={"ENUM_FLAG", "SKIP_SAVE"},  # the panel has a button for each choice
        default=set(PARTS),
    )
    heat_map: BoolProperty(  # type: ignore[valid-type]
        name="Heat Map",
        description="Also show the error at every vertex as a colour layer, blue where too dark and red where too bright, "
        "until the next report or Remove PRT",
        default=False,
        options={"SKIP_SAVE"},
    )
    filepath: StringProperty(  # type: ignore[valid-type]
        name="File",
        description="Where the report is written as JSON, and the difference of the pictures beside it; if empty, beside the "
        ".blend, or in the temporary folder",
        subtype="FILE_PATH",
        options={"PATH_SUPPORTS_BLEND_RELATIVE", "SKIP_SAVE"},
    )

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        scene, settings = context.scene, report_settings(context.scene, self)
        objects = report.baked_objects(context)
        if "END_TO_END" in self.parts:
            compare.check_pictures(scene, objects)
        light = report.read_light(scene)
        stale = _stale(context, objects)
        for sentence in stale:
            self.report({"WARNING"}, sentence)
        path = self._path()
        document: dict[str, Any] = {"version": VERSION, "scene": scene.name, "stale": stale}
        with object_mode(context):
            baked = report.read_baked(context, objects)
            path.parent.mkdir(parents=True, exist_ok=True)
            document |= self._surface(baked, light, settings, scene.render.threads)
        if "END_TO_END" in self.parts:
            document["end_to_end"] = self._pictures(context, baked, settings, path)
        path.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")
        report.keep(scene, document)
        for line in advice_lines(document):
            self.report({"INFO"}, line)
        self.report({"INFO"}, f"Wrote '{path}'.")
        return {"FINISHED"}

    def _surface(
        self, baked: list[report.Baked], light: Light, settings: ReportSettings, threads: int
    ) -> dict[str, Any]:
        """All but the pictures; and the heat maps, which an earlier report may have left."""
        workers, effort = Workers(threads), Effort(settings.points, settings.paths, settings.seed)
        measured = self.parts & set(PARTS)
        found = []
        for one in counted(baked):
            if measured:
                found.append(find(one.subject, light, effort, workers))
            heat_map.remove(one.ob.data)
            if self.heat_map:
                heat_map.write(one.ob.data, one.receivers, receiver_errors(one.subject, light, settings.seed, workers))
        return surface_report(found, light.suns.share, measured) if found else {}

    def _pictures(
        self, context: bpy.types.Context, baked: list[report.Baked], settings: ReportSettings, path: Path
    ) -> dict[str, Any]:
        bounces = max(one.subject.bounce_count for one in baked)
        pictures = compare.Pictures(settings.picture_size, settings.picture_samples, bounces)
        difference = path.with_name(f"{path.stem}_difference.exr")
        found = compare.compare_engines(context, [one.ob for one in baked], pictures, difference)
        return picture_report(found.apart, found.flip) | {"difference": str(difference)}

    def _path(self) -> Path:
        if self.filepath:
            path = absolute_path(self.filepath)
            return path if path.suffix.lower() == ".json" else path.with_name(f"{path.name}.json")
        if bpy.data.filepath:
            return Path(bpy.data.filepath).with_suffix(".prt_report.json")
        return Path(tempfile.gettempdir()) / "prt_report.json"


def _stale(context: bpy.types.Context, objects: list[bpy.types.Object]) -> list[str]:
    """A sentence for each bake that is not of the scene as it is; other settings for the next bake do not matter."""
    return [
        f"'{one.name}' is {one.text}: what has changed since its bake is counted as error."
        for one in freshness(context, objects)
        if set(one.causes) - {"SETTINGS"}
    ]


CLASSES = (PRT_OT_report,)
