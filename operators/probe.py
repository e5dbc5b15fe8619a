# SPDX-License-Identifier: GPL-3.0-or-later
"""Shows the SH light: as a sphere in the scene, or as a picture."""

import bpy
from bpy.props import EnumProperty

from ..prt_addon.core.errors import LightError
from ..prt_addon.scene.light import light
from ..prt_addon.scene.light import picture as light_picture
from ..prt_addon.scene.shading import probe
from .reporting import reports_errors

KINDS = [
    (
        "PICTURE",
        "Picture",
        "An equirectangular image: the sky on the left, what the SH light kept of it on the right, both as they are "
        "turned now",
    ),
    (
        "PROBE",
        "Probe",
        "A sphere at the 3D cursor that shows, along its normals, what the SH light holds in that direction, in EEVEE and "
        "live. It is hidden in renders and shadows nothing",
    ),
]


class PRT_OT_show_light(bpy.types.Operator):
    """Show what the projection kept of the sky: as an image beside the sky itself, or on a sphere in the scene"""

    bl_idname = "prt.show_light"
    bl_label = "Show Light"
    bl_options = {"REGISTER", "UNDO"}

    kind: EnumProperty(  # type: ignore[valid-type]
        name="As", description="What to look at", items=KINDS, default="PICTURE"
    )

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        if not light.has_light(context.scene.world):
            raise LightError("There is no SH light to show: press Project World (prt.project_light) first.")
        if self.kind == "PROBE":
            made = probe.ensure_probe(context.scene)
            self.report({"INFO"}, f"Object '{made.name}' shows the light, in EEVEE.")
            return {"FINISHED"}
        image, beside_sky = light_picture.make_picture(context.scene)
        elsewhere = "" if _show_in_editor(context, image) else " Open it in an Image Editor."
        sides = "the sky on the left, its light on the right" if beside_sky else "the light"
        energy = light_picture.band_energy(context.scene.world)
        shares = " + ".join(f"{share:.1%}" for share in energy.bands)
        whose = "the sky's energy" if energy.of_sky else "its energy"
        bands = f"Bands 0, 1 and 2 hold {shares} of {whose}."
        self.report({"INFO"}, f"Image '{image.name}' shows {sides}. {bands}{elsewhere}")
        return {"FINISHED"}


def _show_in_editor(context: bpy.types.Context, image: bpy.types.Image) -> bool:
    """Put an image into an open Image Editor; False if there is none."""
    areas = context.screen.areas if context.screen else ()
    editor = next((area for area in areas if area.type == "IMAGE_EDITOR"), None)
    if editor:
        editor.spaces.active.image = image
    return editor is not None


CLASSES = (PRT_OT_show_light,)
