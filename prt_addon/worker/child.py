# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs as the engine's process: `python -I child.py HANDLE SECONDS FOLDER...`.

HANDLE is its end of the connection to Blender, inherited; SECONDS is how long it waits for the first job. The folders hold the extension's `prt_addon`, embreex and NumPy:
they are set here because `-I` keeps out all that a user's own Python may have set up.
"""

import importlib
import sys

if __name__ == "__main__":
    sys.path.extend(sys.argv[3:])
    importlib.import_module("prt_addon.worker.serve").serve(int(sys.argv[1]), float(sys.argv[2]))
