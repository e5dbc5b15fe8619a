# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside a Blender, with or without the extension: turns the world and renders EEVEE frames of an open file.

    blender -b FILE.blend --python frames.py -- STEM

Writes STEM_0.png and STEM_90.png.
"""

import math
import sys

import bpy

stem = sys.argv[sys.argv.index("--") + 1]
scene = bpy.context.scene
[mapping] = [node for node in scene.world.node_tree.nodes if node.bl_idname == "ShaderNodeMapping"]
for degrees in (0, 90):
    mapping.inputs["Rotation"].default_value[2] = math.radians(degrees)
    scene.render.filepath = f"{stem}_{degrees}.png"
    bpy.ops.render.render(write_still=True)
print("relit by the extension" if hasattr(scene, "prt") else "relit without the extension")
