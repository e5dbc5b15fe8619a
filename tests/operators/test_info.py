# SPDX-License-Identifier: GPL-3.0-or-later
"""Copy Info says what somebody who is to help must know, and not who or where one is."""

import getpass
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def test_info_holds_what_matters(blender, scene, stage, capfd):
    stage.environment(stage.picture("Sky", stage.six_coloured_sky(16)))
    stage.object_of("Secret", stage.icosphere(2), stage.diffuse())
    stage.object_of("Instances", stage.cube(), stage.diffuse()).hide_render = True
    for ob in scene.objects:
        ob.select_set(True)
    blender.ops.prt.bake(mode="SHADOWED", samples=16)
    capfd.readouterr()
    assert blender.ops.prt.copy_info() == {"FINISHED"}
    said = capfd.readouterr().out
    for wanted in (
        blender.app.version_string,
        "PRT Relight: 0.",
        "in background",
        "embreex 4",
        "samples=",
        "lamps=",
        "Light is fresh, 0 lamps",
        "1 of SHADOWED, 16 samples",
        "does not render, and is not baked",
    ):
        assert wanted in said, wanted
    assert "Secret" not in said
    assert str(ROOT) not in said and not re.search(rf"/{re.escape(getpass.getuser())}\b", said)


def test_info_of_an_empty_scene(blender, scene, capfd):
    """Of a file without a bake, that too."""
    scene.world = None
    assert blender.ops.prt.copy_info() == {"FINISHED"}
    assert "World: none" in capfd.readouterr().out


def test_issue_forms_ask_for_it():
    """By the name of the menu's entry."""
    forms = list((ROOT / ".github" / "ISSUE_TEMPLATE").glob("*.yml"))
    asking = [form.name for form in forms if "Object > PRT > Copy Info" in form.read_text()]
    assert sorted(asking) == ["bug.yml", "idea.yml"]
