# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the light that a glTF file holds the world of a scene: it turns and dims as the world that was exported."""

from __future__ import annotations

import bpy
import numpy as np
import numpy.typing as npt
from mathutils import Matrix

from ...core.exchange.gltf_extras import SceneLight
from ...core.sky.from_light import sky_of
from ...core.sphere import sh
from ..light.light import has_light, write_light
from ..sky.cube_maps import set_up_world
from ..sky.identity import sky_identity
from ..sky.projection import LightSettings, Projection
from ..sky.sky import read_sky

_HEIGHT = 256
_SMALLEST = 0.05
"""Share of a band that a window leaves, below which what was there before is lost."""


def light_with(scene: bpy.types.Scene, found: SceneLight, name: str) -> str:
    """Light a scene as a file has it, if its world carries no light yet.

    Args:
        scene: to light.
        found: the light of the file.
        name: of the world that is made.

    Returns:
        A sentence for the user.
    """
    if has_light(scene.world):
        return f"world '{scene.world.name}' has a light of its own, which lights what was imported."
    before = scene.world
    factors = _window(found)
    whole = found.light / sh.per_coefficient(factors)[:, None]
    world = set_up_world(scene, name, sky_of(whole, found.suns, _HEIGHT))
    nodes = world.node_tree.nodes
    nodes["Mapping"].inputs["Rotation"].default_value = Matrix(found.turn.tolist()).to_euler("XYZ")
    nodes["Background"].inputs["Strength"].default_value = found.strength
    sky = read_sky(scene)
    way = f"The light of the file, as nine coefficients keep it, is the sky of world '{world.name}'"
    count = len(found.suns.lamps)
    settings = LightSettings(lamps="NONE" if not count else "FOUR" if count <= 4 else "EIGHT")
    write_light(sky, Projection(found.light, found.suns, settings, factors, (0.0, 0.0), sky_identity(sky), way))
    bpy.context.view_layer.update()  # drivers: turn and strength
    return f"{way}{f'; world {before.name!r} is kept in the file' if before else ''}."


def _window(found: SceneLight) -> npt.NDArray[np.float64]:
    """(3,) what a window has left of each band, found by the lamps; 1 where there are none."""
    factors = np.ones(sh.ORDER + 1)
    if not found.suns.lamps:
        return factors
    wanted = found.suns.coloured_light()
    for band in range(sh.ORDER + 1):
        whole, windowed = (part[sh.band_slice(band)].ravel() for part in (wanted, found.lamps))
        if whole @ whole > 0.0:
            factors[band] = np.clip(whole @ windowed / (whole @ whole), _SMALLEST, 1.0)
    return factors
