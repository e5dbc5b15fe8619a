# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws the latest report in a few lines: how true the bakes are."""

from __future__ import annotations

import json
from collections.abc import Iterator
from functools import lru_cache
from typing import Any

import bpy

from ..prt_addon.core.report.document import PARTS, advice_lines
from ..prt_addon.core.report.measures import percent
from ..prt_addon.scene.report import report
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
        text = context.scene.get(report.LAST_REPORT)
        column = self.layout.column(align=True)
        for line, icon in _lines(text) if isinstance(text, str) else ():
            draw_text(context, column, line, icon)


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


@lru_cache(maxsize=8)
def _lines(text: str) -> list[tuple[str, str]]:
    """What a stored report says, each with its icon. Read once, as panels are drawn at every move of the mouse."""
    try:
        document = json.loads(text)
        advice = [(sentence, "RIGHTARROW_THIN") for sentence in [*document.get("stale", []), *advice_lines(document)]]
        return [(number, "DOT") for number in _numbers(document)] + [(str(line), icon) for line, icon in advice]
    except (ValueError, KeyError, TypeError, AttributeError):
        return [("The report that was kept with this scene is damaged: make another.", "ERROR")]


def _numbers(document: dict[str, Any]) -> Iterator[str]:
    """The headline of each part, with its interval."""
    measured = document.get("all", {})
    for part, name in (("TOTAL", "Whole error"), *((part, _NAMES[part]) for part in PARTS)):
        if part.lower() in measured:
            yield f"{name}: {_interval(measured[part.lower()]['relative_rms'])}"
    if "end_to_end" in document:
        found = document["end_to_end"]
        flip = "" if found["flip"] is None else f", FLIP {found['flip']:.3f}"
        yield f"{_NAMES['END_TO_END']}: {_interval(found['relative_rms'])}{flip}"


def _interval(number: dict[str, float | None]) -> str:
    value, low, high = number["value"], number["low"], number["high"]
    if value is None or low is None or high is None:
        return "unknown"
    return f"{percent(value)} ({percent(low)} to {percent(high)})"


CLASSES = (PRT_PT_report, PRT_PT_report_settings)
