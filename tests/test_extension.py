# SPDX-License-Identifier: GPL-3.0-or-later
"""What Blender asks of an extension: its manifest, its registration, and its interface's words."""

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
        assert sum(map(len, all_handlers(blender))) == count - 2
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


def test_every_operator_and_property_has_a_tooltip(blender, scene):
    """Nothing in the interface is left unexplained."""
    for name in (
        "bake",
        "cancel",
        "project_light",
        "add_shading",
        "remove_shading",
        "remove",
        "check",
        "report",
        "export_games202",
        "import_games202",
    ):
        rna = getattr(blender.ops.prt, name).get_rna_type()
        assert rna.description and not rna.description.endswith(".")
        for prop in rna.properties:
            assert prop.identifier == "rna_type" or prop.description, f"{name}.{prop.identifier}"
    for prop in scene.prt.bl_rna.properties:
        assert prop.identifier in {"rna_type", "name"} or prop.description
