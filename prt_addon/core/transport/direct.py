# SPDX-License-Identifier: GPL-3.0-or-later
"""Computes direct transport: what a white Lambertian receiver makes of each SH light that reaches it unbounced.

Sloan, Kautz & Snyder 2002, "Precomputed Radiance Transfer", section 4: `T_i = 1/pi integral V(w) cos(w) Y_i(w) dw`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from ..arrays import Float32, Float64
from ..monitor import Work
from ..problem import ReceiverGroup
from ..sphere import sh
from ..sphere.directions import cosine_fibonacci, random_azimuths, tangent_frames
from ..sphere.rotation import rotate_order2
from ..workers import ALL_CORES, Workers
from .raycast import RayScene

_RAYS_AT_A_TIME = 1 << 17  # a few MB per thread: inside the cache, yet long enough to hide the calls
_NORMALS_AT_A_TIME = 1 << 14
_FIXED_POINT = 2.0**30


@dataclass(frozen=True)
class Receivers:
    """Points that light arrives at.

    Attributes:
        points: (N, 3) float64, the scene's normalised coordinates (`RayScene.normalised`).
        normals: (N, 3) float64 unit shading normals, world axes.
        ids: (N,) int64, what the random turn depends on beside the seed: the index within the object, so that an
            object's bake does not depend on which others are baked with it.
        skips: (N,) float64, how far along itself each ray starts (`RayScene.skips`).
        horizons: (N, 3) as those of a `ReceiverGroup`; None if there are none.
    """

    points: Float64
    normals: Float64
    ids: npt.NDArray[np.int64]
    skips: Float64
    horizons: Float64 | None = None

    @classmethod
    def of(cls, groups: Sequence[ReceiverGroup], scene: RayScene) -> Receivers:
        """The receivers of some groups, at least one, in their order."""
        places = [scene.normalised(group.points) for group in groups]
        return cls(
            points=np.concatenate(places),
            normals=np.concatenate([group.normals for group in groups]),
            ids=np.concatenate([np.arange(len(group)) for group in groups]),
            skips=np.concatenate(
                [scene.skips(place, group.radius) for place, group in zip(places, groups, strict=True)]
            ),
            horizons=_horizons(groups),
        )

    def __len__(self) -> int:
        return len(self.points)

    def __getitem__(self, part: slice | npt.NDArray[np.integer[Any]]) -> Receivers:
        horizons = None if self.horizons is None else self.horizons[part]
        return Receivers(self.points[part], self.normals[part], self.ids[part], self.skips[part], horizons)


def _horizons(groups: Sequence[ReceiverGroup]) -> Float64 | None:
    if all(group.horizons is None for group in groups):
        return None
    return np.concatenate([np.zeros((len(group), 3)) if group.horizons is None else group.horizons for group in groups])


def unshadowed(normals: Float64, order: int = sh.ORDER, workers: Workers = ALL_CORES) -> Float32:
    """Compute the transport of open receivers in closed form: `T_lm = A_l / pi * Y_lm(n)`.

    The convolution theorem of Ramamoorthi & Hanrahan 2001, "An Efficient Representation for Irradiance Environment
    Maps", with the Lambertian 1/pi.

    Args:
        normals: (N, 3) unit vectors.
        order: highest band.
        workers: who does it.

    Returns:
        (N, (order + 1)**2) float32.
    """
    factors = sh.per_coefficient(sh.cosine_lobe(order)) / np.pi
    out = np.empty((len(normals), len(factors)), dtype=np.float32)

    def work(part: slice) -> None:
        """Fill the rows of some normals."""
        np.multiply(sh.basis(normals[part], order), factors, out=out[part])

    workers.run(len(normals), _NORMALS_AT_A_TIME, work)
    return out


def shadowed(
    scene: RayScene,
    receivers: Receivers,
    samples: int,
    seed: int = 0,
    workers: Workers = ALL_CORES,
) -> Float32:
    """Compute shadowed transport by cosine-weighted rays.

    Args:
        scene: what blocks the light.
        receivers: N points.
        samples: rays per receiver.
        seed: another pattern of noise; the result is a function of (scene, receivers, samples, seed) alone.
        workers: who does it.

    Returns:
        (N, 9) float32, order 2.
    """
    pattern = RayPattern(samples, seed)
    out = np.empty((len(receivers), sh.coefficient_count(sh.ORDER)), dtype=np.float32)

    def work(part: slice) -> Work:
        """Cast the rays of some receivers, and fill their rows."""
        rays = pattern.rays(receivers[part])
        visible = scene.visible(rays.origins, rays.directions)
        if rays.above is not None:
            visible &= rays.above
        out[part] = pattern.project(visible, rays.frames)
        return Work(rays=len(rays.origins))

    workers.run(len(receivers), pattern.chunk, work)
    return out


@dataclass(frozen=True)
class Rays:
    """The rays of n receivers, receiver-major: origins and directions (n * samples, 3), frames (n, 3, 3).

    Attributes:
        above: (n * samples,) which do not go down through the face that they start on; None if all of them.
    """

    origins: Float32
    directions: Float32
    frames: Float64
    above: npt.NDArray[np.bool_] | None = None


class RayPattern:
    """One cosine-weighted Fibonacci set, turned about the normal of each receiver by a random azimuth.

    Since all receivers share the set in their local frames, projection is a product of visibility (N x S) with
    one table (S x 9), and the nine numbers are turned into the world afterwards. The visibility of eight rays is a byte:
    what they add is looked up.
    """

    def __init__(self, samples: int, seed: int) -> None:
        self.samples, self.seed = samples, seed
        self.chunk = max(1, _RAYS_AT_A_TIME // samples)
        self._directions: Float32 = np.ascontiguousarray(cosine_fibonacci(samples).T, dtype=np.float32)
        self._sums = _sums_of_eight(samples)

    def rays(self, receivers: Receivers) -> Rays:
        """All rays of some receivers. Multiply-adds over whole rows, because small matrix products are slow in a
        NumPy without BLAS, as Blender's own is."""
        frames = tangent_frames(receivers.normals, random_azimuths(receivers.ids, self.seed))
        count = len(receivers)
        directions = np.empty((count, self.samples, 3), dtype=np.float32)
        origins = np.empty_like(directions)
        axes, points = frames.astype(np.float32), receivers.points.astype(np.float32)
        skips = receivers.skips.astype(np.float32)[:, None]
        x, y, z = self._directions
        for k in range(3):
            along = axes[:, 0, k, None] * x
            along += axes[:, 1, k, None] * y
            along += axes[:, 2, k, None] * z
            directions[:, :, k] = along
            along *= skips
            along += points[:, k, None]
            origins[:, :, k] = along
        above = None
        if receivers.horizons is not None:
            horizons = receivers.horizons.astype(np.float32)[:, None]
            above = ((directions * horizons).sum(axis=-1) >= 0.0).reshape(-1)
        return Rays(origins.reshape(-1, 3), directions.reshape(-1, 3), frames, above)

    def project(self, visible: npt.NDArray[np.bool_], frames: Float64) -> Float64:
        """World-space coefficients (n, 9) from the visibility of the rays (n * samples,)."""
        eights = np.packbits(visible.reshape(-1, self.samples), axis=1).T
        at = eights + 256 * np.arange(len(eights))[:, None]
        local = self._sums.take(at, axis=0).sum(axis=0)
        return rotate_order2(local / (_FIXED_POINT * self.samples), frames)


def _exact_table(samples: int) -> Float64:
    """(S, 9) the basis at the pattern's directions, made to sum right and to sum the same everywhere.

    A constant per coefficient is added so that a receiver with an open sky gets its closed form exactly, and one
    with none gets zero. Then the numbers are rounded to fixed point: whole numbers below 2**53 add without rounding,
    so the sum has the same bits in whatever order it is taken.
    """
    table = sh.basis(cosine_fibonacci(samples))
    closed_form = sh.basis([0.0, 0.0, 1.0]) * sh.per_coefficient(sh.cosine_lobe()) / np.pi
    return np.rint((table + (closed_form - table.mean(axis=0))) * _FIXED_POINT)


@lru_cache(maxsize=1)
def _sums_of_eight(samples: int) -> Float64:
    """What every eight rays add, (S / 8 * 256, 9): a row for each of their 256 visibilities, as `np.packbits` packs them.

    A product would do the same in a BLAS, whose own threads fight with ours, or slowly without one, as in Blender.
    """
    table = _exact_table(samples)
    eights = np.concatenate([table, np.zeros((-samples % 8, table.shape[1]))]).reshape(-1, 8, table.shape[1])
    bits = np.unpackbits(np.arange(256, dtype=np.uint8)[:, None], axis=1)
    return np.einsum("vb,ebc->evc", bits, eights).reshape(-1, table.shape[1])
