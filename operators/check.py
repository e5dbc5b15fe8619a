# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether what is baked still holds."""

from collections import Counter

import bpy

from ..prt_addon.scene import gather
from ..prt_addon.scene.freshness import freshness
from ..prt_addon.scene.settings import BakeProperties, bake_settings
from .reporting import reports_errors


class PRT_OT_check(BakeProperties, bpy.types.Operator):
    """Say of the selected meshes (all render-visible ones if none is selected) whether their bakes still hold, and if not, why"""

    bl_idname = "prt.check"
    bl_label = "Check Bakes"
    bl_options = {"REGISTER"}

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        found = freshness(context, gather.objects_to_bake(context), bake_settings(context.scene, self))
        for one in found:
            self.report({"INFO"}, f"'{one.name}': {one.text}.")
        counts = Counter(one.lines[0] for one in found)
        told = ", ".join(f"{count} {headline}" for headline, count in counts.most_common())
        self.report({"INFO"}, f"{len(found)} object(s): {told}.")
        return {"FINISHED"}


CLASSES = (PRT_OT_check,)
