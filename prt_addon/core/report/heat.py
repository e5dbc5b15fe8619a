# SPDX-License-Identifier: GPL-3.0-or-later
"""Computes the error at every receiver, for a map of where it sits."""

from __future__ import annotations

import numpy as np

from ..arrays import Float64
from ..workers import ALL_CORES, Workers
from .findings import INSIDE
from .path_tracer import trace_light
from .subject import Lighting, Subject, clamped, dot

PATHS = 128
"""Per receiver: leaves a few percent of noise, which a map may show."""


def receiver_errors(subject: Subject, light: Lighting, seed: int, workers: Workers = ALL_CORES) -> Float64:
    """(N,) by how much each receiver is too bright, mean of the channels, as a share of the object's true RMS.

    Receivers inside other geometry, which are never seen, get zero.
    """
    group = subject.group
    receivers = subject.receivers_at(group.points, group.normals, np.arange(len(group)))
    scene = subject.scenery.scene if subject.casts_rays else None
    bounces, sky = subject.scenery.bounces(subject.settings), light.sky(subject.axes)
    truth = trace_light(scene, receivers, sky, PATHS, seed, bounces, 0, workers).radiance[:, 0]
    shown = clamped(dot(subject.transport, light.shown(subject.axes)))
    seen = np.ones(len(group), dtype=np.bool_)
    if subject.casts_rays:
        seen = subject.scenery.surroundings.backs(receivers, seed, workers) <= INSIDE
    whole = np.sqrt((truth[seen] ** 2).mean()) if seen.any() else 0.0
    return np.where(seen, (shown - truth).mean(axis=-1), 0.0) / (whole or 1.0)
