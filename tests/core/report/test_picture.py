# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures are compared without the noise of the truth, and without what one of them hides."""

import sys

import numpy as np
import pytest

from prt_addon.core.report.picture import compared, flip, picture_difference

SHAPE = (40, 60)


def pictures(error, noise, seed=1, grey=False):
    """A truth of about one, twice with noise, in all channels alike or not, and a picture off by `error` everywhere."""
    rng = np.random.default_rng(seed)
    truth = np.ones((*SHAPE, 4), dtype=np.float32)
    truth[..., :3] = rng.uniform(0.5, 1.5, (*SHAPE, 3))
    ours = truth.copy()
    ours[..., :3] += error
    both = np.stack([truth, truth])
    both[..., :3] += noise * rng.normal(size=(2, *SHAPE, 1 if grey else 3))
    return ours, both, truth


@pytest.mark.parametrize("grey", [False, True], ids=["coloured", "grey"])
@pytest.mark.parametrize(("error", "noise"), [(0.02, 0.1), (0.1, 0.1), (0.1, 0.02)])
def test_noise_is_no_error(error, noise, grey):
    """Errors under noise of another size: found, with intervals that hold them 19 times in 20, neither more nor less."""
    held = np.zeros(2)
    for seed in range(400):
        ours, both, truth = pictures(error, noise, seed, grey)
        found = picture_difference(ours, both)
        rms = error / np.sqrt((truth[..., :3] ** 2).mean())
        bias = error / truth[..., :3].mean()
        held += found.relative_rms.low < rms < found.relative_rms.high, found.bias.low < bias < found.bias.high
        assert abs(found.relative_rms.value - rms) < 0.03
    assert (held >= 370).all() and (held <= 391).all()


def test_bias_and_percentile():
    """Too bright by 2 % of the mean; without noise the 95th percentile is the error itself."""
    ours, both, truth = pictures(0.02, 0.0)
    found = picture_difference(ours, both)
    assert found.bias.value == pytest.approx(0.02 / truth[..., :3].mean(), rel=1e-3)
    assert found.percentile_95.value == pytest.approx(found.relative_rms.value, rel=1e-3)
    assert found.pixels == SHAPE[0] * SHAPE[1]


def test_only_what_all_show_whole_is_compared():
    """Transparent pixels of any picture are left out; none left is unknown."""
    ours, both, _ = pictures(0.02, 0.0)
    wanted = picture_difference(ours, both).relative_rms.value
    ours[:10, :, :] = 0.0
    both[1, :, :10, 3] = 0.5
    assert compared(ours, both).sum() == 30 * 50
    assert picture_difference(ours, both).relative_rms.value == pytest.approx(wanted, rel=0.02)
    both[..., 3] = 0.0
    assert not picture_difference(ours, both).relative_rms.is_known


def test_flip_is_its_authors(monkeypatch):
    """Nothing for equal pictures, more for a larger difference, and left out where the package is missing."""
    everywhere = np.ones(SHAPE, dtype=bool)
    grey = np.full((*SHAPE, 3), 0.5, dtype=np.float32)
    assert flip(grey, grey, everywhere) == pytest.approx(0.0, abs=1e-5)
    little, much = (flip(grey + step, grey, everywhere) for step in (np.float32(0.05), np.float32(0.3)))
    assert 0.0 < little < much < 1.0
    half = everywhere.copy()
    half[:20] = False
    below = grey.copy()
    below[20:] += np.float32(0.3)
    assert flip(below, grey, half) > 0.9 * much
    monkeypatch.setitem(sys.modules, "flip_evaluator", None)
    assert flip(grey, grey, everywhere) is None
