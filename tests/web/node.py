# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs Node's tools in the web's workspace; tests that need them are skipped where they are not."""

import shutil
import subprocess
from pathlib import Path

import pytest

WEB = Path(__file__).resolve().parents[2] / "web"


def npm(*words):
    """Run npm in the workspace; skips the test without npm, or before `npm ci` has brought the packages."""
    command = shutil.which("npm")
    if not command:
        pytest.skip("npm is not installed (apt-get install npm)")
    if not (WEB / "node_modules").is_dir():
        pytest.skip("the web's packages are not installed (npm ci in web, as make test does)")
    return subprocess.run([command, *words], cwd=WEB, capture_output=True, text=True, timeout=300)


def run_node(script, *words):
    """What a script prints that takes the workspace's folder before its words; skips the test as `npm` does."""
    command = shutil.which("node")
    if not command or not (WEB / "node_modules").is_dir():
        pytest.skip("Node or the web's packages are not installed (npm ci in web, as make test does)")
    done = subprocess.run(
        [command, str(script), str(WEB), *map(str, words)], capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, done.stderr
    return done.stdout
