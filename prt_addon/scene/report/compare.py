# SPDX-License-Identifier: GPL-3.0-or-later
"""Compares EEVEE's picture with Cycles', from the active camera.

Both engines render what was baked, in linear light, over nothing: all other objects hold out, so that they shade and
hide but are not compared. Cycles renders as many diffuse bounces as were baked and no more, twice, so that its
noise can be separated from the error. Every setting that is changed is put back.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np
import numpy.typing as npt

from ...core.arrays import Float32
from ...core.errors import RenderError
from ...core.files import written
from ...core.report.picture import PictureDifference, compared, flip, picture_difference
from ..blender.images import float_image
from ..shading.our_nodes import our_nodes

DIFFERENCE = "PRT Difference"
"""Name of Blender's image: |EEVEE - Cycles| in linear light, alpha 1 where they were compared."""

_EEVEE_SAMPLES = 16


@dataclass(frozen=True)
class Pictures:
    """The settings of the pictures to compare.

    size: of the longer side, at most, in pixels.
    samples: of Cycles, per pixel, twice.
    bounces: of diffuse light.
    """

    size: int
    samples: int
    bounces: int


@dataclass(frozen=True)
class Compared:
    """The result of a comparison: numbers, and FLIP where it could be measured."""

    difference: PictureDifference
    flip: float | None


def check_pictures(scene: bpy.types.Scene, objects: Sequence[bpy.types.Object]) -> None:
    """Raises RenderError, saying what to do, if the scene cannot be rendered or would not show the bakes."""
    if scene.camera is None:
        raise RenderError(f"Scene '{scene.name}' has no camera: add one, or leave the comparison of pictures out.")
    if not hasattr(scene, "cycles"):
        raise RenderError("Cycles is disabled: enable it in Preferences > Add-ons, or leave the comparison out.")
    for ob in objects:
        if not any(slot.material and any(our_nodes(slot.material.node_tree)) for slot in ob.material_slots):
            raise RenderError(f"'{ob.name}' does not show its bake: press Add Shading (prt.add_shading).")


def compare_engines(
    context: bpy.types.Context, objects: Sequence[bpy.types.Object], pictures: Pictures, difference: Path
) -> Compared:
    """Render both and compare; keeps the difference as Blender image and file (OpenEXR, 32 bit).

    Raises:
        RenderError: see `check_pictures`.
        OSError: if the file cannot be written.
    """
    scene = context.scene
    check_pictures(scene, objects)
    with tempfile.TemporaryDirectory(prefix="prt-report-") as folder, _alike(context, objects, pictures):
        path = Path(folder) / "picture.exr"
        scene.render.engine = "BLENDER_EEVEE_NEXT" if bpy.app.version < (5, 0, 0) else "BLENDER_EEVEE"
        ours = _rendered(scene, path)
        scene.render.engine = "CYCLES"
        truths = []
        for seed in (1, 2):
            scene.cycles.seed = seed
            truths.append(_rendered(scene, path))
        both = np.stack(truths)
        mask = compared(ours, both)
        truth = both.mean(axis=0)
        seen = [np.where(mask[..., None], one, np.float32(0.0)) for one in (ours, truth)]
        shown, wanted = (_displayed(scene, one, Path(folder) / "displayed.png") for one in seen)
    _keep_difference(np.abs(seen[0] - seen[1]), mask, difference)
    return Compared(picture_difference(ours, both), flip(shown, wanted, mask))


@contextmanager
def _alike(context: bpy.types.Context, objects: Sequence[bpy.types.Object], pictures: Pictures) -> Iterator[None]:
    """Settings under which both engines render the same light; the user's own again afterwards."""
    scene = context.scene
    render, cycles, image = scene.render, scene.cycles, scene.render.image_settings
    longer = max(render.resolution_x, render.resolution_y)
    percentage = max(1, min(render.resolution_percentage, 100 * pictures.size // longer))
    wanted: list[tuple[bpy.types.bpy_struct, dict[str, object]]] = [
        (image, {"media_type": "IMAGE"} if hasattr(image, "media_type") else {}),  # 5.0: decides on the formats
        (image, {"file_format": "OPEN_EXR", "color_mode": "RGBA", "color_depth": "32"}),
        (render, {"engine": render.engine, "filepath": render.filepath, "film_transparent": True}),
        (render, {"resolution_percentage": percentage, "use_compositing": False, "use_sequencer": False}),
        (render, {"use_motion_blur": False, "use_border": False, "use_file_extension": True, "use_overwrite": True}),
        (scene.eevee, {"taa_render_samples": min(scene.eevee.taa_render_samples, _EEVEE_SAMPLES)}),
        (cycles, {"samples": pictures.samples, "seed": cycles.seed, "use_animated_seed": False, "time_limit": 0.0}),
        (cycles, {"use_adaptive_sampling": False, "use_denoising": False, "use_fast_gi": False}),
        (cycles, {"max_bounces": pictures.bounces, "diffuse_bounces": pictures.bounces}),
        (cycles, {"sample_clamp_direct": 0.0, "sample_clamp_indirect": 0.0}),
    ]
    for ob in bpy.data.objects:  # also those that only their instances show
        if ob.is_editable:
            wanted.append((ob, {"is_holdout": ob not in objects}))
    before = [(owner, {name: getattr(owner, name) for name in values}) for owner, values in wanted]
    try:
        _set(wanted)
        yield
    finally:
        _set(before)


def _set(settings: Sequence[tuple[bpy.types.bpy_struct, dict[str, object]]]) -> None:
    for owner, values in settings:
        for name, value in values.items():
            if getattr(owner, name) != value:
                setattr(owner, name, value)


def _rendered(scene: bpy.types.Scene, path: Path) -> Float32:
    """(H, W, 4) linear pixels of a frame."""
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True, scene=scene.name)
    return _loaded(path)


def _loaded(path: Path, encoded: bool = False) -> Float32:
    image = bpy.data.images.load(str(path), check_existing=False)
    try:
        if encoded:
            image.colorspace_settings.is_data = True
        width, height = image.size
        flat = np.empty(width * height * image.channels, dtype=np.float32)
        image.pixels.foreach_get(flat)
    finally:
        bpy.data.images.remove(image)
    return flat.reshape(height, width, -1)


def _displayed(scene: bpy.types.Scene, pixels: Float32, path: Path) -> Float32:
    """(H, W, 3) a linear picture as the scene's view transform shows it, encoded, in [0, 1]."""
    image = float_image("PRT Displayed", pixels)
    settings = scene.render.image_settings
    settings.file_format, settings.color_mode, settings.color_depth = "PNG", "RGB", "16"
    try:
        image.save_render(str(path), scene=scene)
    finally:
        bpy.data.images.remove(image)
    return np.ascontiguousarray(_loaded(path, encoded=True)[..., :3])


def _keep_difference(difference: Float32, mask: npt.NDArray[np.bool_], path: Path) -> None:
    """Keep |EEVEE - Cycles| (H, W, 4)."""
    remove_difference()
    difference[..., 3] = mask
    image = float_image(DIFFERENCE, difference)
    image.use_fake_user = True
    image.file_format = "OPEN_EXR"
    try:
        with written(path) as (temporary,):
            image.filepath_raw = str(temporary)
            image.save()
    except RuntimeError as error:  # Blender's word for a file that cannot be written
        raise OSError(None, str(error).strip(), str(path)) from error
    finally:
        image.filepath_raw = str(path)


def remove_difference() -> None:
    """Remove the picture that a comparison has kept in the file."""
    former = bpy.data.images.get(DIFFERENCE)
    if former:
        bpy.data.images.remove(former)
