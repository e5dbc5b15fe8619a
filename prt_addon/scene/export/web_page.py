# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the scene as a web page in one file: its objects as packed glTF; its sky and others; its camera and view transform."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import numpy.typing as npt
from mathutils import Vector

from ...core.errors import LightError, MeshError, PRTError
from ...core.exchange.glb import Glb
from ...core.exchange.gltf_extras import SceneLight, suns_as_extras
from ...core.exchange.packing import pack_transport
from ...core.exchange.radiance import radiance_file, resized
from ...core.exchange.web_page import assembled
from ...core.files import written
from ...core.notices import Kind, Notice
from ...core.sky.projection import project_equirect
from ..blender.images import linear_pixels
from ..light.light import has_light
from ..material.reading import Constant, read_material
from ..mesh.carrier import transport_mesh
from ..mesh.layers import is_baked
from ..sky.projection import lamp_rule, lamps_in, sky_picture
from ..sky.sky import read_sky
from ..sky.studio import studio_skies
from .gltf import light_of, with_transport
from .still import still_picture
from .view_tables import view_table

VIEWER = Path(__file__).with_name("viewer.html")
"""Built from `web/packages/viewer`."""

_OTHER_SKIES_HEIGHT = 256
_GLTF: dict[str, object] = {
    "export_format": "GLB",
    "export_apply": True,
    "export_animations": False,
    "export_skins": False,
    "export_morph": False,
    "export_extras": False,
    "export_cameras": False,
    "export_lights": False,
    "use_active_scene": True,
    "use_renderable": True,
}


@dataclass(frozen=True)
class PageSettings:
    """What goes into a page beside the scene.

    title: empty for the file's name, or the scene's.
    skies: names of HDRIs that Blender ships.
    sky_height: rows of the scene's own sky, at most.
    still: whether to render a picture for browsers that cannot draw.
    """

    title: str
    skies: Sequence[str]
    sky_height: int
    still: bool


@dataclass(frozen=True)
class Page:
    """What was written: baked objects, vertices with transport, the file's bytes, whether it holds a still; what is not as in Blender."""

    baked: list[bpy.types.Object]
    vertices: int
    size: int
    still: bool
    notices: list[Notice]


_COLOURLESS = Kind(
    "Material {name} is white in the page: Blender's glTF exporter reads colours of a Principled BSDF alone.",
    "{count} materials are white in the page, as Blender's glTF exporter reads colours of a Principled BSDF alone: {names}.",
)


def export_page(context: bpy.types.Context, path: Path, settings: PageSettings) -> Page:
    """Write the page.

    Raises:
        MeshError: if nothing that renders is baked.
        LightError, PictureError: if there is no light, or its sky cannot be read.
        PRTError: if Blender's glTF exporter is off.
        OSError: if the file cannot be written.
    """
    scene = context.scene
    baked = [ob for ob in scene.objects if ob.type == "MESH" and not ob.hide_render and is_baked(transport_mesh(ob))]
    if not baked:
        raise MeshError("Nothing that renders is baked: press Bake PRT (prt.bake), then export.")
    if not has_light(scene.world):
        raise LightError("The scene's world carries no SH light: press Project World (prt.project_light).")
    model = Glb(_gltf(scene))
    notices = _mend_colours(model)
    files: dict[str, bytes] = {}
    studio = (_studio_sky(name, scene.prt.lamps, files) for name in settings.skies)
    skies = [_own_sky(scene, settings.sky_height, files), *studio]
    suns = any(sky["suns"] for sky in skies)
    vertices = pack_transport(model, suns)
    files["prt-model"] = model.written()
    views, view = _views(scene, files)
    description = {
        "title": settings.title or Path(bpy.data.filepath).stem or scene.name,
        "camera": _camera(scene, baked),
        "exposure": scene.view_settings.exposure,
        "skies": skies,
        "suns": dict(zip(("most", "enough"), lamp_rule(scene.prt.lamps if suns else "NONE"), strict=True)),
        "views": views,
        "view": view,
    }
    still = still_picture(scene) if settings.still else None
    page = assembled(VIEWER.read_text(encoding="utf-8"), description, files, still)
    with written(path) as (temporary,):
        temporary.write_text(page, encoding="utf-8", newline="\n")
    return Page(baked, vertices, len(page.encode()), still is not None, notices)


def _gltf(scene: bpy.types.Scene) -> bytes:
    if "gltf" not in dir(bpy.ops.export_scene):
        raise PRTError("Blender's glTF exporter is off: enable glTF 2.0 format in Preferences > Add-ons, then export.")
    with tempfile.TemporaryDirectory(prefix="prt-page-") as folder, with_transport(scene):
        path = Path(folder) / "scene.glb"
        bpy.ops.export_scene.gltf(filepath=str(path), **_GLTF)
        return path.read_bytes()


def _mend_colours(model: Glb) -> list[Notice]:
    """Give materials that the exporter cannot read the one colour that they have; on those with more, a notice each."""
    notices = []
    for material in model.document.get("materials", ()):
        known = bpy.data.materials.get(material.get("name", ""))
        if "pbrMetallicRoughness" in material or known is None:
            continue
        colour = read_material(known, "EEVEE").colour
        if isinstance(colour, Constant):
            material["pbrMetallicRoughness"] = {"baseColorFactor": [*colour.rgb, 1.0], "metallicFactor": 0.0}
            material.setdefault("extensions", {})["KHR_materials_specular"] = {"specularFactor": 0.0}
        elif colour is not None:
            notices.append(Notice(_COLOURLESS, known.name))
    return notices


def _own_sky(scene: bpy.types.Scene, height: int, files: dict[str, bytes]) -> dict[str, Any]:
    sky, world = read_sky(scene), scene.world
    image = sky.texture.image if sky.texture else None
    name = Path(image.name).stem.replace("_", " ").title() if image else world.name
    return _sky(name, light_of(world), resized(sky_picture(sky), height), files)


def _studio_sky(name: str, wanted: str, files: dict[str, bytes]) -> dict[str, Any]:
    """A sky that Blender ships, with so many lamps as are wanted of skies."""
    image = bpy.data.images.load(str(studio_skies()[name]), check_existing=False)
    try:
        pixels = linear_pixels(image)
    finally:
        bpy.data.images.remove(image)
    lamps = lamps_in(pixels, wanted)
    light = SceneLight(project_equirect(pixels, interpolated=True), lamps.coloured_light(), lamps, np.eye(3), 1.0)
    return _sky(name.title(), light, resized(pixels, _OTHER_SKIES_HEIGHT), files)


def _sky(name: str, light: SceneLight, picture: npt.NDArray[np.float32], files: dict[str, bytes]) -> dict[str, Any]:
    file = f"prt-sky-{sum(key.startswith('prt-sky') for key in files)}"
    files[file] = radiance_file(picture)
    return {
        "name": name,
        "light": light.light.tolist(),
        "lamps": light.lamps.tolist(),
        "suns": suns_as_extras(light.suns),
        "turn": light.turn.tolist(),
        "strength": light.strength,
        "picture": file,
    }


def _views(scene: bpy.types.Scene, files: dict[str, bytes]) -> tuple[list[dict[str, str]], int]:
    """The view transforms to choose from, and the index of the scene's own."""
    settings = scene.view_settings
    plain = settings.look == "None" and settings.gamma == 1.0
    views = [{"name": "Standard", "tip": "Blender's view transform Standard"}]
    tables = [("AgX", "Blender's view transform AgX", view_table(None, "AgX"))]
    if not plain or settings.view_transform not in {"Standard", "AgX"}:
        tables.append(
            ("Scene", f"As in Blender: {settings.view_transform}, look {settings.look}", view_table(settings))
        )
    for name, tip, table in tables:
        if table is not None:
            file = f"prt-view-{len(views)}"
            files[file] = table
            views.append({"name": name, "tip": tip, "table": file})
    return views, 0 if plain and settings.view_transform == "Standard" else len(views) - 1


def _camera(scene: bpy.types.Scene, baked: Sequence[bpy.types.Object]) -> dict[str, Any] | None:
    """Where the scene's camera stands, and what it turns about: the middle of what is baked, as far as it is ahead."""
    camera = scene.camera
    if camera is None or camera.type != "CAMERA":
        return None
    place = camera.matrix_world
    ahead = -place.col[2].to_3d().normalized()
    corners = [ob.matrix_world @ Vector(corner) for ob in baked for corner in ob.bound_box]
    centre = sum(corners, Vector()) / len(corners)
    distance = max((centre - place.translation).dot(ahead), 0.1)
    target = place.translation + distance * ahead
    frame = camera.data.view_frame(scene=scene)
    across, up = (0.5 * (max(p[k] for p in frame) - min(p[k] for p in frame)) for k in (0, 1))
    orthographic = camera.data.type == "ORTHO"
    away = distance if orthographic else -frame[0].z
    position = target - distance * ahead
    tangents = [across / away, up / away]
    right = place.col[0].to_3d().normalized()
    numbers = [*position, *target, *tangents, *right]
    return (
        {
            "position": list(position),
            "target": list(target),
            "right": list(right),
            "tangents": tangents,
            "orthographic": orthographic,
        }
        if all(map(math.isfinite, numbers)) and min(tangents) > 0.0
        else None
    )
