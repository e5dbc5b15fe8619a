# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes transport anew at any points, with as many rays as the bake had and with noise that is independent of its
noise.

Two such replicates, independent of each other and of what is stored, are what sampling and tessellation are measured
with. Halving one bake's own set of rays would not do: its points are spread so evenly that half of them leave more than
twice the variance of the whole, and the noise would be overestimated.

Light that bounces is gathered once, over the transport that is stored: the noise of far surfaces averages out there, and
what is left is that of the receiver's own rays.
"""

from __future__ import annotations

import numpy as np

from ..arrays import Float32
from ..problem import BakeSettings
from ..transport.direct import Receivers, shadowed, unshadowed
from ..transport.gather import Gather
from ..transport.hits import PackedHits, corners, trace
from ..workers import ALL_CORES, Workers
from .subject import Scenery, Subject

_ROUGHLY = 16  # rays per receiver that is not baked, where light bounces off it


def fresh_transport(
    subject: Subject, receivers: Receivers, samples: int, seed: int, workers: Workers = ALL_CORES
) -> Float32:
    """(n, 9, C) float32 transport of n receivers, C being 3 or, where all is grey or unbounced, 1.

    Args:
        subject: what they are points of.
        receivers: made by `subject.receivers_at`.
        samples: rays per receiver.
        seed: of their random turns.
        workers: who does it.
    """
    settings, scenery = subject.settings, subject.scenery
    if not subject.casts_rays:
        return unshadowed(receivers.normals)[:, :, None]
    if not settings.bounces_light or scenery.occluders.albedo is None:
        return shadowed(scenery.scene, receivers, samples, seed, workers)[:, :, None]
    corner = scenery.corner_receiver
    direct, hits = trace(scenery.scene, receivers, samples, seed, (corner >= 0).any(axis=1), workers)
    gather = Gather(hits, scenery.occluders.albedo_of_sides, corner, workers)
    light = _bounced_from(scenery, settings, hits, workers).transpose(0, 2, 1)[:, : gather.channels]
    return (direct[:, None, :] + gather(np.ascontiguousarray(light))).transpose(0, 2, 1)


def _bounced_from(scenery: Scenery, settings: BakeSettings, hits: PackedHits, workers: Workers) -> Float32:
    """(N, 9, 3) of all receivers: what is stored, and of those that are hit and not baked, their direct light."""
    receivers = scenery.receivers
    known = scenery.transport
    if known is None:
        known = np.full((len(receivers), 9, 3), np.nan, dtype=np.float32)
    shown = scenery.corner_receiver[np.unique(corners(hits.packed) // 3)]
    hit = np.unique(shown[shown >= 0])
    missing = hit[np.isnan(known[hit, 0, 0])]
    filled = np.nan_to_num(known)
    if len(missing):
        direct = shadowed(scenery.scene, receivers[missing], _ROUGHLY, settings.seed, workers)
        filled[missing] = direct[:, :, None]
    return filled
