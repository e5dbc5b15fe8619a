# SPDX-License-Identifier: GPL-3.0-or-later
"""What is known of each of Blender's shader nodes: which inputs make its colour and its glow, what it lets through, how it is relit.

Those who read materials and those who rebuild their surfaces both go by it, so that none of them knows a shader that others do not.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import bpy

Relit = Literal["MATTE", "GLOSSY", "PRINCIPLED", "SPECULAR", "UNCHANGED"]
Through = Literal["NOTHING", "COLOUR", "GLASS", "PRINCIPLED", "TRANSPARENCY"]

COMBINING = {"ShaderNodeMixShader", "ShaderNodeAddShader"}
"""Nodes that make one shader of two."""

SHADER_TO_RGB = "ShaderNodeShaderToRGB"
"""Makes a colour of the light that EEVEE finds on a shader. Cycles has no such node: it is black there."""


@dataclass(frozen=True)
class Shader:
    """A shader node.

    relit: how the baked light is put in; UNCHANGED if none belongs in: it emits, lets light through, or is glass.
    colour: the input of its colour; empty if it reflects nothing. A setting of a node may hide it: see `colour_input`.
    glow: the inputs that it emits by, as long as none is black.
    through: what says which share of the light it lets through. One that passes its COLOUR on reflects nothing.
    """

    relit: Relit
    colour: str = "Color"
    glow: tuple[str, ...] = ()
    through: Through = "NOTHING"


_MATTE = ("Diffuse", "Translucent", "Sheen", "Toon", "Hair", "HairPrincipled")
_VOLUMES = ("Absorption", "Coefficients", "Principled", "Scatter")

SHADERS = {
    **{f"ShaderNodeBsdf{kind}": Shader("MATTE") for kind in _MATTE},
    "ShaderNodeSubsurfaceScattering": Shader("MATTE"),
    "ShaderNodeBsdfAnisotropic": Shader("GLOSSY"),
    "ShaderNodeBsdfMetallic": Shader("GLOSSY", "Base Color"),
    "ShaderNodeBsdfPrincipled": Shader(
        "PRINCIPLED", "Base Color", ("Emission Strength", "Emission Color"), "PRINCIPLED"
    ),
    "ShaderNodeEeveeSpecular": Shader("SPECULAR", "Base Color", ("Emissive Color",), "TRANSPARENCY"),
    "ShaderNodeBsdfGlass": Shader("UNCHANGED", through="GLASS"),
    "ShaderNodeBsdfRefraction": Shader("UNCHANGED", through="GLASS"),
    "ShaderNodeBsdfTransparent": Shader("UNCHANGED", through="COLOUR"),
    "ShaderNodeBsdfRayPortal": Shader("UNCHANGED", through="COLOUR"),
    "ShaderNodeEmission": Shader("UNCHANGED", "", ("Strength", "Color")),
    "ShaderNodeBackground": Shader("UNCHANGED", "", ("Strength", "Color")),
    "ShaderNodeHoldout": Shader("UNCHANGED", ""),
    **{f"ShaderNodeVolume{kind}": Shader("UNCHANGED", "") for kind in _VOLUMES},  # black, in place of a surface
}
"""By the identifier of the node's type. What is not here is shown as it is, and named."""


def colour_input(node: bpy.types.Node) -> bpy.types.NodeSocket | None:
    """The input of a known shader's colour; None if it has none, or a setting has others make the colour: melanin, indices of refraction."""
    shader = SHADERS.get(node.bl_idname)
    return node.inputs.get(shader.colour) if shader and shader.colour else None
