# SPDX-License-Identifier: GPL-3.0-or-later
"""No engine before a test or after it, and a scene to bake."""

import pytest

from prt_addon.worker import job
from tests.core import bouncing


@pytest.fixture(autouse=True)
def no_engine_is_left():
    """Neither before a test nor after it."""
    job.end_engine()
    yield
    job.end_engine()


@pytest.fixture
def scene():
    return bouncing.corner(8)
