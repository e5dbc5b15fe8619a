# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads a material once: whether its surface can be relit, the colour that light takes on where it bounces off, and the share
of the light that it lets through.

Both are read from the inputs of shaders, mixed as the material mixes the shaders, through groups, reroutes and whatever is
muted.

Transport is diffuse. A metal bounces its base colour as if it were matte, gloss and glass likewise. A Transparent BSDF takes no
part in the colour: what is mixed with it counts as whole. Light that materials emit is no colour: black. So is a colour in a
shader's place, which Blender shows as light. Glass lets light through straight on, as thin panes do, where Cycles bends it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

import bpy

from ..blender.nodes import Wiring, uses_nodes
from .shaders import COMBINING, SHADER_TO_RGB, SHADERS, Shader, colour_input

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

_MOST_ENDS = 1024
"""Ways from the output to shaders that reflect or not: one that is added to itself again and again doubles them each time."""

DEEPEST = 100
"""Steps from the output to a shader."""


@dataclass(frozen=True)
class MaterialReading:
    """How a material looks to one engine.

    output: the user's own Material Output for it; None if there is none, or the material has no nodes.
    colour: of the surface; None if nothing reflects light, or what does cannot be read.
    why_not: why it cannot be read, to stand after the name of the material and a colon; empty if it can.
    through: which share of the light it lets through: by alpha, a Transparent BSDF or glass; none if it cannot be read.
    emits: whether it emits light, as far as it was read.
    eevees_light: whether colours of it are EEVEE's own light (Shader to RGB), as far as it was read.
    """

    output: bpy.types.Node | None
    colour: Colour | None
    why_not: str = ""
    through: Colour = BLACK
    emits: bool = False
    eevees_light: bool = False


PART = "prt_part"
"""Custom property of nodes that we add beside those; of copies of groups, the name of the group."""

OURS = "prt_were_active"
"""Custom property of the output that we add. Versions before 0.2 kept there the names of the outputs that were active before it, a line each."""

WAS_ACTIVE = "prt_was_active"
"""Custom property of the user's output that was active, where one of ours is active in its place."""


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
    return MaterialReading(output, surface.colour, why_not, surface.through, reader.emits, reader.eevees_light)


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
    theirs = [node for node in user_outputs(tree) if node.target in {engine, "ALL"}]
    active = active_output(tree)
    return max(theirs, key=lambda node: (node.target == engine, node == active), default=None)


def user_outputs(tree: bpy.types.NodeTree) -> list[bpy.types.Node]:
    """The user's own Material Outputs, for whatever engine."""
    outputs = (node for node in tree.nodes if node.bl_idname == "ShaderNodeOutputMaterial")
    return [node for node in outputs if PART not in node and OURS not in node]


def active_output(tree: bpy.types.NodeTree) -> bpy.types.Node | None:
    """The user's own output that is active; if one of ours is, the one that was before it."""
    outputs = user_outputs(tree)
    active = next((node for node in outputs if node.is_active_output), None)
    marked = next((node for node in outputs if WAS_ACTIVE in node), None)
    ours = next((node for node in tree.nodes if OURS in node), None)
    names = ours[OURS].split("\n") if ours else []
    return active or marked or next((node for node in outputs if node.name in names), None)


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
    ends: int = 0
    emits: bool = False
    eevees_light: bool = False
    _open: set[tuple[int, ...]] = field(default_factory=set)

    def surface(self, entry: bpy.types.NodeSocket) -> _Seen:
        """The shader that feeds an input; without a colour if nothing behind it reflects light."""
        seen = self._shader(entry, ())
        return seen if self.shaders else _Seen(None, seen.through)

    def _shader(self, entry: bpy.types.NodeSocket, path: _Path, hidden: bool = False) -> _Seen:
        """The shader that feeds an input. What is hidden, as a mix takes nothing of it, does not emit."""
        before = self.emits, self.eevees_light
        seen = self._behind(entry, path)
        if hidden:
            self.emits, self.eevees_light = before
        return seen

    def _behind(self, entry: bpy.types.NodeSocket, path: _Path) -> _Seen:
        source = self.wiring.source(entry)
        if source is None:
            return _DARK
        node = source.node
        here = (*(group.as_pointer() for group in path), node.as_pointer())
        if here in self._open:
            return _DARK  # a loop shows nothing
        if len(self._open) > DEEPEST:
            raise _NotRead(f"its shaders are mixed more than {DEEPEST} deep")
        self._open.add(here)
        try:
            return self._shader_of(source, path) if source.type == "SHADER" else self._shown_colour(entry, path)
        finally:
            self._open.discard(here)

    def _shader_of(self, source: bpy.types.NodeSocket, path: _Path) -> _Seen:
        node = source.node
        if node.bl_idname in COMBINING:
            return self._combined(node, path)
        if node.bl_idname == "NodeGroupInput":
            return self._shader(_outside(path, source), path[:-1]) if path else _DARK
        if inner := _group_result(node, source):
            return self._shader(inner, (*path, node))
        self._count_end()
        shader = SHADERS.get(node.bl_idname)
        if shader is None:
            raise _NotRead(f"'{node.label or node.name}' is a shader whose colour is not read")
        self.emits |= bool(shader.glow) and self._glows([node.inputs[name] for name in shader.glow], path)
        if not shader.colour:
            return _DARK
        entry = colour_input(node)
        if entry is None:
            raise _NotRead(f"'{node.label or node.name}' has its colour of other inputs")
        colour = self._value(entry, path)
        if shader.through == "COLOUR":
            return _Seen(None, colour)
        self.shaders += 1
        if self.shaders > _MOST_SHADERS:
            raise _NotRead(f"it is made of more than {_MOST_SHADERS} shaders")
        return _Seen(colour, self._through(node, shader, colour, path))

    def _combined(self, node: bpy.types.Node, path: _Path) -> _Seen:
        """What is seen of a Mix Shader or an Add Shader."""
        if node.bl_idname == "ShaderNodeAddShader":
            first, second = (self._shader(entry, path) for entry in node.inputs)
            return _Seen(_sum(first.colour, second.colour), _value_sum(first.through, second.through))
        factor = self._value(node.inputs[0], path)
        first = self._shader(node.inputs[1], path, hidden=_is_all_of(factor, 1.0))
        second = self._shader(node.inputs[2], path, hidden=_is_all_of(factor, 0.0))
        through = _value_between(factor, first.through, second.through)
        return _Seen(_mixed(factor, first.colour, second.colour), through)

    def _shown_colour(self, entry: bpy.types.NodeSocket, path: _Path) -> _Seen:
        """What is seen of a colour in a shader's place: Blender shows it as light that is emitted."""
        self._count_end()
        self.emits |= self._glows([entry], path)
        return _DARK

    def _count_end(self) -> None:
        self.ends += 1
        if self.ends > _MOST_ENDS:
            raise _NotRead(f"it is made of more than {_MOST_SHADERS} shaders")

    def _through(self, node: bpy.types.Node, shader: Shader, colour: Colour, path: _Path) -> Colour:
        """Which share of the light a shader of some colour lets through."""
        if shader.through == "GLASS":
            return colour
        if shader.through == "TRANSPARENCY":
            return _value_between(self._value(node.inputs["Transparency"], path), BLACK, _WHITE)
        if shader.through != "PRINCIPLED":
            return BLACK
        alpha, glass, metal = (
            self._value(node.inputs[name], path) for name in ("Alpha", "Transmission Weight", "Metallic")
        )
        through = _value_between(metal, _value_between(glass, BLACK, _tint(colour)), BLACK)
        return _value_between(alpha, _WHITE, through)

    def _glows(self, entries: list[bpy.types.NodeSocket], path: _Path) -> bool:
        """Whether what emits by the product of some inputs does: none of them is black, or EEVEE's own light."""
        before, self.eevees_light = self.eevees_light, False
        black = BLACK in [self._value(entry, path) for entry in entries]
        glows = not black and not self.eevees_light
        self.eevees_light = before or (self.eevees_light and not black)
        return glows

    def _is_eevees_light(self, node: bpy.types.Node, path: _Path) -> bool:
        """Whether a Shader to RGB is among the nodes that a value depends on, inside and outside of groups, too."""
        for one in self.wiring.upstream(node):
            if one.bl_idname == "NodeGroupInput" and path and self._is_eevees_light(path[-1], path[:-1]):
                return True
            if _holds(one, SHADER_TO_RGB):
                return True
        return False

    def _value(self, entry: bpy.types.NodeSocket, path: _Path) -> Colour:
        """What an input gets."""
        source = self.wiring.source(entry)
        if source is None:
            return Constant(_rgb(entry))
        if source.node.bl_idname == "NodeGroupInput":
            return self._value(_outside(path, source), path[:-1]) if path else Constant(_rgb(entry))
        self.eevees_light |= self._is_eevees_light(source.node, path)
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


def _holds(node: bpy.types.Node, kind: str) -> bool:
    """Whether a node is of a type, or a group that holds one."""
    tree = getattr(node, "node_tree", None)
    return node.bl_idname == kind or any(_holds(inner, kind) for inner in (tree.nodes if tree else ()))


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
