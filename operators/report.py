# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures how true the bakes are, writes that as JSON, and shows it in the panel."""

import errno
import json
import os
import tempfile
from pathlib import Path
from typing import Any

import bpy
from bpy.props import BoolProperty, EnumProperty, StringProperty

from ..prt_addon.core.errors import PRTError
from ..prt_addon.core.files import written
from ..prt_addon.core.monitor import Work
from ..prt_addon.core.notices import Kind, Notice, counted
from ..prt_addon.core.report.document import PARTS, VERSION, advice_lines, picture_report, surface_report
from ..prt_addon.core.report.findings import Effort
from ..prt_addon.scene.bake.freshness import freshness
from ..prt_addon.scene.blender.modes import Place, found_again, object_mode
from ..prt_addon.scene.mesh import heat_map, temporary_layer
from ..prt_addon.scene.preferences import engine_patience
from ..prt_addon.scene.report import compare, report
from ..prt_addon.scene.settings import REPORT_PARTS, ReportProperties, absolute_path, report_settings
from ..prt_addon.worker import tasks
from ..prt_addon.worker.job import Job
from .job import JobOperator

_NO_MAP = Kind(
    "{name} shows no heat map: its own mesh has other vertices than it renders with.",
    "{count} objects show no heat map, as their own meshes have other vertices than they render with: {names}.",
)


class PRT_OT_report(JobOperator, ReportProperties, bpy.types.Operator):
    """Measure how far the selected bakes (all render-visible ones if none is selected) are from the truth, and why"""

    bl_idname = "prt.report"
    bl_label = "Report"
    bl_options = {"UNDO"}

    _activity = "Measuring"

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

    def _begin(self, context: bpy.types.Context) -> Job[Any]:
        scene, self._settings = context.scene, report_settings(context.scene, self)
        self._place = Place.of(context)
        objects = report.baked_objects(context)
        if "END_TO_END" in self.parts:
            compare.check_pictures(scene, objects)
        self._light, self._shown = report.read_lighting(scene), report.shows_lamps(scene.world)
        self._stale = _stale(context, objects)
        self._warn(self._stale)
        self._file = self._path()
        self._file.parent.mkdir(parents=True, exist_ok=True)
        if not os.access(self._file.parent, os.W_OK):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(self._file.parent))
        with object_mode(context):
            self._baked, left_out = report.read_baked(context, objects)
        self._warn(one.sentence for one in counted(left_out))
        effort = Effort(self._settings.points, self._settings.paths, self._settings.seed)
        return Job(
            tasks.measure,
            [one.subject for one in self._baked],
            self._light,
            effort,
            bool(self.parts & set(PARTS)),
            self.heat_map,
            work=Work(rays=len(self._baked)),
            threads=scene.render.threads,
            patience=engine_patience(context),
            doing="measuring",
            unit="object",
        )

    def _end(self, context: bpy.types.Context, result: list[tasks.Measured]) -> None:
        with self._place.again(context):
            self._write(context, result)
        for line in advice_lines(self._document):
            self.report({"INFO"}, line)
        self._conclude(f"Wrote '{self._file}'.")

    def _write(self, context: bpy.types.Context, result: list[tasks.Measured]) -> None:
        objects = [found_again(bpy.data.objects, "Object", one.name) for one in self._baked]
        document: dict[str, Any] = {"version": VERSION, "scene": context.scene.name, "stale": self._stale}
        if found := [one.findings for one in result if one.findings]:
            document |= surface_report(found, self._light.lamps, self.parts & set(PARTS), self._shown)
        with object_mode(context):
            for ob, baked, measured in zip(objects, self._baked, result, strict=True):
                temporary_layer.take_back(ob.data)  # of an earlier report
                if measured.errors is not None and not baked.carried:
                    heat_map.write(ob.data, baked.receivers, measured.errors)
        if self.heat_map:
            self._warn(one.sentence for one in counted(Notice(_NO_MAP, one.name) for one in self._baked if one.carried))
        if "END_TO_END" in self.parts:
            document["end_to_end"] = self._pictures(context, objects)
        with written(self._file) as (path,):
            path.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")
        report.keep(context.scene, document)
        self._document = document

    def _pictures(self, context: bpy.types.Context, objects: list[bpy.types.Object]) -> dict[str, Any]:
        bounces = max(one.subject.bounce_count for one in self._baked)
        pictures = compare.Pictures(self._settings.picture_size, self._settings.picture_samples, bounces)
        difference = self._file.with_name(f"{self._file.stem}_difference.exr")
        found = compare.compare_engines(context, objects, pictures, difference)
        return picture_report(found.difference, found.flip) | {"difference": str(difference)}

    def _path(self) -> Path:
        if self.filepath:
            path = absolute_path(self.filepath)
            if path.is_dir() or self.filepath.endswith(("/", "\\")):
                raise PRTError(f"'{self.filepath}' is a folder: give the report's file a name.")
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
