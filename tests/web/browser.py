# SPDX-License-Identifier: GPL-3.0-or-later
"""A real browser, driven headless through a page; tests that need one are skipped where there is none."""

import base64
import json
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from tests.web.node import WEB

_NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")


class Browser:
    """Chromium, by the path of its program."""

    def __init__(self):
        self.program = next(filter(None, map(shutil.which, _NAMES)), None)
        self.node = shutil.which("node")

    def skip_if_missing(self):
        if not self.program:
            pytest.skip("Chromium is not installed (apt-get install chromium)")
        if not self.node or not (WEB / "node_modules" / "puppeteer-core").is_dir():
            pytest.skip("Node or the web's packages are not installed (npm ci in web, as make test does)")

    def open(self, page, steps, width=320, height=180, touch=False, flags=()):
        """What the steps come to, one after the other (see drive.mjs); nothing may have gone wrong in the page."""
        request = {"browser": self.program, "page": Path(page).as_uri(), "width": width, "height": height}
        request |= {
            "touch": touch,
            "flags": list(flags),
            "steps": [step if isinstance(step, dict) else {"run": step} for step in steps],
        }
        command = [str(self.node), str(Path(__file__).with_name("drive.mjs"))]
        done = subprocess.run(command, input=json.dumps(request), capture_output=True, text=True, timeout=240)
        assert done.returncode == 0, done.stderr
        answer = json.loads(done.stdout)
        assert not answer["errors"], answer["errors"]
        return [_plain(result) for result in answer["results"]]


def _plain(result):
    if isinstance(result, dict) and "floats" in result:
        return np.frombuffer(base64.b64decode(result["floats"]), dtype=np.float32)
    return result
