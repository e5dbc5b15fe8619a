# SPDX-License-Identifier: GPL-3.0-or-later
"""Describes what a report judges: a baked surface, all that shades it, and the light that falls on it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from ..arrays import Float32, Float64, Int64
from ..problem import BakeSettings, Occluders, ReceiverGroup
from ..sky.find_lamps import extract_lamps
from ..sky.projection import project_equirect
from ..sky.sampler import Skylight
from ..sphere.rotation import rotation_matrix
from ..transport.direct import Receivers
from ..transport.inside import Surroundings
from ..transport.raycast import RayScene
from .path_tracer import Bounces

ORDERS = (1, 2, 3, 4, 5, 6)
"""Whose truncation a report measures."""

_PATIENCE = 16  # bounces traced where a bake went on until its tolerance: less than 3 % of an albedo of 0.8 is left


class Lighting:
    """The light on the world: the sky as it is, and the SH light that the shader gets instead."""

    def __init__(
        self, picture: Float32, turn: Float64, stored: Float64, rule: tuple[int, float], wide: bool = True
    ) -> None:
        """
        Args:
            picture: (H, W, 3) equirectangular radiance, strength included, row 0 at the bottom.
            turn: (3, 3) R: along w, the sky shows what the picture holds along R w.
            stored: (9, 3) the SH light as it is shown: turned, scaled, windowed.
            rule: which lamps could show parts of the sky instead, or do so: how many at most, and under which truncation no more.
            wide: whether wide spots are among them.
        """
        self.lamps, without = extract_lamps(picture, *rule, wide)
        pictures = [picture, without] if self.lamps.lamps else [picture]
        self.turn, self.stored = turn, stored
        self._sky = Skylight(np.stack(pictures), turn)
        self._projected = [project_equirect(one, ORDERS[-1]) for one in pictures]

    def sky(self, axes: Float64) -> Skylight:
        """The sky along directions in axes (3, 3), whose columns are the world's directions of them."""
        return self._sky.turned(self.turn @ axes)

    def shown(self, axes: Float64) -> Float64:
        """(9, 3) the stored light in these axes."""
        return rotation_matrix(axes.T) @ self.stored

    def projected(self, axes: Float64) -> list[Float64]:
        """(49, 3) the projection of each picture in these axes."""
        matrix = rotation_matrix((self.turn @ axes).T, ORDERS[-1])
        return [matrix @ one for one in self._projected]


@dataclass(frozen=True)
class Scenery:
    """Surfaces that shade each other, and the transport of all that stands there.

    Attributes:
        groups: as the bake had them, in the order that `occluders.corner_receiver` counts their receivers.
        transport: (N, 9, 3) float32 of all these receivers; NaN where nothing is baked. Needed where light bounces.
    """

    occluders: Occluders
    groups: Sequence[ReceiverGroup]
    transport: Float32 | None = None

    @cached_property
    def scene(self) -> RayScene:
        """The surfaces as the ray caster takes them."""
        return RayScene.of(self.occluders)

    @cached_property
    def surroundings(self) -> Surroundings:
        """What receivers may lie inside of."""
        return Surroundings(self.scene, self.occluders.vertices, self.occluders.triangles)

    @cached_property
    def corner_receiver(self) -> Int64:
        """(S, 3) the receiver at each corner of the sides of triangles, -1 for none; all fronts come first, then all backs if they count."""
        return self.occluders.receiver_at_corners

    @cached_property
    def receivers(self) -> Receivers:
        """All receivers of the groups."""
        return Receivers.of(self.groups, self.scene)

    def bounces(self, settings: BakeSettings) -> Bounces | None:
        """How paths go on from these surfaces, if the bake had light bounce."""
        if not bounce_count(settings) or self.occluders.albedo is None:
            return None
        return Bounces(
            bounce_count(settings),
            self._corners,
            self._normals,
            (self.corner_receiver >= 0).any(axis=1),
            self.occluders.albedo_of_sides,
        )

    @cached_property
    def _normals(self) -> Float64:
        corner = self.corner_receiver
        return np.where((corner >= 0)[..., None], self.receivers.normals[corner], 0.0)

    @cached_property
    def _corners(self) -> Float64:
        corners = self.scene.normalised(self.occluders.vertices)[self.occluders.triangles]
        return corners if self.occluders.back_receiver is None else np.concatenate([corners, corners])


@dataclass(frozen=True)
class Subject:
    """One baked object.

    Attributes:
        group: its receivers.
        settings: what it was baked with.
        transport: (n, 9, 3) float32 what is stored, per receiver.
        corners: (T, 3, 3) its triangles, in the axes of its receivers.
        corner_receiver: (T, 3) its own receivers at them.
        scenery: what shades it.
        axes: (3, 3) columns: the axes of its receivers in the world.
    """

    group: ReceiverGroup
    settings: BakeSettings
    transport: Float32
    corners: Float64
    corner_receiver: Int64
    scenery: Scenery
    axes: Float64

    @property
    def bounce_count(self) -> int:
        """How often light bounces along the paths that this bake is judged by."""
        return bounce_count(self.settings)

    @property
    def casts_rays(self) -> bool:
        """Whether anything shades it at all."""
        return self.settings.casts_rays

    def receivers_at(self, positions: Float64, normals: Float64, ids: Int64) -> Receivers:
        """Points of the object as receivers of rays, with its own skip."""
        if not self.casts_rays:
            return Receivers(positions, normals, ids, np.zeros(len(ids)))
        scene = self.scenery.scene
        places = scene.normalised(positions)
        return Receivers(places, normals, ids, scene.skips(places, self.group.radius))


def bounce_count(settings: BakeSettings) -> int:
    """How often light bounces along the paths that a bake is judged by."""
    if not settings.bounces_light:
        return 0
    return settings.bounces if "bounces" in settings.used else _PATIENCE


def clamped(radiance: Float64, *, by: Float64 | None = None) -> Float64:
    """What the shader shows of a dot product: nothing below zero.

    Args:
        radiance: (..., 3).
        by: the same without noise, whose sign then decides: a clamp of noise would be a bias.
    """
    return np.where((radiance if by is None else by) > 0.0, radiance, 0.0)


def dot(transport: npt.NDArray[np.floating[Any]], light: Float64) -> Float64:
    """(..., 3) what transport (..., K, C) shows under a light (K, 3), channel by channel; C is 1 or 3."""
    return np.asarray(np.einsum("...kc,kc->...c", transport, light[: transport.shape[-2]]), dtype=np.float64)
