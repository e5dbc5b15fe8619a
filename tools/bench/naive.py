# SPDX-License-Identifier: GPL-3.0-or-later
"""Estimates transport simply: random directions over the whole sphere, one loop over the samples, all vertices at once."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from prt_addon.core.sphere import sh
from prt_addon.core.transport.direct import Receivers
from prt_addon.core.transport.raycast import RayScene


def uniform_sphere(scene: RayScene, receivers: Receivers, samples: int, seed: int = 0) -> npt.NDArray[np.float64]:
    """(N, 9) shadowed transport: `4 / S sum V max(cos, 0) Y`, the 1/pi of the surface and the 4pi of the sphere in one."""
    rng = np.random.default_rng(seed)
    total = np.zeros((len(receivers), sh.coefficient_count(sh.ORDER)))
    for _ in range(samples):
        directions = rng.normal(size=(len(receivers), 3))
        directions /= np.linalg.norm(directions, axis=1, keepdims=True)
        origins = receivers.points + receivers.skips[:, None] * directions
        visible = scene.visible(origins.astype(np.float32), directions.astype(np.float32))
        cosine = np.maximum((receivers.normals * directions).sum(axis=1), 0.0)
        total += (visible * cosine)[:, None] * sh.basis(directions)
    return total * (4.0 / samples)
