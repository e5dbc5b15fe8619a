# SPDX-License-Identifier: GPL-3.0-or-later
"""The documents: their links lead somewhere, their commands run, and they name what there is."""

import re
import subprocess
from pathlib import Path

import pytest

CHECKOUT = Path(__file__).resolve().parent.parent
DOCUMENTS = [CHECKOUT / "README.md", *sorted((CHECKOUT / "docs").glob("*.md"))]
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```", re.MULTILINE | re.DOTALL)


def blocks(language):
    """(document's name, code) of all fenced blocks of a language."""
    return [
        (path.name, code) for path in DOCUMENTS for kind, code in BLOCK.findall(path.read_text()) if kind == language
    ]


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.name)
def test_links_lead_somewhere(document):
    text = document.read_text()
    targets = re.findall(r"\]\(([^)#\s]+)", text) + re.findall(r'src="([^"]+)"', text)
    for target in targets:
        if "://" not in target:
            assert (document.parent / target).exists(), target


def test_make_targets_exist():
    """`make -n` prints what it would do; a target that is not there fails."""
    text = "\n".join(path.read_text() for path in DOCUMENTS)
    targets = set(re.findall(r"^make (\w+)|`make (\w+)", text, re.MULTILINE))
    assert len(targets) > 3
    for target in {one or other for one, other in targets}:
        done = subprocess.run(["make", "-n", target], cwd=CHECKOUT, capture_output=True, text=True)
        assert done.returncode == 0, (target, done.stderr)


def test_operators_are_documented(blender):
    """All that exist are named, and all that are named exist."""
    exist = set(dir(blender.ops.prt))
    named = {name for path in DOCUMENTS for name in re.findall(r"(?:`|ops\.)prt\.(\w+)[`(]", path.read_text())}
    assert named - exist == set()
    assert exist - set(re.findall(r"`prt\.(\w+)`", (CHECKOUT / "docs" / "scripting.md").read_text())) == set()


def test_python_runs(scene, stage, capsys):
    """The blocks of a document, one after the other, on a lit and finely meshed cube."""
    stage.environment(stage.picture("Sky", stage.six_coloured_sky(32)))
    for name in dict(blocks("python")):
        cube = stage.object_of("Cube", stage.icosphere(2))
        namespace = {}
        for _, code in filter(lambda block: block[0] == name, blocks("python")):
            exec(compile(code, name, "exec"), namespace)
        stage.bpy.data.objects.remove(cube)
    assert "scripting.md" in dict(blocks("python"))
    assert len(capsys.readouterr().out.split()) >= 3  # the radiance that the last block prints
