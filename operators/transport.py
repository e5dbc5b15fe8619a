# SPDX-License-Identifier: GPL-3.0-or-later
"""Shows the transport itself as colours on the meshes, and takes it off again."""

import bpy
from bpy.props import EnumProperty

from ..prt_addon.core.notices import Notice, counted
from ..prt_addon.scene.blender.modes import object_mode
from ..prt_addon.scene.mesh import temporary_layer, transport_view
from ..prt_addon.scene.report.report import baked_objects
from .job import WhenIdle
from .reporting import reports_errors

_PARTS = [
    ("T0", "Coefficient 0", "How open a surface is, and what colours reach it; white is all of the sky"),
    *(
        (f"T{i}", f"Coefficient {i}", f"Of Y_{i}, {what}; grey is 0")
        for i, what in enumerate(("y", "z", "x", "xy", "yz", "3z² - 1", "xz", "x² - y²"), start=1)
    ),
    (
        "BAND1",
        "Band 1",
        "The length of coefficients 1 to 3: how much it matters from which side of the sky light comes",
    ),
    ("BAND2", "Band 2", "The length of coefficients 4 to 8"),
]


class PRT_OT_show_transport(WhenIdle, bpy.types.Operator):
    """Show what was baked as the active colours of the selected meshes (all render-visible baked ones if none is selected), PRT Transport: for views in Solid shading with the colour Attribute"""

    bl_idname = "prt.show_transport"
    bl_label = "Show Transport"
    bl_options = {"REGISTER", "UNDO"}

    part: EnumProperty(name="Part", description="What of it", items=_PARTS, default="T0")  # type: ignore[valid-type]

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        notices: list[Notice] = []
        objects = baked_objects(context)
        with object_mode(context):
            for ob in objects:
                notices += transport_view.show(ob, self.part)
        for one in counted(notices):
            self.report({one.kind.level}, one.sentence)
        self.report({"INFO"}, f"{len(objects) - len(notices)} object(s) show their transport.")
        return {"FINISHED"} if len(objects) > len(notices) else {"CANCELLED"}


class PRT_OT_hide_transport(WhenIdle, bpy.types.Operator):
    """Take the colours of transport off all meshes again, and make active what was before"""

    bl_idname = "prt.hide_transport"
    bl_label = "Hide Transport"
    bl_options = {"REGISTER", "UNDO"}

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        with object_mode(context):
            meshes = {ob.data for ob in context.scene.objects if ob.type == "MESH"}
            hidden = sum(temporary_layer.take_back(mesh, (temporary_layer.TRANSPORT,)) for mesh in meshes)
        self.report({"INFO"}, f"{hidden} mesh(es) showed transport, and no longer do.")
        return {"FINISHED"}


CLASSES = (PRT_OT_show_transport, PRT_OT_hide_transport)
