# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside Blender's window and writes, a few times a second, what the acceptance suite looks at. Touches nothing.

blender FILE --python watch.py -- STATE.json
"""

import hashlib
import importlib
import json
import sys
import time
from pathlib import Path
from typing import Any

import bpy
import numpy as np

PACKAGE = "bl_ext.user_default.prt_relight"


def state() -> dict[str, Any]:
    """What is open, where the sidebar is, how far a bake is, and what is in the file."""
    window = bpy.context.window_manager.windows[0]
    [area] = [area for area in window.screen.areas if area.type == "VIEW_3D"]
    regions = {region.type: region for region in area.regions}
    sidebar = regions["UI"]
    job = importlib.import_module(f"{PACKAGE}.prt_addon.worker.job").running_job()
    session = importlib.import_module(f"{PACKAGE}.prt_addon.session").session
    mapping = [node for node in bpy.context.scene.world.node_tree.nodes if node.bl_idname == "ShaderNodeMapping"]
    return {
        "time": time.time(),
        "file": bpy.data.filepath,
        "enabled": hasattr(bpy.types.Scene, "prt"),
        "saved": not bpy.data.is_dirty,
        "shading": area.spaces.active.shading.type,
        "view": box(regions["WINDOW"], window),
        "header": box(regions["HEADER"], window),
        "sidebar": box(sidebar, window) if sidebar.width > 1 else None,
        "tab": sidebar.active_panel_category if sidebar.width > 1 else None,
        "folded": [panel.bl_label for panel in in_sidebar() if "DEFAULT_CLOSED" in getattr(panel, "bl_options", ())],
        "row": 20 * bpy.context.preferences.system.ui_scale,
        "progress": job.progress if job else None,
        "busy": session.timer is not None,
        "previews": previews(),
        "frame": bpy.context.scene.frame_current,
        "keyframes": keyframes(),
        "baked": sum("_PRT_8" in mesh.attributes for mesh in bpy.data.meshes),
        "reported": "prt_report" in bpy.context.scene,
        "content": content(),
        "turn": list(mapping[0].inputs["Rotation"].default_value) if mapping else None,
    }


def previews() -> list[int]:
    """How many meshes show one, and of how many rays each."""
    records = [mesh.get("prt_bake", {}) for mesh in bpy.data.meshes]
    return [record["samples"] for record in records if "preview_of" in record]


def keyframes() -> int:
    """Frames from the first keyframe of the world to the last."""
    action = getattr(bpy.context.scene.world.animation_data, "action", None)
    return int(action.frame_range[1] - action.frame_range[0] + 1) if action else 0


def in_sidebar() -> list[type[bpy.types.Panel]]:
    """The extension's panels there."""
    ours = [panel for panel in bpy.types.Panel.__subclasses__() if panel.__module__.startswith(PACKAGE)]
    return [panel for panel in ours if panel.bl_space_type == "VIEW_3D"]


def box(region: bpy.types.Region, window: bpy.types.Window) -> tuple[int, int, int, int]:
    """Left, top, width, height in pixels of the screen, whose y points down."""
    return region.x, window.height - region.y - region.height, region.width, region.height


def content() -> list[str]:
    """All that a bake may touch, a line each: meshes and their attributes, materials' nodes, the world's properties.

    Not Blender's own attributes, which begin with a dot: selections and the like come and go; nor materials without users,
    which no file keeps.
    """
    lines = []
    for mesh in bpy.data.meshes:
        points = np.empty(len(mesh.vertices) * 3, dtype=np.float32)
        mesh.vertices.foreach_get("co", points)
        shape = hashlib.sha256(points.tobytes()).hexdigest()[:16]
        attributes = sorted(layer.name for layer in mesh.attributes if not layer.name.startswith("."))
        lines.append(f"{mesh.name}: {shape}, {attributes}, {sorted(mesh.keys())}")
    for material in filter(lambda material: material.users, bpy.data.materials):
        lines.append(f"{material.name}: {sorted(material.node_tree.nodes.keys())}")
    for world in bpy.data.worlds:
        lines.append(f"{world.name}: {sorted(world.keys())}, {sorted(world.node_tree.nodes.keys())}")
    return lines


def write_state(path: Path) -> float:
    """Write what Blender shows now; as a timer of Blender's."""
    new = path.with_suffix(".new")
    new.write_text(json.dumps(state()))
    new.replace(path)  # at once: a reader sees the old or the new, never a half
    return 0.25


if __name__ == "__main__":
    output = Path(sys.argv[sys.argv.index("--") + 1])
    bpy.app.timers.register(lambda: write_state(output), first_interval=1.0, persistent=True)
