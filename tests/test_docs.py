# SPDX-License-Identifier: GPL-3.0-or-later
"""The documents' links lead somewhere, their commands run, and what they name or quote is there."""

import ast
import re
import subprocess
import sys
import textwrap
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

pytestmark = pytest.mark.once

CHECKOUT = Path(__file__).resolve().parent.parent
DOCUMENTS = [*sorted(CHECKOUT.glob("*.md")), *sorted((CHECKOUT / "docs").glob("*.md"))]
BLOCK = re.compile(r"^ *```(\w+)\n(.*?)^ *```", re.MULTILINE | re.DOTALL)
FACES = ("posx", "negx", "posy", "negy", "posz", "negz")


def blocks(language):
    """(document's name, code) of all fenced blocks of a language."""
    found = [(path.name, *block) for path in DOCUMENTS for block in BLOCK.findall(path.read_text())]
    return [(name, textwrap.dedent(code)) for name, kind, code in found if kind == language]


@pytest.fixture
def desk(scene, stage, tmp_path):
    """What the documents speak of: a saved file with a lit and selected cube, and a cube map beside it."""
    stage.environment(stage.picture("Sky", stage.six_coloured_sky(32)))
    cube = stage.object_of("Cube", stage.icosphere(2))
    cube.select_set(True)
    stage.bpy.context.view_layer.objects.active = cube
    faces = tmp_path / "cubemap" / "CornellBox"
    faces.mkdir(parents=True)
    for number, face in enumerate(FACES):
        Image.fromarray(np.full((8, 8, 3), 40 * number, dtype=np.uint8)).save(faces / f"{face}.jpg")
    stage.bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "file.blend"))
    return tmp_path


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.name)
def test_links_lead_somewhere(document):
    text = document.read_text()
    targets = re.findall(r"\]\(([^)#\s]+)", text) + re.findall(r'src="([^"]+)"', text)
    for target in targets:
        if "://" not in target:
            assert (document.parent / target).exists(), target


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.name)
def test_files_that_are_named_are_there(document):
    """Parts of the extension are named from `prt_addon`, all others from the checkout."""
    text = document.read_text()
    for name in re.findall(r"`((?:core|scene|worker|operators|ui|tests|tools|web|farm)/[\w./-]+)`", text):
        assert (CHECKOUT / name).exists() or (CHECKOUT / "prt_addon" / name).exists(), name


def test_make_targets_exist():
    """`make -n` prints what it would do; a target that is not there fails."""
    text = "\n".join([code for _, code in blocks("sh")] + [path.read_text() for path in DOCUMENTS])
    targets = set(re.findall(r"^make (\w+) *(?:#|$)|`make (\w+)", text, re.MULTILINE))
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


@pytest.mark.parametrize("document", dict(blocks("python")))
def test_python_runs(desk, document):
    """The blocks of a document, one after the other."""
    namespace: dict[str, Any] = {}
    for name, code in blocks("python"):
        if name == document:
            exec(compile(code, name, "exec"), namespace)
    if document == "scripting.md":
        assert (namespace["radiance"] > 0.0).all()
    if document == "formats.md":
        assert {"light.txt", "transport.txt"} <= {path.name for path in (desk / "cubemap" / "CornellBox").iterdir()}


@pytest.mark.parametrize("document", [name for name, code in dict(blocks("sh")).items() if "blender -b" in code])
def test_commands_run(desk, document):
    """Command lines of Blender, one after the other, in background; one shard instead of eight."""
    blender = f'blender() {{ "{sys.executable}" "{Path(__file__).with_name("background_blender.py")}" "$@"; }}'
    for name, code in blocks("sh"):
        if name == document and code.startswith("blender"):
            code = code.replace("/shared/shards", str(desk / "shards")).replace("count=8", "count=1")
            done = subprocess.run(["bash", "-c", f"{blender}\n{code}"], cwd=desk, capture_output=True, text=True)
            assert done.returncode == 0, done.stdout + done.stderr
    assert (desk / "file.blend1").exists()  # the last one saved the file


def sentences_of(source):
    """What stands between the values in all texts of a module."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield from re.split(r"\{\w+\}", node.value)


def quoted(document):
    """What documents quote of messages, without the names and numbers in them."""
    text = (CHECKOUT / "docs" / document).read_text()
    if document == "survey.md":
        said = [line.rstrip(" |").rpartition("| ")[2] for line in text.splitlines() if line.startswith("| ")][2:]
        said = [line for line in said if not line.startswith("Error:")]  # Blender's own
        parts = [part for line in said for part in re.split(r"'[^']*'|[\d%]+|\. |[():;]", line)]
        return {part.strip(" .,") for part in parts if part.count(" ") > 6}
    return {part.strip(" .") for part in re.findall(r'"([^"\n]{12,})"', text)}


@pytest.mark.parametrize("document", ["survey.md", "troubleshooting.md"])
def test_messages_are_quoted_as_they_are(document):
    """No wording of an earlier version."""
    paths = [path for part in ("prt_addon", "operators", "ui") for path in (CHECKOUT / part).rglob("*.py")]
    source = "\n".join(sentence for path in paths for sentence in sentences_of(path.read_text(encoding="utf-8")))
    found = quoted(document)
    assert len(found) > 3
    assert [part for part in found if part not in source] == []


def test_changes_are_written_down_for_this_version():
    """The newest entry is the version that the manifest names."""
    entries = re.findall(r"^## (\S+)$", (CHECKOUT / "CHANGELOG.md").read_text(), re.MULTILINE)
    manifest = tomllib.loads((CHECKOUT / "blender_manifest.toml").read_text())
    assert entries[0] == manifest["version"] and entries == sorted(entries, reverse=True)
