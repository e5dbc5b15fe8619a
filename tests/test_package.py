# SPDX-License-Identifier: GPL-3.0-or-later
"""The zips that people install hold what they need, and work in a Blender that has neither embreex nor tqdm."""

import json
import os
import platform
import subprocess
import sys
import sysconfig
import tomllib
import venv
import zipfile
from pathlib import Path

import headless
import numpy as np
import package
import pytest

pytestmark = pytest.mark.slow

BUNDLED = {"embreex", "tqdm"}
MODES = ["UNSHADOWED", "SHADOWED", "INTERREFLECTED"]
VERSION = tomllib.loads((headless.CHECKOUT / "pyproject.toml").read_text())["project"]["version"]
TESTS = headless.CHECKOUT / "tests"


@pytest.fixture(scope="module")
def zips(tmp_path_factory):
    """Every zip, freshly built, by Blender's name of its platform; the one without wheels has the name ''."""
    folder = tmp_path_factory.mktemp("dist")
    subprocess.run([sys.executable, headless.CHECKOUT / "tools/package.py", "--output", folder], check=True)
    stem = f"prt_relight-{VERSION}"
    return {path.stem.removeprefix(stem).lstrip("-").replace("_", "-"): path for path in folder.iterdir()}


@pytest.fixture(scope="module")
def bare_python(tmp_path_factory):
    """An interpreter with all packages that this one has, less those that the zips bring."""
    folder = tmp_path_factory.mktemp("bare") / "venv"
    venv.create(folder, symlinks=True)
    [packages] = folder.glob("lib/python3.*/site-packages")
    for path in Path(sysconfig.get_path("purelib")).iterdir():
        if path.name.partition("-")[0].partition(".")[0] not in BUNDLED:
            (packages / path.name).symlink_to(path)
    return folder / "bin" / "python"


def install(python, zip_file, folder):
    """What installed.py finds of a zip, and all that was printed meanwhile."""
    paths = {"PYTHONPATH": os.pathsep.join(map(str, (headless.CHECKOUT / "tools", TESTS)))}
    command = [python, TESTS / "installed.py", zip_file, folder]
    done = subprocess.run(command, env=os.environ | paths, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return json.loads((folder / "found.json").read_text()), done.stdout + done.stderr


def names(zip_file):
    with zipfile.ZipFile(zip_file) as archive:
        return archive.namelist()


def test_there_is_a_zip_per_platform_and_one_for_all_others(zips):
    assert set(zips) == {*package.PLATFORMS, ""}


@pytest.mark.parametrize("where", package.PLATFORMS)
def test_a_zip_brings_the_wheels_of_its_platform(zips, where):
    """One embreex for every Python that the supported Blenders run, and tqdm; the manifest says so."""
    wheels = [name for name in names(zips[where]) if name.endswith(".whl")]
    tags = [Path(name).stem.split("-")[2:] for name in wheels if "embreex" in name]
    assert [python for python, _, _ in tags] == [abi for _, abi, _ in tags] == ["cp311", "cp313", "cp314"]
    assert all(package.PLATFORMS[where] in system for _, _, system in tags)
    assert len(wheels) == 4 and any("tqdm" in name for name in wheels)
    with zipfile.ZipFile(zips[where]) as archive:
        generated = tomllib.loads(archive.read("blender_manifest.toml").decode())["build"]["generated"]
    assert generated == {"platforms": [where], "wheels": [f"./{name}" for name in wheels]}


def test_zips_hold_the_same_extension_and_no_workshop(zips):
    """All its code, its licence and its README."""
    [contents] = {tuple(sorted(n for n in names(path) if not n.endswith(".whl"))) for path in zips.values()}
    tops = {Path(name).parts[0] for name in contents}
    assert {"LICENSE", "README.md"} < tops
    assert not tops & {"tests", "tools", "web", "docs", "farm", "build", "dist", "Makefile", "pyproject.toml"}
    assert {Path(name).suffix for name in contents} == {".py", ".md", ".toml", ".html", ""}
    for part in ("operators", "prt_addon", "ui"):
        modules = {str(path.relative_to(headless.CHECKOUT)) for path in (headless.CHECKOUT / part).rglob("*.py")}
        assert modules == {name for name in contents if name.startswith(f"{part}/") and name.endswith(".py")}
    for path in zips.values():
        with zipfile.ZipFile(path) as archive:
            manifest = tomllib.loads(archive.read("blender_manifest.toml").decode())
        assert manifest["version"] == VERSION


def test_installed_zip_brings_its_ray_caster(zips, bare_python, tmp_path, blender):
    """In a fresh profile it bakes every mode, to the bits that the checkout bakes."""
    from tests import installed

    here = {"Linux": "linux", "Windows": "windows", "Darwin": "macos"}[platform.system()]
    machine = "arm64" if platform.machine() in {"arm64", "aarch64"} else "x64"
    found, printed = install(bare_python, zips[f"{here}-{machine}"], tmp_path)
    assert found["enabled"] and found["relit"] == MODES and not found["refusals"]
    for name in BUNDLED:
        assert "prt-profile-" in found["wheels"][name] and ".local" in found["wheels"][name]
    for mode in MODES:
        assert np.array_equal(np.load(tmp_path / f"{mode}.npy"), installed.bake(f"{headless.PACKAGE}.prt_addon", mode))
    assert "Traceback" not in printed


def test_without_a_wheel_the_rest_works(zips, bare_python, tmp_path, blender):
    """Unshadowed transport, light and shading; what needs rays is refused in a sentence that says what to do."""
    from tests import installed

    found, printed = install(bare_python, zips[""], tmp_path)
    assert found["enabled"] and found["relit"] == ["UNSHADOWED"]
    assert found["wheels"] == {"embreex": None, "tqdm": None}
    assert set(found["refusals"]) == {"SHADOWED", "INTERREFLECTED"}
    assert all("embreex" in said and "Unshadowed" in said for said in found["refusals"].values())
    baked = np.load(tmp_path / "UNSHADOWED.npy")
    assert np.array_equal(baked, installed.bake(f"{headless.PACKAGE}.prt_addon", "UNSHADOWED"))
    assert "Traceback" not in printed
