# SPDX-License-Identifier: GPL-3.0-or-later
"""Layers rounded to 16 bits come back within half a step, marks and all."""

import numpy as np

from prt_addon.core import layout
from prt_addon.core.exchange import shorts


def layers_of(space):
    """Forty receivers' layers, each of another size; the fifth is black."""
    rng = np.random.default_rng(3)
    sizes = np.geomspace(0.3, 3e-4, 9)
    sizes[4] = 0.0
    transport, direct = (rng.uniform(-1.0, 1.0, size=(40, 9, 3)) * sizes[:, None] for _ in range(2))
    direct = np.abs(direct[..., 0]).astype(np.float32)
    return np.stack([layout.packed(i, transport[:, i], direct[:, i], space) for i in range(9)], axis=1)


def test_rounding_is_within_half_a_step_of_each_layer():
    """Of its colour and of its alpha alike, beside a mark that is far larger than either."""
    layers = layers_of("OBJECT")
    numbers, scales = shorts.rounded(layers)
    assert numbers.dtype == np.int16 and np.abs(numbers.astype(int)).max() == shorts.MOST and scales[4, 0] == 1.0
    back = shorts.restored(numbers / shorts.MOST, scales)
    for part in (slice(0, 3), slice(3, 4)):
        most = np.abs(layers[..., part]).max(axis=(0, 2))
        error = np.abs(back[..., part] - layers[..., part]).max(axis=(0, 2))
        assert (error <= most / shorts.MOST * 0.501 + 1e-12).all()


def test_the_marks_stay_apart():
    for space, own in (("SCENE", False), ("OBJECT", True)):
        numbers, scales = shorts.rounded(layers_of(space))
        alpha = shorts.restored(numbers / shorts.MOST, scales)[:, 0, 3]
        assert ((alpha < layout.OWN_AXES_BELOW) == own).all() and (alpha < layout.BAKED_BELOW).all()


def test_no_receivers():
    numbers, scales = shorts.rounded(np.zeros((0, 9, 4), dtype=np.float32))
    assert numbers.shape == (0, 9, 4) and (scales == 1.0).all()
