# SPDX-License-Identifier: GPL-3.0-or-later
"""Decides whether a sky is still the one that was projected: digests its nodes and pictures, without what drivers
follow.

A node is what it is set to and what feeds it, not its name or its place. The Mapping node that turns everything is looked
through, so that it makes no difference whether there is one.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import bpy

from ...core.files import digest
from ..blender.nodes import Wiring
from ..blender.rna import plain, settings_of
from .sky import Sky, is_view, looks_along

_NOT_OF_A_KIND = {*bpy.types.Node.bl_rna.properties.keys(), "node_tree"}
"""What all nodes have: name, place, sockets."""

_FOLLOWED = _NOT_OF_A_KIND | {"sun_rotation", "sun_direction"}
"""Of a Sky Texture whose Sun Rotation is followed."""

_END = 1 << 16  # bytes of each end of a file

_HOLDS_NUMBERS = {"ShaderNodeValue", "ShaderNodeRGB", "ShaderNodeNormal"}
"""Nodes whose output's default is what they give."""


@dataclass(frozen=True)
class SkyIdentity:
    """Digests, as hexadecimal numbers.

    pictures: which they are, and the state of their files.
    graph: nodes, their settings, numbers and links; and the frame, where a picture is a movie.
    """

    pictures: str
    graph: str


def sky_identity(sky: Sky) -> SkyIdentity:
    """What is seen of a sky, apart from its turn and strength if these are followed."""
    nodes = sky.nodes
    images = list(dict.fromkeys(node.image for node in nodes if getattr(node, "image", None)))
    pictures = "\n".join(sorted(map(_picture, images)))
    return SkyIdentity(_hex(pictures), _hex("\n".join(_graph(sky, nodes, images))))


def _hex(text: str) -> str:
    return digest(text.encode()).hex()


def _picture(image: bpy.types.Image) -> str:
    """An image's identity: its name, source and colour space, and the size and both ends of its file.

    Not its date: the same file has another on another machine, where the light would be called stale.
    """
    known = [image.name, image.source, image.filepath, image.colorspace_settings.name, image.alpha_mode]
    if image.packed_file:
        return repr([*known, image.packed_file.size])
    if image.source != "FILE":
        return repr(known)
    path = Path(bpy.path.abspath(image.filepath, library=image.library))
    state = path.stat() if path.is_file() else None
    return repr([*known, state and (state.st_size, _ends(path, state.st_size, state.st_mtime_ns))])


@lru_cache(maxsize=64)
def _ends(path: Path, size: int, _changed: int) -> str:
    """Digest of the first and the last bytes of a file. Looked at again when its date is another."""
    with path.open("rb") as file:
        first = file.read(_END)
        file.seek(max(size - _END, 0))
        return digest(first, file.read(_END)).hex()


def _graph(sky: Sky, seen: list[bpy.types.Node], images: list[bpy.types.Image]) -> Iterator[str]:
    """Lines about the nodes of a sky, and about the frame if it matters."""
    if not seen:
        yield repr(tuple(sky.world.color))
    wiring = Wiring()
    nodes = [node for node in seen if node != sky.mapping and not _only_view(node, wiring)]
    numbers = {node.as_pointer(): number for number, node in enumerate(nodes)}
    for node in nodes:
        yield repr(
            [
                node.bl_idname,
                node.mute,
                dict(settings_of(node, _FOLLOWED if node == sky.sun else _NOT_OF_A_KIND)),
                list(_values(sky, node, numbers, wiring)),
            ]
        )
    if any(image.source in {"MOVIE", "SEQUENCE"} for image in images):
        yield str(bpy.context.scene.frame_current)


def _only_view(node: bpy.types.Node, wiring: Wiring) -> bool:
    """Whether a node gives nothing but the direction of view."""
    return is_view(node.outputs.get("Generated")) and all(
        is_view(output) for output in node.outputs if wiring.fed_by(output)
    )


def _values(sky: Sky, node: bpy.types.Node, numbers: dict[int, int], wiring: Wiring) -> Iterator[Any]:
    """What each input of a node is: which output, the view, or a number."""
    for entry in node.inputs:
        source = wiring.source(entry)
        if (source and (source.node == sky.mapping or is_view(source))) or (not source and looks_along(entry)):
            yield "view"
        elif source:
            yield numbers[source.node.as_pointer()], source.identifier
        elif entry != sky.strength:
            yield plain(getattr(entry, "default_value", None))
    if node.bl_idname in _HOLDS_NUMBERS and node.outputs[0] != sky.strength:
        yield plain(node.outputs[0].default_value)
