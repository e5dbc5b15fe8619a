# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws the messages of the last bake, and buttons for what can be done about them."""

from __future__ import annotations

import bpy

from ..prt_addon.session import session
from .tab import Tab, draw_text

_ICONS = {"WARNING": "ERROR", "INFO": "INFO"}


class PRT_PT_notices(Tab, bpy.types.Panel):
    """What was left out of the last bake, and why"""

    bl_idname = "PRT_PT_notices"
    bl_parent_id = "PRT_PT_bake"
    bl_label = "Last Bake"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return bool(session.notices.get(context.scene.session_uid))

    def draw(self, context: bpy.types.Context) -> None:
        for index, one in enumerate(session.notices.get(context.scene.session_uid, ())):
            column = self.layout.column(align=True)
            draw_text(context, column, one.sentence, _ICONS[one.kind.level])
            row = column.row(align=True)
            row.operator("prt.select_noticed", icon="RESTRICT_SELECT_OFF").index = index
            if one.kind.fix == "prt.use_sky":
                row.menu("PRT_MT_skies", icon="WORLD")
            elif one.kind.fix:
                row.operator(one.kind.fix)


CLASSES = (PRT_PT_notices,)
