# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads six picture files as a cube map, and makes the Blender world that shows the same sky."""

from __future__ import annotations

from pathlib import Path

import bpy

from ...core.errors import PictureError
from ...core.sky.cube_layout import face_of, faces_in
from ...core.sky.cube_map import FACES, Picture, Table, decode
from ..blender.images import float_image, linear_pixels, to_scene_linear
from ..blender.nodes import turn_nodes

_FLOAT, _ENCODED = (".exr", ".hdr"), (".png", ".tif", ".tiff", ".tga", ".bmp", ".webp", ".jpg", ".jpeg")


def read_faces(source: Path, table: Table) -> dict[str, Picture]:
    """Read a cube map: six pictures in a folder, by any of the usual names (`core.sky.cube_layout`), or one picture that
    holds all faces as a cross or a strip. Of several sets in a folder, the one of the richest type.

    Returns:
        By name, (height, width, 3) float32 linear radiance, top row first. .exr and .hdr are linear already; .png, .jpg
        and the like are decoded as `core.sky.cube_map.decode` does for the table.

    Raises:
        PictureError: if a face is missing or cannot be read, or the one picture is no cube map.
        OSError: if the folder cannot be read.
    """
    if source.is_file():
        return faces_in(_read_face(source, table))
    return {name: _read_face(path, table) for name, path in _face_files(source).items()}


def set_up_world(scene: bpy.types.Scene, name: str, picture: Picture) -> bpy.types.World:
    """Light a scene by an equirectangular picture (height, width, 3), row 0 at the bottom, in a world of its own.

    The picture is packed into the file. The world before stays in the file, whoever else uses it.
    """
    world = bpy.data.worlds.new(name)
    turn_nodes(world, True)
    tree = world.node_tree
    tree.nodes.clear()
    kinds = ("TexCoord", "Mapping", "TexEnvironment", "Background", "OutputWorld")
    nodes = [tree.nodes.new(f"ShaderNode{kind}") for kind in kinds]
    for column, node in enumerate(nodes):
        node.location = (240.0 * column, 300.0)
    coordinate, mapping, texture, background, output = nodes
    texture.image = float_image(name, picture)
    texture.image.pack()
    tree.links.new(coordinate.outputs["Generated"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs["Vector"], texture.inputs["Vector"])
    tree.links.new(texture.outputs["Color"], background.inputs["Color"])
    tree.links.new(background.outputs["Background"], output.inputs["Surface"])
    before, scene.world = scene.world, world
    if before and not before.users:
        before.use_fake_user = True
    return world


def _face_files(directory: Path) -> dict[str, Path]:
    endings = (*_FLOAT, *_ENCODED)
    sets: dict[tuple[int, str], dict[str, Path]] = {}
    for path in sorted(directory.iterdir()):
        suffix = path.suffix.lower()
        found = face_of(path.stem) if suffix in endings else None
        if found:
            face, rest = found
            sets.setdefault((endings.index(suffix), rest), {}).setdefault(face, path)
    fullest = max((sets[key] for key in sorted(sets)), key=len, default={})  # the first of them
    if missing := [name for name in FACES if name not in fullest]:
        raise PictureError(
            f"Folder '{directory}' lacks {', '.join(missing)}: a cube map is six pictures {', '.join(FACES)} (or px ... nz, "
            "right, left, top, bottom, front, back), all of one type, or one picture that is a cross or a strip."
        )
    return {name: fullest[name] for name in FACES}


def _read_face(path: Path, table: Table) -> Picture:
    """One file, by way of an image that does not stay."""
    try:
        image = bpy.data.images.load(str(path), check_existing=False)
    except RuntimeError as error:
        raise PictureError(f"'{path}' cannot be read: check that it is a picture that may be opened.") from error
    try:
        image.alpha_mode = "CHANNEL_PACKED"  # colours as they are in the file
        encoded = path.suffix.lower() in _ENCODED
        if encoded:
            image.colorspace_settings.is_data = True  # 16-bit pictures would be decoded by Blender
        pixels = linear_pixels(image)[::-1]
        return to_scene_linear(decode(pixels, table)) if encoded else pixels
    finally:
        bpy.data.images.remove(image)
