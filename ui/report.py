# SPDX-License-Identifier: GPL-3.0-or-later
"""How true the bakes are: the latest report in a few lines."""

from __future__ import annotations

from typing import Any

import bpy

from ..prt_addon.core.report.document import PARTS, advice_lines
from ..prt_addon.core.report.measures import percent
from ..prt_addon.scene import report
from ..prt_addon.scene.settings import REPORT_PARTS, ReportProperties
from .tab import Tab, draw_text

_NAMES = {identifier: name for identifier, name, _ in REPORT_PARTS}


class PRT_PT_report(Tab, bpy.types.Panel):
    """How far the bakes are from the truth, why, and what to do about it"""

    bl_idname = "PRT_PT_report"
    bl_parent_id = "PRT_PT_bake"
    bl_label = "Report"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        column = self.layout.column(align=True)
        column.operator("prt.report", icon="VIEWZOOM")
        column.operator("prt.report", text="With Pictures", icon="CAMERA_DATA").parts = set(_NAMES)
        column.operator("prt.report", text="With Heat Map", icon="SHADING_RENDERED").heat_map = True
        document = report.last_report(context.scene)
        if document:
            _draw_numbers(context, self.layout.column(align=True), document)
            _draw_advice(context, self.layout.column(align=True), document)


class PRT_PT_report_settings(Tab, bpy.types.Panel):
    """How carefully a report measures"""

    bl_idname = "PRT_PT_report_settings"
    bl_parent_id = "PRT_PT_report"
    bl_label = "Settings"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        column = self.layout.column(align=True)  # names inside the fields: beside them they would be cut off
        for name in ReportProperties.__annotations__:
            column.prop(context.scene.prt.report, name)


def _draw_numbers(context: bpy.types.Context, column: bpy.types.UILayout, document: dict[str, Any]) -> None:
    """The headline of each part, with its interval."""
    measured = document.get("all", {})
    for part, name in (("TOTAL", "Whole error"), *((part, _NAMES[part]) for part in PARTS)):
        if part.lower() in measured:
            draw_text(context, column, f"{name}: {_interval(measured[part.lower()]['relative_rms'])}", "DOT")
    if "end_to_end" in document:
        found = document["end_to_end"]
        flip = "" if found["flip"] is None else f", FLIP {found['flip']:.3f}"
        draw_text(context, column, f"{_NAMES['END_TO_END']}: {_interval(found['relative_rms'])}{flip}", "DOT")


def _draw_advice(context: bpy.types.Context, column: bpy.types.UILayout, document: dict[str, Any]) -> None:
    for sentence in [*document.get("stale", []), *advice_lines(document)]:
        draw_text(context, column, sentence, "RIGHTARROW_THIN")


def _interval(number: dict[str, float | None]) -> str:
    value, low, high = number["value"], number["low"], number["high"]
    if value is None or low is None or high is None:
        return "unknown"
    return f"{percent(value)} ({percent(low)} to {percent(high)})"


CLASSES = (PRT_PT_report, PRT_PT_report_settings)
