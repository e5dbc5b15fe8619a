# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside Blender: gives an open, baked file all that the panels show only now and then, in many words.

    blender -b BAKED.blend --python full.py -- FILE.blend

A report of every part, a bake and a light that are stale, and the settings that only some choices have.
"""

import sys
from pathlib import Path

import bpy

path = Path(sys.argv[sys.argv.index("--") + 1])
scene = bpy.context.scene
bpy.data.objects["Suzanne"].location.z += 0.1
every = {item.identifier for item in bpy.ops.prt.report.get_rna_type().properties["parts"].enum_items}
bpy.ops.prt.report(parts=every, points=64, paths=64, picture_size=64, picture_samples=4)
scene.prt.mode, scene.prt.window, scene.prt.auto_light = "INTERREFLECTED", "HANN", False
[texture] = [node for node in scene.world.node_tree.nodes if node.bl_idname == "ShaderNodeTexEnvironment"]
texture.image = bpy.data.images.load(str(Path(bpy.path.abspath(texture.image.filepath)).with_name("forest.exr")))
bpy.ops.wm.save_as_mainfile(filepath=str(path))
