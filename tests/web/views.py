# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of the same view, by EEVEE and by others, compared."""

import numpy as np

WIDTH, HEIGHT = 320, 180


def eevee(stage, scene, path, samples=1):
    """Its frame of the scene's view over nothing, (H, W, 4), without smoothing beyond the pixel.

    One sample shows baked light without noise. Soft shadows take a dozen, those of cut-outs and veils more.
    """
    scene.render.film_transparent, scene.render.filter_size = True, 0.01
    scene.eevee.taa_render_samples = samples
    return stage.render(path)


def relative_rms(found, wanted):
    difference = found[:, :3] - wanted[:, :3]
    return np.sqrt((difference**2).mean() / (wanted[:, :3] ** 2).mean())
