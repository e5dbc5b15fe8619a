# SPDX-License-Identifier: GPL-3.0-or-later
"""How true the bakes are: measured, written as JSON, and shown in the panel."""

import json
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import bpy
from bpy.props import BoolProperty, EnumProperty, IntProperty, StringProperty

from ..prt_addon.core.parallel import Workers
from ..prt_addon.core.report.document import PARTS, VERSION, picture_report, surface_report
from ..prt_addon.core.report.findings import Effort, find
from ..prt_addon.core.report.heat import receiver_errors
from ..prt_addon.core.report.subject import Light
from ..prt_addon.scene import compare, heat_map, report
from ..prt_addon.scene.freshness import freshness
from ..prt_addon.scene.modes import object_mode
from ..prt_addon.scene.settings import absolute_path
from .job import WhenIdle
from .reporting import reports_errors

PART_ITEMS = [
    ("SAMPLING", "Sampling", "Noise of the bake's own rays, which more samples take away"),
    ("TRUNCATION", "Truncation", "What nine coefficients lose of this sky, and what other orders would"),
    ("TESSELLATION", "Tessellation", "What interpolation between vertices loses, which a finer mesh takes away"),
    (
        "END_TO_END",
        "End to End",
        "EEVEE's picture against Cycles', from the active camera: takes as long as three frames",
    ),
]


class PRT_OT_report(WhenIdle, bpy.types.Operator):
    """Measure how far the selected bakes (all render-visible ones if none is selected) are from the truth, and why, and say what to do about it"""

    bl_idname = "prt.report"
    bl_label = "Report"
    bl_options = {"REGISTER", "UNDO"}

    parts: EnumProperty(  # type: ignore[valid-type]
        name="Parts",
        description="What to measure",
        items=PART_ITEMS,
        options={"ENUM_FLAG", "SKIP_SAVE"},  # the panel has a button for each choice
        default=set(PARTS),
    )
    points: IntProperty(  # type: ignore[valid-type]
        name="Points",
        description="Random points of each object's surface: four times as many halve the intervals",
        default=256,
        min=16,
        max=1 << 20,
        soft_max=4096,
    )
    samples: IntProperty(  # type: ignore[valid-type]
        name="Paths",
        description="Paths per point that find the truth, twice; up to 16 times as many until it has converged",
        default=256,
        min=16,
        max=1 << 16,
        soft_max=4096,
    )
    seed: IntProperty(name="Seed", description="Another draw of points and paths", default=0, min=0)  # type: ignore[valid-type]
    heat_map: BoolProperty(  # type: ignore[valid-type]
        name="Heat Map",
        description="Also show the error at every vertex as a colour layer, blue where too dark and red where too bright, "
        "until the next report or Remove",
        default=False,
        options={"SKIP_SAVE"},
    )
    picture_size: IntProperty(  # type: ignore[valid-type]
        name="Picture Size",
        description="Longer side of the compared pictures, in pixels; at most the scene's own",
        default=640,
        min=16,
        max=1 << 14,
        subtype="PIXEL",
    )
    picture_samples: IntProperty(  # type: ignore[valid-type]
        name="Picture Samples",
        description="Samples per pixel of each of Cycles' two pictures",
        default=64,
        min=1,
        max=1 << 16,
        soft_max=1024,
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
        scene = context.scene
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
            document |= self._surface(context, baked, light)
        if "END_TO_END" in self.parts:
            document["end_to_end"] = self._pictures(context, baked, path)
        path.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")
        report.keep(scene, document)
        for line in advice_lines(document):
            self.report({"INFO"}, line)
        self.report({"INFO"}, f"Wrote '{path}'.")
        return {"FINISHED"}

    def _surface(self, context: bpy.types.Context, baked: list[report.Baked], light: Light) -> dict[str, Any]:
        """All but the pictures; and the heat maps, which an earlier report may have left."""
        workers = Workers(context.scene.render.threads)
        measured = self.parts & set(PARTS)
        found = []
        for one in _counted(context, baked):
            if measured:
                found.append(find(one.subject, light, Effort(self.points, self.samples, self.seed), workers))
            heat_map.remove(one.ob.data)
            if self.heat_map:
                heat_map.write(one.ob.data, one.receivers, receiver_errors(one.subject, light, self.seed, workers))
        return surface_report(found, light.suns.share, measured) if found else {}

    def _pictures(self, context: bpy.types.Context, baked: list[report.Baked], path: Path) -> dict[str, Any]:
        bounces = max(one.subject.bounce_count for one in baked)
        pictures = compare.Pictures(self.picture_size, self.picture_samples, bounces)
        difference = path.with_name(f"{path.stem}_difference.exr")
        found = compare.compare_engines(context, [one.ob for one in baked], pictures, difference)
        return picture_report(found.apart, found.flip) | {"difference": str(difference)}

    def _path(self) -> Path:
        if self.filepath:
            return absolute_path(self.filepath).with_suffix(".json")
        if bpy.data.filepath:
            return Path(bpy.data.filepath).with_suffix(".prt_report.json")
        return Path(tempfile.gettempdir()) / "prt_report.json"


def advice_lines(document: dict[str, Any]) -> list[str]:
    """What a report says to do, a line per part."""
    lines = list(document.get("all", {}).get("advice", {}).values())
    if "end_to_end" in document:
        lines += [line for line in (document["end_to_end"]["advice"], document["end_to_end"]["note"]) if line]
    return lines


def _counted(context: bpy.types.Context, baked: list[report.Baked]) -> Iterator[report.Baked]:
    """One after the other, with a number at the cursor."""
    manager = context.window_manager
    manager.progress_begin(0, len(baked))
    try:
        for number, one in enumerate(baked):
            manager.progress_update(number)
            yield one
    finally:
        manager.progress_end()


def _stale(context: bpy.types.Context, objects: list[bpy.types.Object]) -> list[str]:
    """A sentence for each bake that is not of the scene as it is; other settings for the next bake do not matter."""
    return [
        f"'{one.name}' is {one.text}: what has changed since its bake is counted as error."
        for one in freshness(context, objects)
        if set(one.causes) - {"SETTINGS"}
    ]


CLASSES = (PRT_OT_report,)
