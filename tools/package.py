# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds the zips that people install, by Blender's own build tool.

    python tools/package.py [--output FOLDER]

One zip per platform, with the wheels of `wheels.txt`, and one without wheels for every other platform or Python: Blender
refuses an extension none of whose wheels fits. Nothing but the wheels is fetched, and only those with the right hashes.
"""

from __future__ import annotations

import argparse
import hashlib
import importlib.util
import json
import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

CHECKOUT = Path(__file__).resolve().parent.parent
REQUIREMENTS = CHECKOUT / "tools" / "wheels.txt"
WHEELS = CHECKOUT / "build" / "wheels"
STAGE = CHECKOUT / "build" / "package"

# Blender's name of a platform, and the tag of its wheels.
PLATFORMS = {
    "linux-x64": "manylinux_2_28_x86_64",
    "windows-x64": "win_amd64",
    "macos-arm64": "macosx_13_0_arm64",
    "macos-x64": "macosx_13_0_x86_64",  # until 4.5 LTS, the last Blender for it, is out of support
}
PYTHONS = ("3.11", "3.13", "3.14")  # Blender 4.5 and 5.0; 5.1 and 5.2; 5.2 as Linux distributions build it


def main() -> None:
    """Build all zips and print their sizes."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--output", type=Path, default=CHECKOUT / "dist")
    output: Path = parser.parse_args().output.resolve()
    for path in build(output):
        print(f"{path.stat().st_size / 1e6:6.1f} MB  {path.name}")


def build(output: Path) -> list[Path]:
    """Build and validate every zip into a folder, which holds nothing else of this extension afterwards."""
    fetch_wheels()
    output.mkdir(parents=True, exist_ok=True)
    for old in output.glob("prt_relight-*.zip"):
        old.unlink()
    blender_extension("build", "--source-dir", CHECKOUT, "--output-dir", output)
    [without_wheels] = output.glob("prt_relight-*.zip")
    stage_with_wheels(without_wheels)
    blender_extension("build", "--source-dir", STAGE, "--output-dir", output, "--split-platforms")
    zips = sorted(output.glob("prt_relight-*.zip"))
    for path in zips:
        blender_extension("validate", path)
    return zips


def fetch_wheels() -> None:
    """Let pip download what is missing: the folder then holds the wheels of `wheels.txt` and no others."""
    wanted = set(re.findall(r"sha256:(\w{64})", REQUIREMENTS.read_text()))
    if digests(WHEELS) == wanted:
        return
    shutil.rmtree(WHEELS, ignore_errors=True)
    for platform in PLATFORMS.values():
        for python in PYTHONS:
            pip_download(platform, python)
    if digests(WHEELS) != wanted:
        sys.exit(f"{REQUIREMENTS.name} lists other wheels than those of {', '.join(PLATFORMS)}: bring them together.")


def pip_download(platform: str, python: str) -> None:
    """The wheels for a platform and a Python, their hashes checked."""
    target = ("--platform", platform, "--python-version", python, "--implementation", "cp", "--only-binary=:all:")
    command = (sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--require-hashes", *target)
    if subprocess.run((*command, "--dest", WHEELS, "--requirement", REQUIREMENTS)).returncode:
        sys.exit(f"The wheels for {platform}, Python {python}, could not be fetched: pip says why above.")


def digests(folder: Path) -> set[str]:
    """SHA-256 of the files in a folder."""
    return {hashlib.sha256(path.read_bytes()).hexdigest() for path in folder.glob("*")}


def stage_with_wheels(without_wheels: Path) -> None:
    """What the zip holds, plus the wheels and a manifest that names them."""
    shutil.rmtree(STAGE, ignore_errors=True)
    with zipfile.ZipFile(without_wheels) as archive:
        archive.extractall(STAGE)
    shutil.copytree(WHEELS, STAGE / "wheels")
    names = [f"./wheels/{path.name}" for path in sorted(WHEELS.iterdir())]
    manifest = STAGE / "blender_manifest.toml"
    lists = f"platforms = {json.dumps(list(PLATFORMS))}\nwheels = {json.dumps(names, indent=2)}\n\n"
    manifest.write_text(lists + manifest.read_text())  # in front: behind, they would belong to the last table


def blender_extension(*arguments: object) -> None:
    """Run Blender's command line tool for extensions, which comes with bpy and runs without Blender."""
    spec = importlib.util.find_spec("bpy")
    if spec is None or spec.origin is None:
        sys.exit("bpy is not installed: its build tool makes the zips.")
    [tool] = Path(spec.origin).parent.glob("*/scripts/addons_core/bl_pkg/cli/blender_ext.py")
    done = subprocess.run([sys.executable, tool, *map(str, arguments)], capture_output=True, text=True)
    if done.returncode:
        sys.exit(done.stdout + done.stderr)


if __name__ == "__main__":
    main()
