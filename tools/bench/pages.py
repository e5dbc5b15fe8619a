# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws a page with the benchmark's scene, by software in a real browser."""

from __future__ import annotations

import json
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import Any

import blender_scene
import headless
from headless import bpy

_BROWSERS = ("chromium", "chromium-browser", "google-chrome")


def page_frames(vertices: int) -> dict[str, Any]:
    """Seconds of a frame while the camera moves and while the sky turns. Needs `headless`' extension, Chromium and Node."""
    browser = next(filter(None, map(shutil.which, _BROWSERS)), None)
    if browser is None or not (headless.CHECKOUT / "web" / "node_modules").is_dir():
        raise RuntimeError("Chromium or the web's packages are missing: run make web first.")
    blender_scene.court(vertices)
    world = bpy.data.worlds.new("Sky")
    bpy.context.scene.world = world
    headless.use_nodes(world)
    bpy.ops.prt.bake(mode="SHADOWED", samples=16)
    with tempfile.TemporaryDirectory(prefix="prt-bench-") as folder:
        page = Path(folder) / "page.html"
        bpy.ops.prt.export_web_page(filepath=str(page), still=False)
        command = ["node", str(Path(__file__).with_name("page_frames.mjs")), str(page), browser]
        return {"vertices": vertices, **json.loads(subprocess.check_output(command, text=True))}
