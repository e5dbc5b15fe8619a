# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures the whole error on the surface: what the shader shows against the light that arrives.

It is measured by itself and not added up from its parts: sampling, tessellation and truncation are independent, so that
their squares add up to its square, and what they do not explain would show here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .findings import Findings
from .measures import UNKNOWN, Estimate, product, ratio_of_means, relative_rms
from .pool import pooled


@dataclass(frozen=True)
class Total:
    """Relative RMS of the whole error, and the bias: by how much the surface is too bright, as a share of its light."""

    relative_rms: Estimate
    bias: Estimate


def total(found: Sequence[Findings]) -> Total:
    """Measure the whole error of some objects."""
    return Total(relative_rms(*pooled(found, lambda one: product(*(one.shown - one.truth)))), _bias(found))


def _bias(found: Sequence[Findings]) -> Estimate:
    if not found:
        return UNKNOWN
    truth = np.concatenate([one.truth.mean(axis=(0, 2)) for one in found])
    error = np.concatenate([one.shown.mean(axis=-1) for one in found]) - truth
    return ratio_of_means(error, truth, np.concatenate([one.weights for one in found]))
