# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings, defined once: as a scene's property group, and as the properties of the operators that use them."""

import bpy
from bpy.props import EnumProperty, FloatProperty, IntProperty, PointerProperty

from ..core.bake import BakeSettings

MODES = [
    ("UNSHADOWED", "Unshadowed", "Light by direction only, in closed form: no rays, no shadows"),
    ("SHADOWED", "Shadowed", "Self-shadowing, and shadows of all objects visible to render"),
    ("INTERREFLECTED", "Interreflected", "Shadows, and light that bounces between surfaces and takes on their colours"),
]


class BakeProperties:
    """Mixin of the properties of a bake."""

    mode: EnumProperty(  # type: ignore[valid-type]
        name="Transport", description="Which light paths are baked", items=MODES, default="INTERREFLECTED"
    )
    samples: IntProperty(  # type: ignore[valid-type]
        name="Samples",
        description="Rays per vertex; four times as many rays leave about a third of the noise",
        default=256,
        min=1,
        max=1 << 20,
        soft_min=16,
        soft_max=4096,
    )
    bounces: IntProperty(  # type: ignore[valid-type]
        name="Bounces", description="How often light bounces between surfaces", default=3, min=1, max=100, soft_max=8
    )
    tolerance: FloatProperty(  # type: ignore[valid-type]
        name="Tolerance",
        description="If above zero: bounce until no coefficient changes by as much, whatever the number of bounces",
        default=0.0,
        min=0.0,
        soft_max=0.01,
        precision=5,
    )
    seed: IntProperty(  # type: ignore[valid-type]
        name="Seed", description="Another seed gives another, equally good, pattern of noise", default=0, min=0
    )


class PRT_PG_settings(BakeProperties, bpy.types.PropertyGroup):
    """Settings of the extension, stored with the scene."""


def bake_settings(scene: bpy.types.Scene, operator: bpy.types.Operator) -> BakeSettings:
    """The operator's own properties where they were given, the scene's where not."""

    def value(name: str) -> object:
        given = operator.properties.is_property_set(name)
        return getattr(operator if given else scene.prt, name)

    return BakeSettings(**{name: value(name) for name in BakeProperties.__annotations__})  # type: ignore[arg-type]


def register() -> None:
    bpy.utils.register_class(PRT_PG_settings)
    bpy.types.Scene.prt = PointerProperty(type=PRT_PG_settings, name="PRT")


def unregister() -> None:
    del bpy.types.Scene.prt
    bpy.utils.unregister_class(PRT_PG_settings)
