# SPDX-License-Identifier: GPL-3.0-or-later
"""Rebuilds the user's surface, relit: beside its shaders stand copies in which the baked light takes the place of EEVEE's.

What reflects diffusely shows the baked light and that of lamps. Gloss stays EEVEE's own, dimmed where the scene hides the
sky. Emission, transparency and glass are linked as they are, and so is what is not known: `material.shaders` says which is which.
Mixes and groups of shaders are rebuilt around them; textures and all other nodes are shared with the user's surface, and plain
numbers are taken over from it (`follow_numbers`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, fields
from functools import partial
from typing import Any

import bpy

from ..blender.nodes import Wiring
from ..material.colour_nodes import add_part
from ..material.reading import DEEPEST, PART
from ..material.shaders import COMBINING, SHADERS, Shader, colour_input
from .gloss_groups import conductor_group, specular_group
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


@dataclass
class Built:
    """What became of a surface.

    relit: how many of its shaders show the baked light.
    unknown: what is shown as it is, though light may belong in, each to stand in a sentence.
    """

    relit: int = 0
    unknown: dict[str, None] = field(default_factory=dict)


def build_surface(output: bpy.types.Node, relight: RelightSockets) -> tuple[bpy.types.NodeSocket | None, Built]:
    """Add the parts that relight what a Material Output shows.

    Returns:
        The relit surface, to link, None if nothing feeds the output; and what became of it.
    """
    builder = _Builder(output.id_data, relight)
    return builder.shader(output.inputs["Surface"]), builder.built


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
    """Different for surfaces that take different nodes or links: their shaders, what feeds each of their inputs and the output's, and
    lamps.
    """
    wiring, found, pending, seen = Wiring(), [f"lamps {lamps_shine()}"], [output], set[int]()
    while pending:
        node = pending.pop()
        if node.as_pointer() in seen:
            continue
        seen.add(node.as_pointer())
        sources = [(entry.identifier, wiring.source(entry)) for entry in node.inputs]
        of_group = group.name if (group := getattr(node, "node_tree", None)) else ""
        found.append(f"{node.bl_idname} {node.name} {of_group} {'coloured' if colour_input(node) else ''}")
        for name, source in sources:
            if source:
                found.append(f" {name} < {source.node.name}.{source.identifier}")
                if source.type == "SHADER" and (node is not output or name == "Surface"):
                    pending.append(source.node)
    return "\n".join(found)


@dataclass
class _Builder:
    """Rebuilds the shaders of one tree: a material's, or the copy of a group's."""

    tree: bpy.types.NodeTree
    relight: RelightSockets
    inside: bool = False
    built: Built = field(default_factory=Built)
    depth: int = 0
    wiring: Wiring = field(default_factory=Wiring)
    _shaders: dict[int, bpy.types.NodeSocket | None] = field(default_factory=dict)
    _lamps: dict[int, bpy.types.NodeSocket] = field(default_factory=dict)
    _detailed: dict[int, bpy.types.NodeSocket] = field(default_factory=dict)

    def shader(self, entry: bpy.types.NodeSocket) -> bpy.types.NodeSocket | None:
        """The relit shader in place of what feeds an input; None if nothing does."""
        source = self.wiring.source(entry)
        if source is None:
            return None
        key = source.as_pointer()
        if key not in self._shaders:
            self._shaders[key] = None  # what a loop finds
            self.depth += 1
            self._shaders[key] = self._relit(source)
            self.depth -= 1
        return self._shaders[key]

    def _relit(self, source: bpy.types.NodeSocket) -> bpy.types.NodeSocket | None:
        node = source.node
        if source.type != "SHADER" or node.bl_idname == "NodeGroupInput":
            return source  # a colour is light, and shown as it is; what a group is given is relit outside
        if self.depth > DEEPEST + 1:
            return self._unknown(source, f"what is mixed more than {DEEPEST} deep")
        if node.bl_idname in COMBINING:
            return self._combined(node)
        if getattr(node, "node_tree", None):
            return self._group(node, source)
        shader = SHADERS.get(node.bl_idname)
        if shader is None:
            return self._unknown(source, f"'{node.label or node.name}'")
        build = _build(node, shader)
        self.built.relit += build is not None
        return build(self, node) if build else source

    def _unknown(self, source: bpy.types.NodeSocket, what: str) -> bpy.types.NodeSocket:
        """A shader as it is."""
        self.built.unknown[what] = None
        return source

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
        shader = _Builder(copy, relight, True, self.built, self.depth).shader(inner) if inner else None
        if end and shader:
            copy.links.new(shader, _socket(end.inputs, result.identifier))
            return _socket(self._placed(node, copy, given).outputs, result.identifier)
        bpy.data.node_groups.remove(copy)
        return None if inner else self._unknown(source, f"'{node.label or node.name}'")

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


_Build = Callable[[_Builder, bpy.types.Node], bpy.types.NodeSocket]


def _build(node: bpy.types.Node, shader: Shader) -> _Build | None:
    """What relights a shader; None if it is shown as it is."""
    coloured = partial(_with_gloss, group=partial(glossy_group, shader.colour))
    builds: dict[str, _Build] = {
        "MATTE": partial(_matte, group=diffuse_group),
        "GLOSSY": coloured if colour_input(node) else partial(_with_gloss, group=conductor_group, dims=True),
        "PRINCIPLED": partial(_with_gloss, group=principled_group),
        "SPECULAR": partial(_with_gloss, group=specular_group, dims=True),
    }
    return builds.get(shader.relit)


_Group = Callable[[], bpy.types.NodeTree]


def _lit(builder: _Builder, node: bpy.types.Node, group: _Group) -> bpy.types.Node:
    """A helper group fed like a BSDF, and with the light."""
    helper = builder.helper(node, group())
    builder.feed(helper.inputs["Shading"], builder.shading(node))
    builder.feed(helper.inputs["Sky Seen"], builder.relight.sky_seen)
    builder.feed(helper.inputs["Lamps"], builder.lamps(node))
    return helper


def _matte(builder: _Builder, node: bpy.types.Node, group: _Group) -> bpy.types.NodeSocket:
    """A BSDF by its helper group alone."""
    return _lit(builder, node, group).outputs[0]


def _with_gloss(builder: _Builder, node: bpy.types.Node, group: _Group, dims: bool = False) -> bpy.types.NodeSocket:
    """A BSDF by its helper group, and a copy of it that is fed with what the group leaves of it.

    Args:
        builder: of the tree.
        node: the BSDF.
        group: makes the helper group, or finds it.
        dims: whether the copy is dimmed to the share of sky that is seen: nothing that is left of the BSDF says it.
    """
    diffuse, *left = _lit(builder, node, group).outputs
    gloss, both = builder.copy(node), add_part(builder.tree, "ShaderNodeAddShader")
    for output in left:
        builder.feed(gloss.inputs[output.name], output)
    shown = gloss.outputs[0]
    if dims:
        mix = add_part(builder.tree, "ShaderNodeMixShader")
        builder.feed(mix.inputs[0], builder.relight.sky_seen)
        builder.feed(mix.inputs[2], shown)
        shown = mix.outputs[0]
    for entry, shader in zip(both.inputs, (diffuse, shown), strict=True):
        builder.feed(entry, shader)
    return both.outputs[0]


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
