# SPDX-License-Identifier: GPL-3.0-or-later
"""Keeps the pictures of tests that fail: each as a PNG, and what each differs by from the one before it.

A plugin of pytest. They lie under build/failed/<test>, or where `--failed-pictures` says.
"""

import re
import shutil
import sys
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

BRIGHTER = 4.0
"""Times the absolute difference, so that a few percent are seen."""


def pytest_addoption(parser):
    default = Path(__file__).resolve().parent.parent / "build" / "failed"
    parser.addoption("--failed-pictures", type=Path, default=default, help="folder for the pictures of failed tests")


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item, call):
    report = yield
    if report.when == "call" and report.failed and "tmp_path" in item.funcargs and "bpy" in sys.modules:
        name = re.sub(r"[^\w.-]+", "_", item.nodeid)
        if kept := keep(item.funcargs["tmp_path"], item.config.getoption("--failed-pictures") / name):
            report.sections.append(("Pictures", "\n".join(map(str, kept))))
    return report


def keep(folder, to):
    """Write the EXR frames of a folder, in the order in which they were made, and their differences; returns the paths."""
    import stage

    frames = sorted(folder.rglob("*.exr"), key=lambda path: path.stat().st_mtime_ns)
    if not frames:
        return []
    shutil.rmtree(to, ignore_errors=True)  # what another run left
    to.mkdir(parents=True)
    names = ["_".join(path.relative_to(folder).with_suffix("").parts) for path in frames]
    pixels = [(name, stage.read_exr(path)[::-1, :, :3]) for name, path in zip(names, frames, strict=True)]
    kept = [_saved(to / f"{name}.png", shown) for name, shown in pixels]
    for (before, one), (after, other) in pairwise(pixels):
        if one.shape == other.shape:
            kept.append(_saved(to / f"{after}_less_{before}.png", BRIGHTER * np.abs(other - one)))
    return kept


def _saved(path, linear):
    from PIL import Image

    display = np.clip(np.nan_to_num(linear), 0.0, 1.0) ** (1 / 2.2)
    Image.fromarray((255 * display + 0.5).astype(np.uint8)).save(path)
    return path
