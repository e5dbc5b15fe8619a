# SPDX-License-Identifier: GPL-3.0-or-later
"""The polynomials of shaders come close to the tables that they stand for."""

import numpy as np

from prt_addon.core.microfacet import fit
from prt_addon.core.microfacet.albedo import by_quadrature
from prt_addon.core.microfacet.table import average_albedo

ROUGHNESS = np.linspace(0.013, 1.0, 17)
MU = np.linspace(0.023, 1.0, 29)


def test_polynomials_are_the_albedos():
    """As near as they say, between the points that they were fitted to."""
    exact = by_quadrature(MU, ROUGHNESS[:, None]).white
    np.testing.assert_allclose(fit.albedo(MU, ROUGHNESS[:, None]), exact, rtol=6e-3)
    np.testing.assert_allclose(fit.average(ROUGHNESS), average_albedo(ROUGHNESS), atol=3e-3)


def test_nothing_is_lost_without_roughness():
    np.testing.assert_allclose(fit.albedo(MU, 0.0), 1.0, atol=0.01)
    np.testing.assert_allclose(fit.average(0.0), 1.0, atol=1e-3)
