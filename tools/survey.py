# SPDX-License-Identifier: GPL-3.0-or-later
"""Tries the first press of the button in files that other people have made: what is baked, what is said, how long it takes, and
how far EEVEE's picture is from Cycles' with matte surfaces.

    python tools/survey.py FOLDER --page docs/survey.md

Every .blend, .glb, .gltf, .obj, .fbx, .ply and .stl below the folder is opened in a process of its own. The files
are not part of the project: the page names them by their last folder and name.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

SUFFIXES = (".blend", ".glb", ".gltf", ".obj", ".fbx", ".ply", ".stl")
_PATIENCE = 900  # seconds for one file
_BAKE = {"samples": 64, "bounces": 1}
_PICTURE = {"picture_size": 200, "picture_samples": 32, "points": 16, "paths": 16}


def main() -> None:
    """Press the button in all files of a folder, or in one."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("path", type=Path)
    parser.add_argument("--page", type=Path, help="write the table into this Markdown file")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="files at a time")
    parser.add_argument("--one", action="store_true", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.one:
        print("SURVEY " + json.dumps(pressed(given.path)), flush=True)
        os._exit(0)  # what a file brought along may hang at exit
    files = sorted(path for path in given.path.rglob("*") if path.suffix.lower() in SUFFIXES)
    with ThreadPoolExecutor(given.jobs) as pool:
        rows = []
        for path, found in zip(files, pool.map(_in_a_process, files), strict=True):
            rows.append((path, found))
            print(f"{path.parent.name}/{path.name}: {found.get('result') or found.get('error')}", flush=True)
    if given.page:
        given.page.write_text(page(rows), encoding="utf-8")


def _in_a_process(path: Path) -> dict[str, Any]:
    command = [sys.executable, __file__, "--one", str(path)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=_PATIENCE)
    except subprocess.TimeoutExpired:
        return {"error": f"not done after {_PATIENCE} s"}
    lines = [line for line in done.stdout.splitlines() if line.startswith("SURVEY ")]
    if not lines:
        return {"error": f"Blender ended with {done.returncode}"}
    found: dict[str, Any] = json.loads(lines[-1].removeprefix("SURVEY "))
    return found


def pressed(path: Path) -> dict[str, Any]:
    """Open a file, press the button with what it has selected, and compare the engines."""
    import headless
    from headless import bpy

    headless.enable_extension()
    found: dict[str, Any] = {}
    try:
        _open(bpy, path)
    except RuntimeError as error:
        return {"error": str(error).strip().splitlines()[-1].replace(str(path), path.name)}
    scene = bpy.context.scene
    found["objects"] = len(scene.objects)
    began = time.perf_counter()
    try:
        found["result"] = next(iter(bpy.ops.prt.bake(**_BAKE)))
    except RuntimeError as error:
        found["result"], found["said"] = "REFUSED", [str(error).removeprefix("Error: ").strip()]
    found["seconds"] = time.perf_counter() - began
    found["peak"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    if found["result"] == "FINISHED":
        modules = sys.modules
        session = modules[f"{headless.PACKAGE}.prt_addon.session"].session
        carrier = modules[f"{headless.PACKAGE}.prt_addon.scene.mesh.carrier"]
        layers = modules[f"{headless.PACKAGE}.prt_addon.scene.mesh.layers"]
        baked = [ob for ob in scene.objects if ob.type == "MESH" and layers.is_baked(carrier.transport_mesh(ob))]
        found["said"] = [one.sentence for one in session.notices.get(scene.session_uid, ())]
        found["baked"], found["carried"] = len(baked), sum(carrier.carrier_of(ob) is not None for ob in baked)
        found["from_cycles"] = _from_cycles(headless, bpy, baked)
    return found


def _open(bpy: Any, path: Path) -> None:
    """Open a .blend, or import anything else into an empty file."""
    kind = path.suffix.lower()
    if kind == ".blend":
        bpy.ops.wm.open_mainfile(filepath=str(path), load_ui=False)
        return
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    importers = {
        ".glb": bpy.ops.import_scene.gltf,
        ".gltf": bpy.ops.import_scene.gltf,
        ".fbx": bpy.ops.import_scene.fbx,
        ".obj": bpy.ops.wm.obj_import,
        ".ply": bpy.ops.wm.ply_import,
        ".stl": bpy.ops.wm.stl_import,
    }
    importers[kind](filepath=str(path))


def _from_cycles(headless: Any, bpy: Any, baked: list[Any]) -> float | None:
    """Relative RMS between EEVEE and Cycles of what was baked, all of it matte, under a soft sky without lamps."""
    scene = bpy.context.scene
    for ob in bpy.data.objects:
        if ob.type == "LIGHT":
            ob.hide_render = True
    for material in bpy.data.materials:
        _make_matte(headless, bpy, material)
    bpy.ops.prt.use_sky(sky="forest")
    _look_at(bpy, baked)
    for ob in scene.objects:
        if ob.visible_get():
            ob.select_set(ob in baked)
    try:
        bpy.ops.prt.bake(**(_BAKE | {"samples": 256, "bounces": 3}))
        bpy.ops.prt.report(parts={"END_TO_END"}, **_PICTURE)
    except RuntimeError as error:
        print(error, file=sys.stderr)
        return None
    document = json.loads(scene["prt_report"])
    value = document["end_to_end"]["relative_rms"]["value"]  # null where nothing could be compared
    return None if value is None else float(value)


def _make_matte(headless: Any, bpy: Any, material: Any) -> None:
    """A Diffuse BSDF of the colour that the extension reads of a material."""
    parts = f"{headless.PACKAGE}.prt_addon.scene.material."
    if material.node_tree is None or not material.is_editable:
        return
    reading = sys.modules[parts + "reading"].read_material(material, "CYCLES")
    relit = sys.modules[f"{headless.PACKAGE}.prt_addon.scene.shading.relight_material"]
    relit.remove_from_material(material)
    tree = material.node_tree
    shader, output = tree.nodes.new("ShaderNodeBsdfDiffuse"), tree.nodes.new("ShaderNodeOutputMaterial")
    if reading.colour is not None:
        sys.modules[parts + "colour_nodes"].connect(tree, reading.colour, shader.inputs["Color"])
    for node in [node for node in tree.nodes if node.type == "OUTPUT_MATERIAL" and node != output]:
        tree.nodes.remove(node)
    tree.links.new(shader.outputs[0], output.inputs["Surface"])


def _look_at(bpy: Any, objects: list[Any]) -> None:
    """A camera that sees all of the objects from above one corner."""
    from mathutils import Vector

    scene = bpy.context.scene
    bpy.context.view_layer.update()
    corners = [ob.matrix_world @ Vector(corner) for ob in objects for corner in ob.bound_box]
    low = Vector(min(corner[k] for corner in corners) for k in range(3))
    high = Vector(max(corner[k] for corner in corners) for k in range(3))
    centre, radius = (low + high) / 2, max((high - low).length / 2, 1e-3)
    camera = bpy.data.objects.new("Survey", bpy.data.cameras.new("Survey"))
    scene.collection.objects.link(camera)
    away = Vector((0.8, -1.0, 0.6)).normalized()
    camera.location = centre + 3.2 * radius * away
    camera.rotation_euler = away.to_track_quat("Z", "Y").to_euler()
    camera.data.clip_start, camera.data.clip_end = radius / 100, radius * 100
    scene.camera = camera
    scene.render.resolution_x = scene.render.resolution_y = _PICTURE["picture_size"]


def page(rows: list[tuple[Path, dict[str, Any]]]) -> str:
    """The Markdown page of what was found."""
    done = [found for _, found in rows if found.get("result") == "FINISHED"]
    refused = sum("result" in found for _, found in rows) - len(done)
    distances = sorted(found["from_cycles"] for found in done if found.get("from_cycles") is not None)
    middle = f"{distances[len(distances) // 2]:.1%}" if distances else "none"
    lines = [
        "# The first press, in other people's files",
        "",
        "What the button does in files from public repositories, opened as they are: with what they have selected, hidden and",
        "linked, and without the files that they have lost. Made by `tools/survey.py`; the files are not part of the project.",
        "",
        f"{len(done)} of {len(rows)} bake at the first press. {refused} say in one sentence why nothing can be baked.",
        f"Not opened, or not done in {_PATIENCE} s: {len(rows) - len(done) - refused}.",
        "",
        f"*From Cycles*: relative RMS between EEVEE's picture and Cycles', all surfaces matte, under Blender's *forest*; {middle} in",
        "the middle. Nine coefficients and vertices as these files have them are what most of it is. *Carried*: objects whose",
        "transport lies on a carrier. Seconds and MiB of the press with 64 samples and one bounce, Blender included.",
        "",
        "| File | Baked | Carried | Seconds | MiB | From Cycles | Said |",
        "|---|---|---|---|---|---|---|",
    ]
    for path, found in rows:
        name = f"{path.parent.name.split('+')[-1]}/{path.name}"
        said = " ".join(found.get("said", [found.get("error", "")]))
        said = said.replace("|", "/").replace("\n", " ")
        if "result" not in found:
            lines.append(f"| {name} | | | | | | {said} |")
            continue
        from_cycles_text = "" if found.get("from_cycles") is None else f"{found['from_cycles']:.1%}"
        lines.append(
            f"| {name} | {found.get('baked', 0)} of {found['objects']} | {found.get('carried', '')} | "
            f"{found['seconds']:.1f} | {found['peak']:.0f} | {from_cycles_text} | {said} |"
        )
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    main()
