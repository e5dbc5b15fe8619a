# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders the course's boxes on a floor of metal: EEVEE without and with its ray tracing, and Cycles."""

from __future__ import annotations

from pathlib import Path

import boxes
import frames
import headless
from headless import bmesh, bpy
from PIL import Image

SIZE = (360, 300)
_ROUGHNESS = 0.1


def draw(folder: Path, faces: Path) -> Path:
    """Write the three side by side, and print how far EEVEE's are from Cycles'; returns the picture."""
    scene = _stage(faces)
    bpy.ops.prt.bake(mode="INTERREFLECTED", bounces=3)
    scene.prt.bounces = 3
    shots, pixels = [], []

    def shoot() -> None:
        shots.append(Image.open(frames.render(scene, folder / "mirror.png")).convert("RGB"))
        pixels.append(frames.render_linear(scene, folder / "mirror.exr"))

    shoot()
    bpy.ops.prt.add_reflections()
    shoot()
    frames.use_cycles(scene)
    shoot()
    for name in ("mirror.png", "mirror.exr"):
        (folder / name).unlink()
    errors = [frames.relative_rms(ours, pixels[-1]) for ours in pixels[:2]]
    print(f"Metal floor: {errors[0]:.1%} from Cycles without reflections, {errors[1]:.1%} with")
    frames.side_by_side(shots).save(folder / "mirror.jpg", quality=88)
    return folder / "mirror.jpg"


def _stage(faces: Path) -> bpy.types.Scene:
    """All of it selected, under the cube map, and seen from above."""
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    scene = bpy.context.scene
    boxes.build()
    _metal_floor(scene)
    bpy.ops.prt.import_cubemap(directory=str(faces))
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    scene.collection.objects.link(camera)
    camera.location, camera.rotation_euler, camera.data.lens = (1.5, -4.6, 2.0), (1.25, 0.0, 0.31), 42.0
    scene.camera = camera
    scene.render.resolution_x, scene.render.resolution_y = SIZE
    scene.view_settings.view_transform = "Standard"
    frames.set_up_render(scene)
    scene.render.resolution_percentage = 100
    scene.eevee.taa_render_samples = 16
    return scene


def _metal_floor(scene: bpy.types.Scene) -> None:
    """A hair above the boxes' own floor."""
    mesh = bpy.data.meshes.new("Metal")
    bm = bmesh.new()
    bmesh.ops.create_grid(bm, x_segments=60, y_segments=60, size=1.8)
    bm.to_mesh(mesh)
    bm.free()
    floor = bpy.data.objects.new("Metal", mesh)
    floor.location.z = 0.01
    scene.collection.objects.link(floor)
    floor.select_set(True)
    material = bpy.data.materials.new("Metal")
    headless.use_nodes(material)
    shader = material.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (0.8, 0.8, 0.8, 1.0)
    shader.inputs["Metallic"].default_value, shader.inputs["Roughness"].default_value = 1.0, _ROUGHNESS
    mesh.materials.append(material)
