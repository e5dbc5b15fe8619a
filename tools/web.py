# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the demo's scene as a web page, and opens it in a browser where there is one.

python tools/web.py [--output FILE]
"""

from __future__ import annotations

import argparse
import webbrowser
from pathlib import Path

import demo_scene
import headless
from headless import bpy

SKIES = {"city", "night", "sunset"}


def main() -> None:
    """Build the scene, bake it, write the page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--output", type=Path, default=headless.CHECKOUT / "build" / "web" / "suzanne.html")
    output: Path = parser.parse_args().output.resolve()
    headless.enable_extension()
    try:
        bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
        demo_scene.build()
        bpy.ops.prt.bake()
        bpy.ops.prt.export_web_page(filepath=str(output), title="Suzanne", skies=SKIES)
    finally:
        headless.disable_extension()
    webbrowser.open(output.as_uri())


if __name__ == "__main__":
    main()
