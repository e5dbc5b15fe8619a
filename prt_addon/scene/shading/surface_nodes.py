# SPDX-License-Identifier: GPL-3.0-or-later
"""Rebuilds the user's surface, relit: beside its shaders stand copies in which the baked light takes the place of EEVEE's.

What reflects diffusely shows the baked light and that of lamps. Gloss stays EEVEE's own, dimmed where the scene hides the
sky. Emission, transparency and glass are linked as they are. Mixes and groups of shaders are rebuilt around them; textures
and all other nodes are shared with the user's surface, and plain numbers are taken over from it (`follow_numbers`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, fields
from functools import partial
from typing import Any

import bpy

from ..blender.nodes import Wiring
from ..material.colour_nodes import add_part
from ..material.reading import PART
from .helper_groups import detail_group, diffuse_group, glossy_group, lamps_group, principled_group
from .light_nodes import DETAIL

_COPY_OF = "prt_copy_of"
"""Custom property of a part: the name of the user's node whose numbers it has."""


@dataclass(frozen=True)
class RelightSockets:
    """What "PRT Relight" hands out, where it can be linked: see `relight_group`."""

    shading: bpy.types.NodeSocket
    sky_seen: bpy.types.NodeSocket
    detail_x: bpy.types.NodeSocket
    detail_y: bpy.types.NodeSocket
    detail_z: bpy.types.NodeSocket

    @property
    def detail(self) -> dict[str, bpy.types.NodeSocket]:
        """The gradient of the light by the names of its sockets."""
        return dict(zip(DETAIL, (self.detail_x, self.detail_y, self.detail_z), strict=True))


def sockets_of(group: bpy.types.Node) -> RelightSockets:
    """The outputs of a "PRT Relight" group node."""
    return RelightSockets(*(group.outputs[name] for name in ("Shading", "Sky Seen", *DETAIL)))


def build_surface(output: bpy.types.Node, relight: RelightSockets) -> bpy.types.NodeSocket | None:
    """Add the parts that relight what a Material Output shows.

    Returns:
        The relit surface, to link; None if nothing feeds the output.
    """
    return _Builder(output.id_data, relight).shader(output.inputs["Surface"])


def follow_numbers(tree: bpy.types.NodeTree) -> None:
    """Take over the numbers and settings of the nodes that parts of a material's own tree are copies of."""
    for part in tree.nodes:
        original = tree.nodes.get(part[_COPY_OF]) if _COPY_OF in part else None
        if original:
            _take_over(part, original)


def lamps_shine() -> bool:
    """Whether there are lamps in the file: where there are none, their light takes no node, and EEVEE no time."""
    return any(light.users for light in bpy.data.lights)


def structure(output: bpy.types.Node) -> str:
    """Different for surfaces that take different nodes or links: their shaders, what feeds each of their inputs, and lamps."""
    wiring, found, pending, seen = Wiring(), [f"lamps {lamps_shine()}"], [output], set[int]()
    while pending:
        node = pending.pop()
        if node.as_pointer() in seen:
            continue
        seen.add(node.as_pointer())
        sources = [(entry.identifier, wiring.source(entry)) for entry in node.inputs]
        found.append(
            f"{node.bl_idname} {node.name} {group.name if (group := getattr(node, 'node_tree', None)) else ''}"
        )
        for name, source in sources:
            if source and (node is not output or name == "Surface"):
                found.append(f" {name} < {source.node.name}.{source.identifier}")
                if source.type == "SHADER":
                    pending.append(source.node)
    return "\n".join(found)


@dataclass
class _Builder:
    """Rebuilds the shaders of one tree: a material's, or the copy of a group's."""

    tree: bpy.types.NodeTree
    relight: RelightSockets
    inside: bool = False
    wiring: Wiring = field(default_factory=Wiring)
    _built: dict[int, bpy.types.NodeSocket | None] = field(default_factory=dict)
    _lamps: dict[int, bpy.types.NodeSocket] = field(default_factory=dict)
    _detailed: dict[int, bpy.types.NodeSocket] = field(default_factory=dict)

    def shader(self, entry: bpy.types.NodeSocket) -> bpy.types.NodeSocket | None:
        """The relit shader in place of what feeds an input; None if nothing does."""
        source = self.wiring.source(entry)
        if source is None:
            return None
        key = source.as_pointer()
        if key not in self._built:
            self._built[key] = None  # what a loop finds
            self._built[key] = self._relit(source)
        return self._built[key]

    def _relit(self, source: bpy.types.NodeSocket) -> bpy.types.NodeSocket | None:
        node = source.node
        if source.type != "SHADER":
            return source  # a colour is shown as it is
        if node.bl_idname in {"ShaderNodeMixShader", "ShaderNodeAddShader"}:
            return self._combined(node)
        if getattr(node, "node_tree", None):
            return self._group(node, source)
        build = _BSDFS.get(node.bl_idname)
        return build(self, node) if build else source

    def _combined(self, node: bpy.types.Node) -> bpy.types.NodeSocket:
        """Mix Shader and Add Shader, of relit shaders."""
        copy = self.copy(node)
        for original, entry in zip(node.inputs, copy.inputs, strict=True):
            if entry.type == "SHADER":
                self.feed(entry, self.shader(original))
        return copy.outputs[0]

    def _group(self, node: bpy.types.Node, source: bpy.types.NodeSocket) -> bpy.types.NodeSocket | None:
        """A group, by a copy of it that is given the light and hands out its relit surface."""
        copy = node.node_tree.copy()
        copy.name, copy[PART] = f"PRT {node.node_tree.name}", node.node_tree.name
        names = {item.name: f"PRT {item.name}" for item in fields(RelightSockets)}
        kinds = {"sky_seen": "NodeSocketFloat"}
        given = {
            name: copy.interface.new_socket(label, in_out="INPUT", socket_type=kinds.get(name, "NodeSocketColor"))
            for name, label in names.items()
        }
        result = copy.interface.new_socket("PRT Surface", in_out="OUTPUT", socket_type="NodeSocketShader")
        entries = add_part(copy, "NodeGroupInput").outputs
        relight = RelightSockets(**{name: _socket(entries, item.identifier) for name, item in given.items()})
        end = next((one for one in copy.nodes if one.bl_idname == "NodeGroupOutput" and one.is_active_output), None)
        inner = _socket(end.inputs, source.identifier) if end else None
        shader = _Builder(copy, relight, inside=True).shader(inner) if inner else None
        if end and shader:
            copy.links.new(shader, _socket(end.inputs, result.identifier))
            return _socket(self._placed(node, copy, given).outputs, result.identifier)
        bpy.data.node_groups.remove(copy)
        return None

    def _placed(self, node: bpy.types.Node, group: bpy.types.NodeTree, given: dict[str, Any]) -> bpy.types.Node:
        part = add_part(self.tree, "ShaderNodeGroup")
        part.node_tree = group
        self._link_like(part, node)
        for original in node.inputs:
            if original.type == "SHADER":
                self.feed(_socket(part.inputs, original.identifier), self.shader(original))
        for name, item in given.items():
            self.feed(_socket(part.inputs, item.identifier), getattr(self.relight, name))
        return part

    def copy(self, node: bpy.types.Node) -> bpy.types.Node:
        """A part of the same type, fed like a node, with its numbers and settings."""
        part = add_part(self.tree, node.bl_idname)
        self._link_like(part, node)
        return part

    def helper(self, node: bpy.types.Node, group: bpy.types.NodeTree) -> bpy.types.Node:
        """A node of a group whose inputs are called like a node's, fed like it."""
        part = add_part(self.tree, "ShaderNodeGroup")
        part.node_tree = group
        self._link_like(part, node)
        return part

    def _link_like(self, part: bpy.types.Node, node: bpy.types.Node) -> None:
        for original in node.inputs:
            entry = _like(part, original)
            source = self.wiring.source(original)
            if entry and source:
                self.feed(entry, source)
        if not self.inside:  # copies of groups are made anew when those are edited
            part[_COPY_OF] = node.name
        _take_over(part, node)

    def feed(self, entry: bpy.types.NodeSocket, source: bpy.types.NodeSocket | None) -> None:
        """Link an output to an input; nothing, if there is none."""
        if source:
            self.tree.links.new(source, entry)

    def shading(self, node: bpy.types.Node) -> bpy.types.NodeSocket:
        """The baked light at a shader's own normal: one part for all that share it."""
        normal = self._normal(node)
        if normal is None:
            return self.relight.shading
        key = normal.as_pointer()
        if key not in self._detailed:
            part = add_part(self.tree, "ShaderNodeGroup")
            part.node_tree = detail_group()
            given = {"Normal": normal, "Shading": self.relight.shading, **self.relight.detail}
            for name, source in given.items():
                self.feed(part.inputs[name], source)
            self._detailed[key] = part.outputs["Shading"]
        return self._detailed[key]

    def _normal(self, node: bpy.types.Node) -> bpy.types.NodeSocket | None:
        """What feeds a shader's Normal."""
        entry = node.inputs.get("Normal")
        return self.wiring.source(entry) if entry else None

    def lamps(self, node: bpy.types.Node) -> bpy.types.NodeSocket | None:
        """The light of lamps at a shader's own normal: one part for all that share it, as each takes EEVEE as long as a surface."""
        if not lamps_shine():
            return None
        normal = self._normal(node)
        key = normal.as_pointer() if normal else 0
        if key not in self._lamps:
            part = add_part(self.tree, "ShaderNodeGroup")
            part.node_tree = lamps_group()
            self.feed(part.inputs["Normal"], normal)
            self._lamps[key] = part.outputs["Lamps"]
        return self._lamps[key]


def _relit_by(
    group: Callable[[], bpy.types.NodeTree], keeps_gloss: bool
) -> Callable[[_Builder, bpy.types.Node], bpy.types.NodeSocket]:
    """What relights a BSDF by a helper group.

    Args:
        group: makes the helper group, or finds it.
        keeps_gloss: whether a copy of the BSDF, fed with what the helper leaves of it, is added.
    """

    def build(builder: _Builder, node: bpy.types.Node) -> bpy.types.NodeSocket:
        helper = builder.helper(node, group())
        builder.feed(helper.inputs["Shading"], builder.shading(node))
        builder.feed(helper.inputs["Sky Seen"], builder.relight.sky_seen)
        builder.feed(helper.inputs["Lamps"], builder.lamps(node))
        diffuse, *left = helper.outputs
        if not keeps_gloss:
            return diffuse
        gloss, both = builder.copy(node), add_part(builder.tree, "ShaderNodeAddShader")
        for output in left:
            builder.feed(gloss.inputs[output.name], output)
        for entry, shader in zip(both.inputs, (diffuse, gloss.outputs[0]), strict=True):
            builder.feed(entry, shader)
        return both.outputs[0]

    return build


_MATTE = ("BsdfDiffuse", "BsdfTranslucent", "BsdfSheen", "BsdfToon", "BsdfHair", "BsdfHairPrincipled")
_BSDFS = {
    **{f"ShaderNode{kind}": _relit_by(diffuse_group, False) for kind in (*_MATTE, "SubsurfaceScattering")},
    "ShaderNodeBsdfAnisotropic": _relit_by(glossy_group, True),
    "ShaderNodeBsdfMetallic": _relit_by(partial(glossy_group, "Base Color"), True),
    "ShaderNodeBsdfPrincipled": _relit_by(principled_group, True),
}
"""What relights each BSDF; others are shown as they are."""


def _socket(sockets: Any, identifier: str) -> bpy.types.NodeSocket | None:
    return next((socket for socket in sockets if socket.identifier == identifier), None)


def _like(part: bpy.types.Node, original: bpy.types.NodeSocket) -> bpy.types.NodeSocket | None:
    """The input of a part that stands for one of its original's."""
    return _socket(part.inputs, original.identifier) or part.inputs.get(original.name)


_EVERY_NODE_HAS = set(bpy.types.ShaderNode.bl_rna.properties.keys())


def _take_over(part: bpy.types.Node, original: bpy.types.Node) -> None:
    """The numbers of inputs that nothing feeds, and, if it is of the same type, the settings. What is alike is not written."""
    for source in original.inputs:
        entry = _like(part, source)
        if entry and not entry.is_linked and hasattr(entry, "default_value") and entry.type == source.type:
            write(entry, "default_value", source.default_value)
    if part.bl_idname == original.bl_idname and part.bl_idname != "ShaderNodeGroup":
        for setting in original.bl_rna.properties:
            if setting.identifier not in _EVERY_NODE_HAS and not setting.is_readonly and setting.type != "POINTER":
                write(part, setting.identifier, getattr(original, setting.identifier))


def write(owner: Any, name: str, value: Any) -> None:
    """Set a property, unless it has the value already: Blender would take it for an edit."""
    now = getattr(owner, name)
    if (tuple(now) != tuple(value)) if hasattr(value, "__len__") and not isinstance(value, str) else now != value:
        setattr(owner, name, value)
