# SPDX-License-Identifier: GPL-3.0-or-later
"""Defines the settings once: as a scene's property group, and as the properties of the operators that use them."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty

from ..core.bake.run import MEMORY, Run
from ..core.errors import PRTError
from ..core.problem import MOST_BOUNCES, MOST_SAMPLES, BakeSettings
from ..core.sphere.sh import ORDER
from .sky.projection import LightSettings

_MIB = 1 << 20

MODES = [
    ("UNSHADOWED", "Unshadowed", "Light by direction only, in closed form: no rays, no shadows"),
    ("SHADOWED", "Shadowed", "Self-shadowing, and shadows of all objects visible to render"),
    ("INTERREFLECTED", "Interreflected", "Shadows, and light that bounces between surfaces and takes on their colours"),
]


SPACES = [
    ("SCENE", "Scene", "Shadows and bounces of everything around it; valid while nothing moves"),
    (
        "OBJECT",
        "Object",
        "Only its own shadows and bounces; the object may be moved, turned and animated freely. It still shadows objects "
        "baked for the scene, from where it stood",
    ),
]

SIDES = [
    (
        "AUTO",
        "Automatic",
        "Both where the mesh is open, as leaves, cards and curtains are; fronts alone where it is closed",
    ),
    ("FRONTS", "Fronts", "Backs show the light of the fronts, and return none"),
    ("BOTH", "Both", "Also where the mesh is closed, as a room is that is seen from inside"),
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
        max=MOST_SAMPLES,
        soft_min=16,
        soft_max=4096,
    )
    bounces: IntProperty(  # type: ignore[valid-type]
        name="Bounces",
        description="How often light bounces between surfaces",
        default=3,
        min=1,
        max=MOST_BOUNCES,
        soft_max=8,
    )
    tolerance: FloatProperty(  # type: ignore[valid-type]
        name="Tolerance",
        description="0: bounce as often as Bounces says. Above 0, such as 0.001: until no coefficient changes by as much, "
        "at most 100 times",
        default=0.0,
        min=0.0,
        soft_max=0.01,
        precision=5,
    )
    seed: IntProperty(  # type: ignore[valid-type]
        name="Seed", description="Another seed gives another, equally good, pattern of noise", default=0, min=0
    )


class MemoryProperties:
    """Mixin of what light that bounces may occupy."""

    memory: IntProperty(  # type: ignore[valid-type]
        name="Memory",
        description="Mebibytes of ray hits that an interreflected bake keeps in memory; what exceeds them lies in "
        "temporary files, which is slower and changes no result",
        default=MEMORY // _MIB,
        min=0,
        soft_min=256,
        soft_max=1 << 16,
    )


class RunProperties(MemoryProperties):
    """Mixin of how a bake is carried out, which its result does not depend on."""

    checkpoint_dir: StringProperty(  # type: ignore[valid-type]
        name="Checkpoints",
        description="Folder that keeps what rays have found so far: a bake that was stopped or killed continues from "
        "there with the same result. None if empty; delete its files when they are of no more use",
        default="",
        subtype="DIR_PATH",
        options={"PATH_SUPPORTS_BLEND_RELATIVE"},
    )


WINDOWS = [
    (
        "NONE",
        "None",
        "The nine coefficients as they are: closest to the sky, but bright suns leave negative light opposite",
    ),
    ("HANN", "Hann", "Soften band 1 a little and band 2 more, in a cosine's shape"),
    ("LANCZOS", "Lanczos", "Soften, in the shape of sin(x) / x: milder than Hann"),
    ("AUTO", "Automatic", "The mildest Hann window that leaves no negative light, whatever the cutoff"),
]


LAMPS = [
    ("NONE", "None", "Bright spots of the sky stay a soft glow"),
    ("ONE", "One", "The brightest spot: a sun"),
    ("FOUR", "Up to 4", "The four brightest spots"),
    ("EIGHT", "Up to 8", "The eight brightest spots: EEVEE takes longer for each"),
    ("AUTO", "Automatic", "As few as show the sky well, four at most"),
]


class LightProperties:
    """Mixin of how the world is projected."""

    window: EnumProperty(  # type: ignore[valid-type]
        name="Window", description="What is done against ringing, when the world is projected", items=WINDOWS
    )
    cutoff: FloatProperty(  # type: ignore[valid-type]
        name="Cutoff",
        description="The band at which the window reaches zero; less is softer",
        default=ORDER + 1.0,
        min=1.0,
        soft_max=10.0,
    )
    lamps: EnumProperty(  # type: ignore[valid-type]
        name="Extract Lamps",
        description="Which spots of the sky, such as suns and windows, light baked surfaces in EEVEE as lamps with shadows of their own",
        items=LAMPS,
        default="AUTO",
    )


REPORT_PARTS = [
    ("SAMPLING", "Sampling", "Noise of the bake's own rays, which more samples take away"),
    ("TRUNCATION", "Truncation", "What nine coefficients lose of this sky, and what other orders would"),
    ("TESSELLATION", "Tessellation", "What interpolation between vertices loses, which a finer mesh takes away"),
    (
        "END_TO_END",
        "End to End",
        "EEVEE's picture against Cycles', from the active camera: takes as long as three frames",
    ),
]


class ReportProperties:
    """Mixin of how carefully a report measures."""

    points: IntProperty(  # type: ignore[valid-type]
        name="Points",
        description="Random points of each object's surface: four times as many halve the intervals",
        default=256,
        min=16,
        max=1 << 20,
        soft_max=4096,
    )
    paths: IntProperty(  # type: ignore[valid-type]
        name="Paths",
        description="Paths per point that find the truth, twice; up to 16 times as many until it has converged",
        default=256,
        min=16,
        max=1 << 16,
        soft_max=4096,
    )
    seed: IntProperty(name="Seed", description="Another draw of points and paths", default=0, min=0)  # type: ignore[valid-type]
    picture_size: IntProperty(  # type: ignore[valid-type]
        name="Picture Size",
        description="Longer side of the compared pictures, in pixels; at most the scene's own",
        default=640,
        min=16,
        max=1 << 14,
        subtype="PIXEL",
    )
    picture_samples: IntProperty(  # type: ignore[valid-type]
        name="Picture Samples",
        description="Samples per pixel of each of Cycles' two pictures",
        default=64,
        min=1,
        max=1 << 16,
        soft_max=1024,
    )


@dataclass(frozen=True)
class ReportSettings:
    """The same as plain data."""

    points: int
    paths: int
    seed: int
    picture_size: int
    picture_samples: int


class PRT_PG_report(ReportProperties, bpy.types.PropertyGroup):
    """Settings of the report, stored with the scene."""


PRECISIONS = [
    ("FLOAT", "Float", "32 bits a number, those of the bake"),
    (
        "SHORT",
        "16 Bits",
        "Whole numbers, with scales for each layer of each mesh: half the bytes. They differ from the bake by a 65,000th of a "
        "layer's largest number at most; the export reports by how much",
    ),
]


class PRT_PG_gltf(bpy.types.PropertyGroup):
    """What File > Export > glTF writes of bakes."""

    transport: BoolProperty(  # type: ignore[valid-type]
        name="Transport",
        description="Write transport as attributes and the light beside it, for programs that relight",
        default=True,
    )
    precision: EnumProperty(  # type: ignore[valid-type]
        name="Precision", description="How transport is stored", items=PRECISIONS, default="FLOAT"
    )
    light: BoolProperty(  # type: ignore[valid-type]
        name="Light as Vertex Colors",
        description="Write the light of now as COLOR_0, from 0 to 1, for programs that know no transport. They multiply it "
        "with the base color; painted colors follow it",
        default=False,
    )


class PRT_PG_settings(BakeProperties, RunProperties, LightProperties, bpy.types.PropertyGroup):
    """Settings of the extension, stored with the scene."""

    auto_light: BoolProperty(  # type: ignore[valid-type]
        name="Follow World",
        description="Project the world again when its pictures or nodes change. Its rotation and strength are followed live "
        "anyway, without a new projection",
        default=True,
    )
    report: PointerProperty(type=PRT_PG_report, name="Report", description="Settings of the report")  # type: ignore[valid-type]
    gltf: PointerProperty(type=PRT_PG_gltf, name="glTF", description="Settings of exports as glTF")  # type: ignore[valid-type]


class PRT_PG_object(bpy.types.PropertyGroup):
    """What is chosen per object."""

    space: EnumProperty(  # type: ignore[valid-type]
        name="Baked For",
        description="What the next bake of this object takes into account, and whether the object may move afterwards",
        items=SPACES,
        default="SCENE",
    )
    sides: EnumProperty(  # type: ignore[valid-type]
        name="Sides",
        description="Which sides of its faces receive light and return it. Backs take rays, and three layers, of their own",
        items=SIDES,
        default="AUTO",
    )


def bake_settings(scene: bpy.types.Scene, operator: bpy.types.Operator) -> BakeSettings:
    """The operator's own properties where they were given, the scene's where not."""
    return BakeSettings(**_values(BakeProperties, scene.prt, operator))


def scene_settings(scene: bpy.types.Scene) -> BakeSettings:
    """What the next bake of the scene's own will be."""
    return BakeSettings(**_values(BakeProperties, scene.prt))


def light_settings(scene: bpy.types.Scene, operator: bpy.types.Operator | None = None) -> LightSettings:
    """How to project: the operator's own properties where they were given, the scene's where not.

    Raises:
        PRTError: if the cutoff is no number, which scripts can set.
    """
    found = LightSettings(**_values(LightProperties, scene.prt, operator))
    if not found.cutoff >= 1.0:
        raise PRTError(f"A window's cutoff is at least 1, not {found.cutoff}: set another, then project.")
    return found


def report_settings(scene: bpy.types.Scene, operator: bpy.types.Operator) -> ReportSettings:
    """How carefully to measure: the operator's own properties where they were given, the scene's where not."""
    return ReportSettings(**_values(ReportProperties, scene.prt.report, operator))


def begin_with_settings(operator: bpy.types.Operator, scene: bpy.types.Scene) -> None:
    """Have a dialog show what its operator will use: its own properties where they were given, the scene's where not.

    A dialog shows all properties of an operator, and left alone these would be defaults.
    """
    for mixin, stored in _stored_settings(scene).items():
        if isinstance(operator, mixin):
            for name, value in _values(mixin, stored, operator).items():
                setattr(operator, name, value)


def _stored_settings(scene: bpy.types.Scene) -> dict[type, bpy.types.PropertyGroup]:
    """Where a scene keeps the settings that operators take."""
    return {
        BakeProperties: scene.prt,
        RunProperties: scene.prt,
        MemoryProperties: scene.prt,
        LightProperties: scene.prt,
        ReportProperties: scene.prt.report,
    }


def run_settings(scene: bpy.types.Scene, operator: bpy.types.Operator | None = None) -> Run:
    """How a bake is carried out; by the scene's settings alone without an operator."""
    return Run(memory=_value("memory", scene.prt, operator) * _MIB)


def checkpoints(scene: bpy.types.Scene, operator: bpy.types.Operator) -> Path | None:
    """The folder of the checkpoints, if any are wanted."""
    path = _value("checkpoint_dir", scene.prt, operator)
    return absolute_path(path) if path else None


def absolute_path(path: str) -> Path:
    """The whole of a path that may be relative to the file.

    Raises:
        PRTError: if it is, and the file was never saved.
    """
    if path.startswith("//") and not bpy.data.filepath:
        raise PRTError(f"'{path}' is relative to a file that was never saved: save it, or give a whole path.")
    return Path(bpy.path.abspath(path))


def _values(mixin: type, stored: bpy.types.PropertyGroup, operator: bpy.types.Operator | None = None) -> dict[str, Any]:
    return {name: _value(name, stored, operator) for name in mixin.__annotations__}


def _value(name: str, stored: bpy.types.PropertyGroup, operator: bpy.types.Operator | None) -> Any:
    return getattr(operator if operator and operator.properties.is_property_set(name) else stored, name)


_register_classes, _unregister_classes = bpy.utils.register_classes_factory(
    (PRT_PG_report, PRT_PG_gltf, PRT_PG_settings, PRT_PG_object)
)


def register() -> None:
    """Add the settings to scenes and objects."""
    _register_classes()
    bpy.types.Scene.prt = PointerProperty(type=PRT_PG_settings, name="PRT")
    bpy.types.Object.prt = PointerProperty(type=PRT_PG_object, name="PRT")


def unregister() -> None:
    """Remove them."""
    del bpy.types.Scene.prt, bpy.types.Object.prt
    _unregister_classes()
