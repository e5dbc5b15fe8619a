# SPDX-License-Identifier: GPL-3.0-or-later
"""Reports of few points, which take a moment."""

import json

import pytest

FEW = {"points": 64, "paths": 32}


@pytest.fixture
def report(blender, scene, tmp_path):
    """Run it and read what it wrote."""

    def run(**options):
        path = tmp_path / "report.json"
        path.unlink(missing_ok=True)
        assert blender.ops.prt.report(filepath=str(path), **{**FEW, **options}) == {"FINISHED"}
        document = json.loads(path.read_text())
        assert json.loads(scene["prt_report"]) == document
        return document

    return run
