# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks which bakes are stale."""

from collections import Counter

import bpy
from bpy.props import BoolProperty

from ..prt_addon.core.errors import MeshError
from ..prt_addon.scene.bake import choose
from ..prt_addon.scene.bake.freshness import freshness
from ..prt_addon.scene.settings import BakeProperties, bake_settings
from .reporting import reports_errors


class PRT_OT_check(BakeProperties, bpy.types.Operator):
    """Say of the selected meshes (all render-visible ones if none is selected) whether their bakes still hold, and if not, why"""

    bl_idname = "prt.check"
    bl_label = "Check Bakes"

    fail_if_stale: BoolProperty(  # type: ignore[valid-type]
        name="Fail if Stale",
        description="End with an error if a bake is stale, so that a script or a render farm stops there",
        default=False,
    )

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        found = freshness(context, choose.objects_to_bake(context), bake_settings(context.scene, self))
        for one in found:
            self.report({"INFO"}, f"'{one.name}': {one.text}.")
        stale = ", ".join(f"'{one.name}'" for one in found if one.state == "STALE")
        if stale and self.fail_if_stale:
            raise MeshError(f"Stale: {stale}. Press Bake PRT (prt.bake) to bake again.")
        counts = Counter(one.lines[0] for one in found)
        summary = ", ".join(f"{count} {headline}" for headline, count in counts.most_common())
        self.report({"INFO"}, f"{len(found)} object(s): {summary}.")
        return {"FINISHED"}


CLASSES = (PRT_OT_check,)
