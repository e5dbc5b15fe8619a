# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside Blender and saves the file that the acceptance suite works on: Suzanne on a floor, under an HDRI.

    blender -b --python scene.py -- FILE.blend

Built by hand from Blender's own start-up file, as a user would, so that its window is the one people know.
"""

import sys
from pathlib import Path

import bpy


def build() -> None:
    """Build the scene in place of what is there."""
    bpy.ops.object.select_all(action="SELECT")
    bpy.ops.object.delete()
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=120, y_subdivisions=120, size=6.0, location=(0.0, 0.0, -0.9))
    give_material("Floor", (0.8, 0.8, 0.8))
    bpy.ops.mesh.primitive_monkey_add(rotation=(-0.6, 0.0, 0.0))
    subdivision = bpy.context.object.modifiers.new("Subdivision", "SUBSURF")
    subdivision.levels, subdivision.render_levels = 2, 3  # it stays live: the bake lies on a carrier
    bpy.ops.object.shade_smooth()
    give_material("Clay", (0.75, 0.28, 0.12))
    bpy.ops.object.camera_add(location=(3.0, -7.0, 3.4), rotation=(1.17, 0.0, 0.4))
    scene = bpy.context.scene
    scene.camera = bpy.context.object
    bpy.ops.object.select_all(action="DESELECT")
    bpy.context.view_layer.objects.active = bpy.data.objects["Suzanne"]
    tree = scene.world.node_tree
    texture = tree.nodes.new("ShaderNodeTexEnvironment")
    folder = Path(bpy.utils.system_resource("DATAFILES", path="studiolights/world"))
    texture.image = bpy.data.images.load(str(folder / "courtyard.exr"))
    tree.links.new(texture.outputs["Color"], tree.nodes["Background"].inputs["Color"])
    scene.render.resolution_x, scene.render.resolution_y = 320, 240
    scene.eevee.taa_render_samples = scene.eevee.taa_samples = 1
    scene.render.preview_pixel_size = "4"  # software rendering takes its time
    scene.render.threads_mode, scene.render.threads = "FIXED", 2  # or there is no time to stop a bake
    scene.frame_end = 400  # or there is no time to stop Keyframe Light
    scene.prt.mode, scene.prt.samples = "SHADOWED", 1024


def give_material(name: str, colour: tuple[float, float, float]) -> None:
    """Give the active object a material of its own."""
    material = bpy.data.materials.new(name)
    material.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (*colour, 1.0)
    bpy.context.object.data.materials.append(material)


if __name__ == "__main__":
    build()
    bpy.ops.wm.save_as_mainfile(filepath=sys.argv[sys.argv.index("--") + 1])
