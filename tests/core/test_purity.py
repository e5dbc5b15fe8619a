# SPDX-License-Identifier: GPL-3.0-or-later
"""The engine never imports Blender."""

import ast
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
CORE = ROOT / "prt_addon" / "core"
MODULES = sorted(CORE.rglob("*.py"))
FORBIDDEN = {"bpy", "bpy_extras", "bmesh", "mathutils", "gpu", "gpu_extras"}


def imported(source):
    """First names of all absolute imports, those inside functions too."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            yield from (alias.name.split(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and not node.level:
            yield node.module.split(".")[0]


def climbs_out(source, depth=0):
    """Relative imports that leave core, of a module so many folders below it."""
    return [node for node in ast.walk(ast.parse(source)) if isinstance(node, ast.ImportFrom) and node.level > 1 + depth]


def test_the_check_itself():
    """It sees what it forbids."""
    source = "import bpy.types as t\ndef f():\n    from gpu import state\nfrom . import sh"
    assert set(imported(source)) == {"bpy", "gpu"}
    assert climbs_out("from ..scene import meshes") and not climbs_out("from .sh import basis")
    assert {path.stem for path in MODULES} >= {
        "sh",
        "rotation",
        "directions",
        "projection",
        "raycast",
        "direct",
        "bake",
    }


@pytest.mark.parametrize("path", MODULES, ids=lambda path: path.stem)
def test_no_blender_in_the_engine(path):
    """No module of Blender's, nor the parts of the extension that use them."""
    source = path.read_text(encoding="utf-8")
    assert not FORBIDDEN & set(imported(source))
    assert not climbs_out(source, len(path.relative_to(CORE).parts) - 1)


def test_importing_the_engine_leaves_blender_out():
    """Not through a third module either."""
    paths = [path.relative_to(ROOT).with_suffix("") for path in MODULES if path.stem != "__init__"]
    names = [".".join(path.parts) for path in paths]
    code = f"import sys, {', '.join(names)}; print(sorted({FORBIDDEN!r} & sys.modules.keys()))"
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    answer = subprocess.run(
        [sys.executable, "-c", code], env=environment, cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert (answer.returncode, answer.stdout.strip()) == (0, "[]"), answer.stderr
