# SPDX-License-Identifier: GPL-3.0-or-later
"""How true the bakes are: the latest report in a few lines."""

from __future__ import annotations

from typing import Any

import bpy

from ..operators.report import PART_ITEMS, advice_lines
from ..prt_addon.core.report.measures import percent
from ..prt_addon.scene import report
from .tab import Tab, draw_text

_SURFACE = (("total", "Whole error"), *((item[0].lower(), item[1]) for item in PART_ITEMS[:3]))


class PRT_PT_report(Tab, bpy.types.Panel):
    """How far the bakes are from the truth, why, and what to do about it"""

    bl_idname = "PRT_PT_report"
    bl_parent_id = "PRT_PT_bake"
    bl_label = "Report"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        column = self.layout.column(align=True)
        column.operator("prt.report", icon="VIEWZOOM")
        column.operator("prt.report", text="With Pictures", icon="CAMERA_DATA").parts = {item[0] for item in PART_ITEMS}
        column.operator("prt.report", text="With Heat Map", icon="SHADING_RENDERED").heat_map = True
        document = report.last_report(context.scene)
        if document:
            _draw_numbers(context, self.layout.column(align=True), document)
            _draw_advice(context, self.layout.column(align=True), document)


def _draw_numbers(context: bpy.types.Context, column: bpy.types.UILayout, document: dict[str, Any]) -> None:
    """The headline of each part, with its interval."""
    for part, name in _SURFACE:
        if part in document.get("all", {}):
            draw_text(context, column, f"{name}: {_interval(document['all'][part]['relative_rms'])}", "DOT")
    if "end_to_end" in document:
        found = document["end_to_end"]
        flip = "" if found["flip"] is None else f", FLIP {found['flip']:.3f}"
        draw_text(context, column, f"End to end: {_interval(found['relative_rms'])}{flip}", "DOT")


def _draw_advice(context: bpy.types.Context, column: bpy.types.UILayout, document: dict[str, Any]) -> None:
    for sentence in [*document.get("stale", []), *advice_lines(document)]:
        draw_text(context, column, sentence, "RIGHTARROW_THIN")


def _interval(number: dict[str, float | None]) -> str:
    value, low, high = number["value"], number["low"], number["high"]
    if value is None or low is None or high is None:
        return "unknown"
    return f"{percent(value)} ({percent(low)} to {percent(high)})"


CLASSES = (PRT_PT_report,)
