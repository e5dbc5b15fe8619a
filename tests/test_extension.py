# SPDX-License-Identifier: GPL-3.0-or-later
"""What Blender asks of an extension: its manifest, and its registration."""

import subprocess
import sys
from pathlib import Path


def test_manifest_is_valid(blender):
    """Blender's own validator accepts the checkout."""
    import headless

    tool = Path(blender.utils.resource_path("LOCAL")) / "scripts/addons_core/bl_pkg/cli/blender_ext.py"
    answer = subprocess.run([sys.executable, tool, "validate", headless.CHECKOUT], capture_output=True, text=True)
    assert answer.returncode == 0, answer.stdout + answer.stderr


def test_enables_and_disables_again_and_again(blender):
    """No class, property or handler is left behind, nor missed."""
    import headless

    count = sum(map(len, all_handlers(blender)))
    for _ in range(2):
        headless.disable_extension()
        assert sum(map(len, all_handlers(blender))) == count - 7
        assert not hasattr(blender.types.Scene, "prt")
        assert not hasattr(blender.types, "PRT_PT_bake")
        headless.reenable_extension()
        assert hasattr(blender.types.Scene, "prt")
        assert sum(map(len, all_handlers(blender))) == count


def all_handlers(bpy):
    """Every list of handlers that Blender has."""
    return [
        getattr(bpy.app.handlers, name)
        for name in dir(bpy.app.handlers)
        if isinstance(getattr(bpy.app.handlers, name), list)
    ]
