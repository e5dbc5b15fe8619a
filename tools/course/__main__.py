# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the GAMES202 course's homework: its files and its pictures, from a figure under a cube map and from rough metal.

    python tools/course [--output FOLDER] [--pictures FOLDER]

Writes the cube map, figure.obj, and for each mode light.txt, transport.txt and PRT_<mode>_<cube map>.png into the output
(build/course), boxes.obj and its files, boxes on metal, the tables and spheres of rough metal, and the pages docs/examples/games202, which
show all of that in a browser; the pictures into docs/pictures/course, too.
"""

from __future__ import annotations

import argparse
import math
import shutil
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT), str(ROOT / "tools")]

import boxes  # noqa: E402 - these need the path
import cube_map  # noqa: E402
import energy  # noqa: E402
import figure  # noqa: E402
import frames  # noqa: E402
import headless  # noqa: E402
import mirror  # noqa: E402
from headless import bpy  # noqa: E402
from PIL import Image  # noqa: E402
from tqdm import tqdm  # noqa: E402

SKY = "Forest"
MODES = {"UNSHADOWED": "Unshadowed", "SHADOWED": "Shadowed", "INTERREFLECTED": "InterRef"}
BOUNCES = 1
"""As in the course's own settings."""
PARTS = ("T0", "T1", "T2", "T3", "BAND1", "BAND2")
"""Of transport, that are shown by themselves."""
SIZE = (400, 480)
TURN_FRAMES = 18
TURN_WIDTH = 150


def main() -> None:
    """Make everything and say what came out."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--output", type=Path, default=ROOT / "build" / "course")
    parser.add_argument("--pictures", type=Path, default=ROOT / "docs" / "pictures" / "course")
    arguments = parser.parse_args()
    output: Path = arguments.output.resolve()
    headless.enable_extension()
    try:
        made = homework(output) + energy.draw(output)
        write_boxes(output)
        made.append(mirror.draw(output, output / "cubemap" / SKY))
    finally:
        headless.disable_extension()
    shutil.copytree(ROOT / "docs" / "examples" / "games202", output, dirs_exist_ok=True)
    arguments.pictures.mkdir(parents=True, exist_ok=True)
    for path in made:
        shutil.copy(path, arguments.pictures)
    print(f"Everything is in {output}, the pictures in {arguments.pictures}, too. In a browser:")
    print(f"  python3 -m http.server --bind 127.0.0.1 --directory {output}")


def homework(output: Path) -> list[Path]:
    """The figure in three modes, and turning; returns the pictures."""
    scene = set_stage(output)
    made = []
    for mode, name in MODES.items():
        scene.prt.mode = mode
        bpy.ops.prt.bake()
        folder = output / name
        folder.mkdir(exist_ok=True)
        bpy.ops.prt.export_games202(directory=str(folder))
        made.append(small(frames.render(scene, folder / f"PRT_{name}_{SKY}.png")))
        print(f"{name}: {error(scene, output):.1%} from Cycles (relative RMS in linear light, equally many bounces)")
    made += [turning(scene, output), transport(scene, output)]
    return made


def set_stage(output: Path) -> bpy.types.Scene:
    """The figure under the cube map, seen by a camera; figure.obj and the faces are written."""
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    faces = output / "cubemap" / SKY
    cube_map.write_faces(headless.studio_hdri(SKY.lower()), faces)
    figure.build()
    bpy.ops.wm.obj_export(
        filepath=str(output / "figure.obj"), export_selected_objects=True, export_materials=False, export_uv=False
    )
    bpy.ops.prt.import_cubemap(directory=str(faces))
    scene = bpy.context.scene
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    scene.collection.objects.link(camera)
    camera.location, camera.rotation_euler, camera.data.lens = (1.9, -5.2, 2.0), (1.39, 0.0, 0.35), 75.0
    scene.camera = camera
    scene.render.resolution_x, scene.render.resolution_y = SIZE
    scene.view_settings.view_transform = "Standard"
    scene.prt.bounces = BOUNCES
    frames.set_up_render(scene)
    scene.render.resolution_percentage = 100
    return scene


def write_boxes(output: Path) -> None:
    """What the page of reflections shows: boxes.obj, and its transport without bounces, under the same cube map."""
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    boxes.build()
    bpy.ops.wm.obj_export(
        filepath=str(output / "boxes.obj"),
        export_selected_objects=True,
        export_materials=False,
        export_uv=False,
        export_colors=True,
    )
    bpy.ops.prt.import_cubemap(directory=str(output / "cubemap" / SKY))
    bpy.ops.prt.bake(mode="SHADOWED")
    (output / "Boxes").mkdir(exist_ok=True)
    bpy.ops.prt.export_games202(directory=str(output / "Boxes"))


def error(scene: bpy.types.Scene, work: Path) -> float:
    """How far EEVEE's picture is from Cycles' with as many bounces; the engine is put back."""
    ours = frames.render_linear(scene, work / "eevee.exr")
    frames.use_cycles(scene)
    truth = frames.render_linear(scene, work / "cycles.exr")
    scene.render.engine = headless.eevee_engine()
    return frames.relative_rms(ours, truth)


def turning(scene: bpy.types.Scene, output: Path) -> Path:
    """A full turn of the sky as a film."""
    rotation, shots = frames.turning_rotation(scene), []
    for number in tqdm(range(TURN_FRAMES), desc="Turn", unit="frame", file=sys.stdout):
        rotation[2] = 2.0 * math.pi * number / TURN_FRAMES
        path = frames.render(scene, output / "turning.png")
        shot = Image.open(path).convert("RGB").resize((TURN_WIDTH, TURN_WIDTH * SIZE[1] // SIZE[0]))
        shots.append(shot.quantize(24, dither=Image.Dither.NONE))
    path.unlink()
    rotation[2] = 0.0
    frames.save_gif(output / f"PRT_Rotation_{SKY}.gif", shots)
    return output / f"PRT_Rotation_{SKY}.gif"


def transport(scene: bpy.types.Scene, output: Path) -> Path:
    """The coefficients themselves, as views in Solid shading show them."""
    scene.render.engine, scene.render.resolution_percentage = "BLENDER_WORKBENCH", 50
    scene.display.shading.light, scene.display.shading.color_type = "FLAT", "VERTEX"
    shots = []
    for part in PARTS:
        bpy.ops.prt.show_transport(part=part)
        shots.append(Image.open(frames.render(scene, output / "part.png")))
        shots[-1].load()
    bpy.ops.prt.hide_transport()
    (output / "part.png").unlink()
    frames.side_by_side(shots).save(output / "PRT_Transport.png")
    return small(output / "PRT_Transport.png")


def small(path: Path) -> Path:
    """A picture in 256 colours, in its place."""
    Image.open(path).convert("RGB").quantize(256).save(path, optimize=True)
    return path


if __name__ == "__main__":
    main()
