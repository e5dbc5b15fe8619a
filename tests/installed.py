# SPDX-License-Identifier: GPL-3.0-or-later
"""Run by test_package.py in an interpreter of its own: installs a zip into a fresh profile, bakes, and writes what it found.

    python installed.py ZIP FOLDER

Writes FOLDER/found.json and, for every mode that could be baked, FOLDER/MODE.npy: the cube's transport.
"""

import importlib
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from handles import WHERE
from headless import bpy

PACKAGE = "bl_ext.user_default.prt_relight"


def main(zip_file: str, folder: Path) -> None:
    bpy.ops.extensions.package_install_files(filepath=zip_file, repo="user_default", enable_on_install=True)
    found: dict[str, Any] = {"enabled": PACKAGE in bpy.context.preferences.addons, "relit": [], "refusals": {}}
    try:
        for mode in ("UNSHADOWED", "SHADOWED", "INTERREFLECTED"):
            try:
                np.save(folder / f"{mode}.npy", bake(f"{PACKAGE}.prt_addon", mode))
            except RuntimeError as refusal:
                found["refusals"][mode] = str(refusal)
            if bpy.data.node_groups and "prt_light_0" in bpy.context.scene.world:
                found["relit"].append(mode)
        found["wheels"] = {name: where(name) for name in ("embreex", "tqdm")}
    finally:
        bpy.ops.preferences.addon_disable(module=PACKAGE)
    (folder / "found.json").write_text(json.dumps(found))


def bake(addon: str, mode: str) -> npt.NDArray[np.float32]:
    """Transport of a cube on a floor under the six-coloured sky; `addon` is the name of the package `prt_addon`."""
    import stage

    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    stage.environment(stage.picture("Sky", stage.six_coloured_sky(16)))
    ob = stage.object_of("Cube", stage.cube(), stage.diffuse())
    stage.object_of("Floor", stage.grid(size=4.0), location=(0.0, 0.0, -1.0))
    bpy.ops.prt.bake(mode=mode, samples=32)
    return np.asarray(importlib.import_module(f"{addon}.{WHERE['layers']}").read(ob.data))


def where(name: str) -> str | None:
    """The file a module is imported from, or None if it cannot be."""
    try:
        return importlib.import_module(name).__file__
    except ImportError:
        return None


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]))
