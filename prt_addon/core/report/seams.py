# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures the part of the error at seams, where meshes sink into one another: on faces with a corner inside other
geometry.

It is a share of the whole error by place, and not by cause: what it holds is in no other part, as these look at such faces
without their covered corners.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import Float64
from .findings import Findings
from .measures import Estimate, product, relative_rms
from .pool import pooled


@dataclass(frozen=True)
class Seams:
    """The error at seams, as a share of the true radiance's RMS everywhere, and the object that has most of it."""

    relative_rms: Estimate
    where: str


def seams(found: Sequence[Findings]) -> Seams:
    """Measure the error at the seams of some objects."""

    def squares(one: Findings) -> Float64:
        """(n,) estimates of the squared error at each point, 0 away from seams."""
        return np.where(one.at_seam, product(*(one.shown - one.truth)), 0.0)

    amounts = {one.name: float(one.weights @ squares(one)) for one in found}
    return Seams(relative_rms(*pooled(found, squares)), max(amounts, key=lambda name: amounts[name], default=""))
