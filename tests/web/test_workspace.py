# SPDX-License-Identifier: GPL-3.0-or-later
"""The web's workspace: its own tests, types and style, run by Node."""

import pytest

from tests.web.node import npm

pytestmark = pytest.mark.once


@pytest.mark.parametrize("task", ["check", "test"])
def test_npm(task):
    """As `npm run check` and `npm test` in `web` say it."""
    done = npm("run", task)
    assert done.returncode == 0, done.stdout + done.stderr
