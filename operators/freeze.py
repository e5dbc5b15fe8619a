# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the light of now as vertex colours, for programs that know no transport."""

import bpy
from bpy.props import EnumProperty

from ..prt_addon.core.errors import LightError
from ..prt_addon.core.notices import Notice, counted
from ..prt_addon.scene.blender.modes import object_mode
from ..prt_addon.scene.export.freeze import freeze
from ..prt_addon.scene.mesh import carrier
from ..prt_addon.scene.report.report import baked_objects
from .job import WhenIdle
from .reporting import reports_errors


class PRT_OT_freeze(WhenIdle, bpy.types.Operator):
    """Write the light of now into a colour attribute, PRT Light, of the selected baked meshes (all render-visible ones if none is selected)"""

    bl_idname = "prt.freeze"
    bl_label = "Freeze Light"
    bl_options = {"REGISTER", "UNDO"}

    encoding: EnumProperty(  # type: ignore[valid-type]
        name="Colours",
        description="How the colours are stored",
        items=[
            ("LINEAR", "Linear Floats", "As light adds up; brighter than 1 where the light is"),
            ("SRGB", "sRGB Floats", "As screens show them, for programs that take vertex colours as they are"),
            ("BYTE", "Bytes", "Eight bits a channel, from 0 to 1, in sRGB"),
        ],
        default="LINEAR",
    )

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        world = context.scene.world
        if world is None:
            raise LightError(f"Scene '{context.scene.name}' has no world: add one in World properties.")
        notices: list[Notice] = []
        objects = baked_objects(context)
        with object_mode(context):
            for ob in objects:
                notices += freeze(ob, world, self.encoding)
            carrier.sweep()
        for one in counted(notices):
            self.report({one.kind.level}, one.sentence)
        left_out = sum("is not frozen" in notice.kind.one for notice in notices)
        self.report({"INFO"}, f"Froze the light of {len(objects) - left_out} object(s).")
        return {"FINISHED"} if len(objects) > left_out else {"CANCELLED"}


CLASSES = (PRT_OT_freeze,)
