# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside Blender's window: disables the extension, as Preferences do, once a bake is a little way."""

import importlib

import bpy

PACKAGE = "bl_ext.user_default.prt_relight"


def disable() -> float | None:
    """Disable it once a tenth of the bake is done; as a timer of Blender's."""
    job = importlib.import_module(f"{PACKAGE}.prt_addon.worker.job").running_job()
    if not job or job.progress < 0.1:
        return 0.1
    return bpy.ops.preferences.addon_disable(module=PACKAGE) and None


if __name__ == "__main__":
    bpy.app.timers.register(disable, persistent=True)
