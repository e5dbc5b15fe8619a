# SPDX-License-Identifier: GPL-3.0-or-later
"""Compares two pictures of one scene, in linear light and as the eye sees them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Bools, Float32, Float64
from .measures import TWO_SIDED_95, Estimate, percentile, product, ratio_of_means, relative_rms

_OPAQUE = 0.99


@dataclass(frozen=True)
class PictureDifference:
    """How far a picture is from the truth, over the pixels that both show whole.

    The intervals of the first two are those that the truth's own noise leaves: no other pixels could have been drawn.

    Attributes:
        relative_rms: as in `measures`, every pixel counting alike.
        bias: by how much it is too bright, as a share of the truth's mean.
        percentile_95: what 95 % of the pixels' errors stay below, as a share of the truth's RMS; noise included.
        pixels: how many were compared.
    """

    relative_rms: Estimate
    bias: Estimate
    percentile_95: Estimate
    pixels: int


def compared(ours: Float32, truths: Float32) -> Bools:
    """(H, W) pixels that our picture (H, W, 4) and both of the truth's (2, H, W, 4) show whole."""
    opaque: Bools = np.minimum(ours[..., 3], truths[..., 3].min(axis=0)) > _OPAQUE
    return opaque


def picture_difference(ours: Float32, truths: Float32) -> PictureDifference:
    """Measure a picture (H, W, 4) against two independently rendered ones of the truth (2, H, W, 4), linear light."""
    mask = compared(ours, truths)
    truth = truths[:, mask, :3].astype(np.float64)
    errors = ours[mask][:, :3] - truth
    squares, whole, weights = product(*errors), product(*truth), np.ones(int(mask.sum()))
    mean, error = truth.mean(axis=(0, 2)), errors.mean(axis=(0, 2))
    rms = relative_rms(squares, whole, weights)
    bias = ratio_of_means(error, mean, weights)
    if not rms.is_known:
        return PictureDifference(rms, bias, rms, len(weights))
    margin = _margin(
        product(errors[0], errors[0])
        - product(errors[1], errors[1])
        - rms.value**2 * (product(truth[0], truth[0]) - product(truth[1], truth[1]))
    ) / float(whole.sum())
    low, high = np.sqrt(np.maximum(rms.value**2 + np.array((-margin, margin)), 0.0))
    bias_margin = _margin((1.0 + bias.value) * (truth[0] - truth[1]).mean(axis=-1)) / float(mean.sum())
    local = np.sqrt((errors.mean(axis=0) ** 2).mean(axis=-1) / whole.mean())
    return PictureDifference(
        Estimate(rms.value, float(low), float(high)),
        Estimate(bias.value, bias.value - bias_margin, bias.value + bias_margin),
        percentile(local, weights, 0.95),
        len(weights),
    )


def _margin(differences: Float64) -> float:
    """What the noise of two independent pictures leaves of a sum over pixels, 19 times in 20.

    The sum takes the two alike: it is a mean of both, or a product of one with the other. For noise that is normal, of
    whatever size and correlation between channels, its variance is then a quarter of the sum of squares of these
    `differences`: of what the mean's summand, or the square in place of the product, is in one and in the other.
    """
    return TWO_SIDED_95 * 0.5 * float(np.sqrt((differences**2).sum()))


def flip(ours: Float32, truth: Float32, mask: Bools) -> float | None:
    """Mean FLIP error in [0, 1] of displayed pictures (H, W, 3), sRGB-encoded, in [0, 1], over (H, W) pixels.

    Andersson et al. 2020, "FLIP: A Difference Evaluator for Alternating Images", by its authors' own package
    `flip-evaluator`, at the default 67 pixels per degree. None where that is not installed, as in Blender itself.
    """
    try:
        from flip_evaluator import evaluate
    except ImportError:
        return None
    error, _, _ = evaluate(*(np.ascontiguousarray(one) for one in (truth, ours)), "LDR", applyMagma=False)
    return float(np.asarray(error)[..., 0][mask].mean()) if mask.any() else None
