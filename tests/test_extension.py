# SPDX-License-Identifier: GPL-3.0-or-later
"""The manifest and the registration are what Blender requires of an extension."""

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

    before = own_handlers(blender)
    assert before
    for _ in range(2):
        with headless.extension_disabled():
            assert not own_handlers(blender)
            assert not hasattr(blender.types.Scene, "prt")
            assert not hasattr(blender.types, "PRT_PT_bake")
        assert hasattr(blender.types.Scene, "prt")
        assert own_handlers(blender) == before


def own_handlers(bpy):
    """The extension's handlers as sorted pairs of a list's name and a function's."""
    import headless

    lists = {name: getattr(bpy.app.handlers, name) for name in dir(bpy.app.handlers)}
    return sorted(
        (name, handler.__qualname__)
        for name, handlers in lists.items()
        if isinstance(handlers, list)
        for handler in handlers
        if handler.__module__.startswith(headless.PACKAGE)
    )
