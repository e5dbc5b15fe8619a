# SPDX-License-Identifier: GPL-3.0-or-later
"""A session of Blender from start to end, run by `test_life.py` in a process of its own: nothing may be left behind."""

import os
import sys
import threading
import traceback

import headless
import stage
from handles import WHERE
from headless import bpy


def inventory():
    """All that an extension could leave behind in Blender or Python; the number of each."""
    names = [name for name in dir(bpy.app.handlers) if isinstance(getattr(bpy.app.handlers, name), list)]
    found: dict[str, int | list[int]] = {name: len(getattr(bpy.app.handlers, name)) for name in names}
    found["classes"] = sum(name.startswith("PRT_") for name in dir(bpy.types))
    found["operators"] = len(dir(bpy.ops.prt))
    found["properties"] = sum(hasattr(owner, "prt") for owner in (bpy.types.Scene, bpy.types.Object))
    found["presets"] = len(bpy.utils.preset_paths("prt/bake"))
    menus = (bpy.types.VIEW3D_MT_object, bpy.types.TOPBAR_MT_file_import, bpy.types.TOPBAR_MT_file_export)
    found["menu entries"] = [len(getattr(menu.draw, "_draw_funcs", [None])) for menu in menus]
    found["threads"] = threading.active_count()
    found["preferences"] = bpy.context.preferences.addons.get(headless.PACKAGE) is not None
    return found


def bake():
    """One bake in an empty file."""
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    stage.environment(stage.picture("Sky", stage.six_coloured_sky(16)))
    stage.object_of("Ball", stage.icosphere(3), stage.diffuse())
    assert bpy.ops.prt.bake(mode="SHADOWED", samples=8) == {"FINISHED"}
    assert [tree for tree in bpy.data.node_groups if "prt_version" in tree]


def long_job():
    """A bake that runs until it is stopped."""
    part = sys.modules[f"{headless.PACKAGE}.prt_addon.{WHERE['job']}"]
    read = sys.modules[f"{headless.PACKAGE}.prt_addon.{WHERE['read']}"]
    settings = sys.modules[f"{headless.PACKAGE}.prt_addon.{WHERE['problem']}"].BakeSettings(samples=1 << 18)
    job = part.bake_job(read.read_bake(bpy.context, [bpy.data.objects["Ball"]], settings).problem)
    job.start()
    return job


def main():
    """Live, and count."""
    before = inventory()
    headless.enable_extension()
    enabled = inventory()
    assert enabled["classes"] > before["classes"]
    bake()
    for _ in range(2):
        headless.disable_extension()
        assert inventory() == before, (before, inventory())
        headless.reenable_extension()
        assert inventory() == enabled, (enabled, inventory())
    bake()

    for _ in range(2):
        bpy.ops.script.reload()
        assert inventory() == enabled, (enabled, inventory())
        bake()

    job = long_job()
    assert job.running and not bpy.ops.prt.bake.poll()
    assert bpy.ops.prt.cancel() == {"FINISHED"}
    job.wait(20.0)
    job = long_job()
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)  # ends it
    assert not job.running and bpy.ops.prt.bake.poll()
    bake()

    job = long_job()
    headless.disable_extension()  # stops it
    assert not job.running
    assert inventory() == before, (before, inventory())


try:
    main()
    print("nothing was left behind", flush=True)
except BaseException:
    traceback.print_exc()
finally:
    os._exit(0)  # 4.5 as a module hangs at exit after a reload of scripts, whatever is enabled
