# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads a material once: whether its surface can be relit, the colour that light takes on where it bounces off, and the share
of the light that it lets through.

Both are read from the inputs of shaders, mixed as the material mixes the shaders, through groups, reroutes and whatever is
muted.

Transport is diffuse. A metal bounces its base colour as if it were matte, gloss and glass likewise. A Transparent BSDF takes no
part in the colour: what is mixed with it counts as whole. Light that materials emit is no colour: black. Glass lets light
through straight on, as thin panes do, where Cycles bends it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

import bpy

from ..blender.nodes import Wiring, uses_nodes

RenderEngine = Literal["EEVEE", "CYCLES"]
RGB = tuple[float, float, float]


@dataclass(frozen=True)
class Constant:
    """A colour, or a number three times."""

    rgb: RGB


@dataclass(frozen=True)
class Source:
    """The output of a node that gives a value, in the material's own tree, or in that of the group that an `Inside` names."""

    socket: bpy.types.NodeSocket


@dataclass(frozen=True)
class Inside:
    """A value inside a node group."""

    group: bpy.types.Node
    colour: Colour


@dataclass(frozen=True)
class Mixed:
    """A mix: `first` where the factor is 0, `second` where it is 1."""

    factor: Colour
    first: Colour
    second: Colour


@dataclass(frozen=True)
class Sum:
    """A sum of two values."""

    first: Colour
    second: Colour


Colour = Constant | Source | Inside | Mixed | Sum

BLACK = Constant((0.0, 0.0, 0.0))
_WHITE = Constant((1.0, 1.0, 1.0))

_MOST_SHADERS = 32
"""Of a material whose colour is mixed in nodes."""

_DEEPEST = 100
"""Steps from the output to a shader."""

_GLASS = {"ShaderNodeBsdfGlass", "ShaderNodeBsdfRefraction"}

_COLOURLESS = {"ShaderNodeEmission", "ShaderNodeHoldout", "ShaderNodeBackground"}
"""Shaders that are opaque and reflect nothing."""


@dataclass(frozen=True)
class MaterialReading:
    """How a material looks to one engine.

    output: the user's own Material Output for it; None if there is none, or the material has no nodes.
    colour: of the surface; None if nothing reflects light, or what does cannot be read.
    why_not: why it cannot be read, to stand after the name of the material and a colon; empty if it can.
    through: which share of the light it lets through: by alpha, a Transparent BSDF or glass; none if it cannot be read.
    emits: whether it emits light, as far as it was read.
    """

    output: bpy.types.Node | None
    colour: Colour | None
    why_not: str = ""
    through: Colour = BLACK
    emits: bool = False


PART = "prt_part"
"""Custom property of nodes that we add beside those; of copies of groups, the name of the group."""

OURS = "prt_were_active"
"""Custom property of the output that we add: the names of the outputs that were active before it, a line each."""


def read_material(material: bpy.types.Material, engine: RenderEngine) -> MaterialReading:
    """Read a material as an engine shows it, or would without us."""
    if not uses_nodes(material):
        return MaterialReading(None, Constant(_three(material.diffuse_color)))
    output = user_output(material.node_tree, engine)
    if output is None:
        return MaterialReading(None, None)
    reader = _Reader()
    try:
        surface, why_not = reader.surface(output.inputs["Surface"]), ""
    except _NotRead as reason:
        surface, why_not = _Seen(None, BLACK), str(reason)
    return MaterialReading(output, surface.colour, why_not, surface.through, reader.emits)


def has_surface(material: bpy.types.Material) -> bool:
    """Whether light stops at a material's faces: not if it is a volume and nothing else."""
    output = user_output(material.node_tree, "CYCLES") if uses_nodes(material) and material.node_tree else None
    if output is None:
        return True
    wiring = Wiring()
    surface, volume = (wiring.source(output.inputs[name]) for name in ("Surface", "Volume"))
    return surface is not None or volume is None


def user_output(tree: bpy.types.NodeTree, engine: RenderEngine) -> bpy.types.Node | None:
    """The user's own output that an engine shows: as `get_output_node`, which would find ours.

    One that is made for the engine comes before one for all, and among equals the active one.
    """
    outputs = [node for node in tree.nodes if node.bl_idname == "ShaderNodeOutputMaterial" and PART not in node]
    ours = next((node for node in outputs if OURS in node), None)
    were_active = ours[OURS].split("\n") if ours else [node.name for node in outputs if node.is_active_output]
    theirs = [node for node in outputs if node != ours and node.target in {engine, "ALL"}]
    return max(theirs, key=lambda node: (node.target == engine, node.name in were_active), default=None)


class _NotRead(Exception):
    """Something that only Blender can evaluate; the message says what."""


@dataclass(frozen=True)
class _Seen:
    """What is seen of a shader: its colour, None if it has none of its own; and which share of the light it lets through."""

    colour: Colour | None
    through: Colour = BLACK


_DARK = _Seen(BLACK)
_Path = tuple[bpy.types.Node, ...]


@dataclass
class _Reader:
    """Reads shaders. A path is the group nodes that one has gone into, outermost first."""

    wiring: Wiring = field(default_factory=Wiring)
    shaders: int = 0
    emits: bool = False
    _open: set[tuple[int, ...]] = field(default_factory=set)

    def surface(self, entry: bpy.types.NodeSocket) -> _Seen:
        """The shader that feeds an input; without a colour if nothing behind it reflects light."""
        seen = self._shader(entry, ())
        return seen if self.shaders else _Seen(None, seen.through)

    def _shader(self, entry: bpy.types.NodeSocket, path: _Path, hidden: bool = False) -> _Seen:
        """The shader that feeds an input. What is hidden, as a mix takes nothing of it, does not emit."""
        emitted = self.emits
        seen = self._behind(entry, path)
        if hidden:
            self.emits = emitted
        return seen

    def _behind(self, entry: bpy.types.NodeSocket, path: _Path) -> _Seen:
        source = self.wiring.source(entry)
        if source is None:
            return _DARK
        node = source.node
        here = (*(group.as_pointer() for group in path), node.as_pointer())
        if here in self._open:
            return _DARK  # a loop shows nothing
        if len(self._open) > _DEEPEST:
            raise _NotRead(f"its shaders are mixed more than {_DEEPEST} deep")
        self._open.add(here)
        try:
            return self._shader_of(node, source, path)
        finally:
            self._open.discard(here)

    def _shader_of(self, node: bpy.types.Node, source: bpy.types.NodeSocket, path: _Path) -> _Seen:
        kind = node.bl_idname
        self.emits |= self._glows(node)
        if kind == "ShaderNodeMixShader":
            factor = self._value(node.inputs[0], path)
            first = self._shader(node.inputs[1], path, hidden=_is_all_of(factor, 1.0))
            second = self._shader(node.inputs[2], path, hidden=_is_all_of(factor, 0.0))
            return _Seen(
                _mixed(factor, first.colour, second.colour), _value_between(factor, first.through, second.through)
            )
        if kind == "ShaderNodeAddShader":
            first, second = (self._shader(entry, path) for entry in node.inputs)
            return _Seen(_sum(first.colour, second.colour), _value_sum(first.through, second.through))
        if kind == "ShaderNodeBsdfTransparent":
            return _Seen(None, self._value(node.inputs["Color"], path))
        if kind in _COLOURLESS:
            return _DARK
        if kind == "NodeGroupInput":
            return self._shader(_outside(path, source), path[:-1]) if path else _DARK
        if inner := _group_result(node, source):
            return self._shader(inner, (*path, node))
        entry = node.inputs.get("Base Color") or node.inputs.get("Color")
        if entry is None or source.type != "SHADER":
            raise _NotRead(f"'{node.label or node.name}' is a shader whose colour is not read")
        self.shaders += 1
        if self.shaders > _MOST_SHADERS:
            raise _NotRead(f"it is made of more than {_MOST_SHADERS} shaders")
        colour = self._value(entry, path)
        return _Seen(colour, self._through(node, colour, path))

    def _through(self, node: bpy.types.Node, colour: Colour, path: _Path) -> Colour:
        """Which share of the light a BSDF of some colour lets through."""
        if node.bl_idname in _GLASS:
            return colour
        if node.bl_idname != "ShaderNodeBsdfPrincipled":
            return BLACK
        alpha, glass, metal = (
            self._value(node.inputs[name], path) for name in ("Alpha", "Transmission Weight", "Metallic")
        )
        through = _value_between(metal, _value_between(glass, BLACK, _tint(colour)), BLACK)
        return _value_between(alpha, _WHITE, through)

    def _glows(self, node: bpy.types.Node) -> bool:
        """Whether a shader emits light: its strength and colour are fed, or not 0."""
        if node.bl_idname not in {"ShaderNodeEmission", "ShaderNodeBsdfPrincipled"}:
            return False
        of_principled = "Emission " if node.bl_idname == "ShaderNodeBsdfPrincipled" else ""
        entries = (node.inputs[f"{of_principled}{name}"] for name in ("Strength", "Color"))
        return all(self.wiring.source(entry) or any(_rgb(entry)) for entry in entries)

    def _value(self, entry: bpy.types.NodeSocket, path: _Path) -> Colour:
        """What an input gets."""
        source = self.wiring.source(entry)
        if source is None:
            return Constant(_rgb(entry))
        if source.node.bl_idname == "NodeGroupInput":
            return self._value(_outside(path, source), path[:-1]) if path else Constant(_rgb(entry))
        colour: Colour = Source(source)
        for group in reversed(path):
            colour = Inside(group, colour)
        return colour


def _outside(path: _Path, source: bpy.types.NodeSocket) -> bpy.types.NodeSocket:
    """The input of the group node that one is in, which an output of its Group Input stands for."""
    return next(entry for entry in path[-1].inputs if entry.identifier == source.identifier)


def _group_result(node: bpy.types.Node, source: bpy.types.NodeSocket) -> bpy.types.NodeSocket | None:
    """The input of a group's own output that an output of the group node stands for; None if it is no group."""
    tree = getattr(node, "node_tree", None)
    if tree is None:
        return None
    outputs = (inner for inner in tree.nodes if inner.bl_idname == "NodeGroupOutput" and inner.is_active_output)
    output = next(outputs, None)
    return next((entry for entry in output.inputs if entry.identifier == source.identifier), None) if output else None


def _rgb(entry: bpy.types.NodeSocket) -> RGB:
    """The constant of an input, a number three times."""
    value = getattr(entry, "default_value", 0.0)
    return (float(value),) * 3 if isinstance(value, (int, float)) else _three(value)


def _three(colour: Sequence[float]) -> RGB:
    return float(colour[0]), float(colour[1]), float(colour[2])


def _is_all_of(factor: Colour, value: float) -> bool:
    """Whether a mix's factor, from 0 to 1, is this end of its range or beyond."""
    return isinstance(factor, Constant) and min(max(factor.rgb[0], 0.0), 1.0) == value


def _tint(colour: Colour) -> Colour:
    """What the glass of a Principled BSDF makes of light at one of its two faces: the root of its colour, as far as that is a number."""
    if not isinstance(colour, Constant):
        return _WHITE
    r, g, b = (max(channel, 0.0) ** 0.5 for channel in colour.rgb)
    return Constant((r, g, b))


def _mixed(factor: Colour, first: Colour | None, second: Colour | None) -> Colour | None:
    """What is transparent takes no part in a mix."""
    if first is None or second is None:
        return first or second
    return _value_between(factor, first, second)


def _value_between(factor: Colour, first: Colour, second: Colour) -> Colour:
    """`first` where a factor is 0, `second` where it is 1."""
    if first == second:
        return first
    if not isinstance(factor, Constant):
        return Mixed(factor, first, second)
    share = min(max(factor.rgb[0], 0.0), 1.0)
    if share in {0.0, 1.0}:
        return second if share else first
    if isinstance(first, Constant) and isinstance(second, Constant):
        r, g, b = ((1.0 - share) * a + share * b for a, b in zip(first.rgb, second.rgb, strict=True))
        return Constant((r, g, b))
    return Mixed(Constant((share,) * 3), first, second)


def _sum(first: Colour | None, second: Colour | None) -> Colour | None:
    if first is None or second is None:
        return first or second
    return _value_sum(first, second)


def _value_sum(first: Colour, second: Colour) -> Colour:
    if isinstance(first, Constant) and isinstance(second, Constant):
        r, g, b = (a + b for a, b in zip(first.rgb, second.rgb, strict=True))
        return Constant((r, g, b))
    if BLACK in (first, second):
        return second if first == BLACK else first
    return Sum(first, second)
