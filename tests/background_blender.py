# SPDX-License-Identifier: GPL-3.0-or-later
"""Stands in for `blender -b` on a command line: the same Blender as a Python module, with this checkout enabled.

It is not the application. It understands the few arguments below, in the order they come, as Blender does: the file is
opened when it is met, `--python-exit-code` holds for the Python that comes after it, and `--` ends all that.
"""

from __future__ import annotations

import os
import sys
import traceback
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tools"))
import headless


def main(arguments: list[str]) -> int:
    """Do what the arguments say, one after the other; returns the exit code."""
    exit_code = 0
    waiting = iter(arguments)
    for argument in waiting:
        if argument == "--":
            break
        if argument in {"-b", "--background", "-y", "--enable-autoexec"}:
            continue  # the module is always in background
        if argument in {"-t", "--threads"}:
            next(waiting)  # the bits are the same on any number
            continue
        if argument == "--python-exit-code":
            exit_code = int(next(waiting))
        elif argument in {"--python-expr", "--python", "-P"}:
            code, name = next(waiting), "<python-expr>"
            if argument != "--python-expr":
                code, name = Path(code).read_text(), code
            try:
                exec(compile(code, name, "exec"), {"__name__": "__main__"})
            except Exception:
                traceback.print_exc()
                if exit_code:
                    return exit_code
        elif argument.startswith("-"):
            sys.exit(f"unknown argument {argument}")
        else:
            headless.bpy.ops.wm.open_mainfile(filepath=argument)
            print(f"Read blend: {argument}", flush=True)
    return 0


if __name__ == "__main__":
    headless.enable_extension()
    try:
        code = main(sys.argv[1:])
    finally:
        headless.disable_extension()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)  # bpy's own teardown is not what is tested
