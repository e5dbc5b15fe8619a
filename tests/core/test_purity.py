# SPDX-License-Identifier: GPL-3.0-or-later
"""The engine knows nothing of Blender."""

import ast
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
MODULES = sorted((ROOT / "prt_addon" / "core").rglob("*.py"))
FORBIDDEN = {"bpy", "bpy_extras", "bmesh", "mathutils", "gpu", "gpu_extras"}


def imported(source):
    """First names of all absolute imports, those inside functions too."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            yield from (alias.name.split(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and not node.level:
            yield node.module.split(".")[0]


def climbs_out(source):
    """Relative imports that leave core."""
    return [node for node in ast.walk(ast.parse(source)) if isinstance(node, ast.ImportFrom) and node.level > 1]


def test_the_check_itself():
    """It sees what it forbids."""
    source = "import bpy.types as t\ndef f():\n    from gpu import state\nfrom . import sh"
    assert set(imported(source)) == {"bpy", "gpu"}
    assert climbs_out("from ..scene import meshes") and not climbs_out("from .sh import basis")
    assert {path.stem for path in MODULES} >= {"sh", "rotation", "sampling", "envmap", "raycast", "transport", "bake"}


@pytest.mark.parametrize("path", MODULES, ids=lambda path: path.stem)
def test_no_blender_in_the_engine(path):
    """No module of Blender's, nor the parts of the extension that use them."""
    source = path.read_text(encoding="utf-8")
    assert not FORBIDDEN & set(imported(source))
    assert not climbs_out(source)


def test_importing_the_engine_leaves_blender_out():
    """Not through a third module either."""
    names = [f"prt_addon.core.{path.stem}" for path in MODULES if path.stem != "__init__"]
    code = f"import sys, {', '.join(names)}; print(sorted({FORBIDDEN!r} & sys.modules.keys()))"
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    answer = subprocess.run(
        [sys.executable, "-c", code], env=environment, cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert (answer.returncode, answer.stdout.strip()) == (0, "[]"), answer.stderr
