# SPDX-License-Identifier: GPL-3.0-or-later
"""Tries the zips that people install, in the application that people use: the acceptance suite.

Run by run.sh as root of the folder that root.sh set up. Leaves a picture of every step beside itself, to be looked at.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

from desktop import Box, Display, Window, centre, difference

HERE = Path(__file__).resolve().parent
SCENE, BAKED, FULL = (HERE / f"{name}.blend" for name in ("scene", "baked", "full"))
WITH, WITHOUT, NO_WHEELS = (HERE / name for name in ("with", "without", "no_wheels"))  # profiles
BAKE = "import bpy; bpy.ops.prt.bake(samples=64); bpy.ops.wm.save_as_mainfile(filepath='{}')"
F3 = "69"  # the key's code: by name, xdotool makes it a chord
NO_WORLD = "import bpy; bpy.context.scene.world = None; bpy.ops.prt.project_light()"


def main() -> None:
    """All of it, in the order of a user's first day."""
    with Display(1280, 1400) as display:
        install(WITH, next(HERE.glob("*linux_x64.zip")))
        blender(WITH, "-b", "--python", HERE / "scene.py", "--", SCENE)
        step("installed from the zip")
        batch()
        first_day(display)
        disabled_while_baking(display)
        keyframe_light(display)
    legible("at_100_percent", 1.0, (1280, 3100))
    legible("at_200_percent", 2.0, (1800, 6100))
    without_ray_caster()
    print("The application accepts it. Look at the pictures.")


def step(said: str) -> None:
    """Print what has been done."""
    print(f"  {said}", flush=True)


def blender(profile: Path, *arguments: object, status: int = 0) -> str:
    """Run Blender with a profile, insist on its exit status, and return all that it says."""
    environment = os.environ | {"BLENDER_USER_RESOURCES": str(profile)}
    command = ["blender", *map(str, arguments)]
    done = subprocess.run(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    assert done.returncode == status, f"{command} exited with {done.returncode}:\n{done.stdout}"
    return done.stdout


def install(profile: Path, zip_file: Path) -> None:
    """The zip into a fresh profile, from the command line; no splash screen over the window, no render for a save."""
    blender(profile, "--command", "extension", "install-file", "-r", "user_default", "--enable", zip_file)
    prefer(profile, "view.show_splash = False")
    prefer(profile, "filepaths.file_preview_type = 'NONE'")


def prefer(profile: Path, setting: str) -> None:
    """Set a preference, and keep it."""
    blender(
        profile, "-b", "--python-expr", f"import bpy; bpy.context.preferences.{setting}; bpy.ops.wm.save_userpref()"
    )


def batch() -> None:
    """From the command line: success and failure to the shell, and a file that needs no extension afterwards."""
    blender(WITH, "-b", SCENE, "--python-exit-code", "1", "--python-expr", BAKE.format(BAKED))
    said = blender(WITH, "-b", SCENE, "--python-exit-code", "1", "--python-expr", NO_WORLD, status=1)
    assert "world" in said, said
    step("batch bake: exits with 0 on success, with 1 and a sentence on failure")
    said = blender(WITH, "-b", BAKED, "--python", HERE / "frames.py", "--", HERE / "batch_with")
    assert "relit by the extension" in said, said
    said = blender(WITHOUT, "-b", BAKED, "--python", HERE / "frames.py", "--", HERE / "batch_without")
    assert "relit without the extension" in said, said
    for degrees in (0, 90):
        assert difference(HERE / f"batch_with_{degrees}.png", HERE / f"batch_without_{degrees}.png") < 1e-3
    assert difference(HERE / "batch_without_0.png", HERE / "batch_without_90.png") > 0.02
    step("the baked file turns and renders alike in a Blender without the extension")
    blender(WITH, "-b", BAKED, "--python-exit-code", "1", "--python", HERE / "full.py", "--", FULL)


def first_day(display: Display) -> None:
    """Open, bake, change one's mind, bake, turn, undo, redo, remove, save, reopen: by mouse and keys."""
    baked, turned = bake_and_turn(display)
    remove_what_was_saved(display, baked, turned)
    with Window(display, SCENE, WITH, HERE) as window:
        assert window.state["baked"] == 0
        window.settle()
        window.screenshot("window_9_removed_and_reopened")
    no_traceback(window)
    step("saved, reopened, removed, saved and reopened")


def bake_and_turn(display: Display) -> tuple[object, object]:
    """From an unbaked file to a baked, turned and saved one; its content and its turn."""
    with Window(display, SCENE, WITH, HERE) as window:
        pristine = window.state["content"]
        open_tab(window)
        look_through_camera(window)
        window.screenshot("window_1_tab")
        look_into_menu(window)
        cancel_half_way(window, pristine)
        baked, turned = bake_by_button(window), turn_world(window)
        undo_and_redo(window, pristine, baked, turned)
        window.press_at_rest("ctrl+s")
        window.wait(lambda now: now["saved"], "the file to be saved")
        window.close()
    no_traceback(window)
    return baked, turned


def cancel_half_way(window: Window, pristine: object) -> None:
    """Bake from the search menu until a preview is there, and stop: the file is as it was."""
    search(window, "Bake PRT")
    window.hover_view()
    window.wait(lambda now: now["previews"], "a preview")
    for share in (0.1, 0.3):
        window.wait_for_progress(share)
    window.screenshot("window_2_baking")
    assert window.state["progress"], "the bake is too quick to be stopped half way"
    assert len(window.state["previews"]) == 2, "no preview is shown"
    window.press("Escape")
    now = window.wait(lambda now: now["progress"] is None, "Esc to stop the bake")
    assert now["content"] == pristine and not now["previews"], "a cancelled bake changed the file"
    window.settle()
    window.screenshot("window_3_cancelled")
    step("Esc half way leaves everything as it was")


def bake_by_button(window: Window) -> object:
    """Bake to the end; the file's content."""
    window.click_text("Bake PRT")
    times = window.film("window_4_first_seconds")
    now = window.wait(lambda now: now["progress"] is None and now["baked"] == 2, "the bake to end")
    assert not now["previews"], "a preview is left of a whole bake"
    step(f"the button bakes, the progress moves; filmed at {', '.join(f'{one:.1f}' for one in times)} s")
    return now["content"]


def turn_world(window: Window) -> object:
    """Turn the world by its slider, and the light in the viewport with it; the turn."""
    before = picture_of_view(window, "window_4_baked")
    turn_by_slider(window)
    window.wait(lambda now: abs(now["turn"][2]) > 0.1, "the slider to turn the world")
    after = picture_of_view(window, "window_5_turned")
    assert difference(before, after) > 0.02, "the viewport did not turn with the world"
    step("the slider turns the light in the viewport")
    return window.state["turn"]


def undo_and_redo(window: Window, pristine: object, baked: object, turned: object) -> None:
    """Undo the turn and then the bake, a step each, and redo both."""
    window.press_at_rest("ctrl+z")
    window.wait(lambda now: now["turn"] != turned and now["baked"] == 2, "undo of the turn")
    window.press_at_rest("ctrl+z")
    window.wait(lambda now: now["content"] == pristine, "undo of the bake in one step")
    window.settle()
    window.screenshot("window_6_undone")
    window.press_at_rest("ctrl+shift+z")
    window.wait(lambda now: now["content"] == baked, "redo of the bake")
    window.press_at_rest("ctrl+shift+z")
    window.wait(lambda now: now["turn"] == turned, "redo of the turn")
    window.settle()
    window.screenshot("window_7_redone")
    step("undo and redo, a step each")


def remove_what_was_saved(display: Display, baked: object, turned: object) -> None:
    """Reopen the baked file, look at it, and save it without anything of ours."""
    with Window(display, SCENE, WITH, HERE) as window:
        now = window.state
        assert now["content"] == baked, f"saved: {baked}\nreopened: {now['content']}"
        assert now["turn"] == turned, f"saved with a turn of {turned}, reopened with {now['turn']}"
        open_tab(window)
        render_view(window)  # Blender opens no file with it
        portraits(window)
        window.click_text("Remove PRT")
        window.wait(lambda now: now["baked"] == 0, "removal")
        window.press_at_rest("ctrl+s")
        window.wait(lambda now: now["saved"], "the file to be saved")
        window.close()
    no_traceback(window)


def disabled_while_baking(display: Display) -> None:
    """Preferences take the extension away in the middle of a bake: it stops, and nothing of it is left."""
    with Window(display, SCENE, WITH, HERE, HERE / "disable.py") as window:
        pristine = window.state["content"]
        open_tab(window)
        window.click_text("Bake PRT")
        window.wait(lambda now: not now["enabled"], "the extension to be disabled")
        now = window.wait(lambda now: now["progress"] is None, "the bake to stop")
        assert now["content"] == pristine, "a bake that was stopped by disabling changed the file"
        window.settle()
        window.screenshot("window_disabled")
        said = [line.text for line in window.read(window.status_bar)]
        assert not any("PRT" in line or "Bak" in line for line in said), f"left in the status bar: {said}"
    no_traceback(window)
    step("disabling during a bake stops it and leaves nothing behind")


def keyframe_light(display: Display) -> None:
    """By search and its dialog: the window goes on, Esc leaves everything as it was, and the end is one step of undo."""
    with Window(display, BAKED, WITH, HERE) as window:
        before = window.state
        search(window, "Keyframe Light")
        window.press("Return")
        window.wait(lambda now: now["frame"] > 3, "the frames to pass")
        window.screenshot("window_keyframing")
        window.press("Escape")
        now = window.wait(lambda now: not now["busy"], "Esc to stop it")
        assert now["frame"] == before["frame"] and now["content"] == before["content"] and not now["keyframes"], now
        search(window, "Keyframe Light")
        window.press("Return")
        now = window.wait(lambda now: now["keyframes"] > 0 and not now["busy"], "the keyframes")
        assert now["frame"] == before["frame"], now
        window.press_at_rest("ctrl+z")
        window.wait(lambda now: now["keyframes"] == 0, "undo of the keyframes in one step")
    no_traceback(window)
    step("Keyframe Light goes on behind a live window, and Esc stops it")


def legible(name: str, scale: float, size: tuple[int, int]) -> None:
    """All of the tab at the sidebar's default width, with every panel open: no word may be cut off."""
    prefer(WITH, f"view.ui_scale = {scale}")
    with Display(*size) as display, Window(display, FULL, WITH, HERE) as window:
        open_tab(window)
        for panel in window.state["folded"]:
            unfold(window, panel)
        window.find("Export GAMES202")  # at the very end: the window is tall enough
        window.screenshot(name)
        lines = [line.text for line in window.read(window.panels)]
        cut = [line for line in lines if re.search(r"\.\.|…", line)]  # how Blender shortens what does not fit
        assert not cut, f"cut off at {scale:.0%}: {cut}"
    no_traceback(window)
    prefer(WITH, "view.ui_scale = 1.0")
    step(f"nothing is cut off at {scale:.0%}")


def without_ray_caster() -> None:
    """The zip without wheels: the panel says what is missing, and nothing raises."""
    install(NO_WHEELS, HERE / min((path.name for path in HERE.glob("prt_relight-*.zip")), key=len))
    with Display(1280, 1100) as display, Window(display, SCENE, NO_WHEELS, HERE) as window:
        open_tab(window)
        window.find("ray caster is missing")
        window.screenshot("no_wheels_1_tab")
        window.click_text("Bake PRT")
        window.settle()
        assert window.state["progress"] is None and window.state["baked"] == 0
        window.screenshot("no_wheels_2_refused")
    no_traceback(window)
    step("without embreex the panel says so, and refuses in a sentence")


def open_tab(window: Window) -> None:
    """The sidebar by its key, the tab by a click, unless a saved file has them open: another click folds the tab."""
    if not window.state["sidebar"]:
        window.press("n")
        window.wait(lambda now: now["sidebar"], "the sidebar")
        window.settle()
    if window.state["tab"] != "PRT":
        window.click_tab("PRT")
        window.wait(lambda now: now["tab"] == "PRT", "the tab")
    window.hover_view()


def look_through_camera(window: Window) -> None:
    """The camera's view, rendered."""
    window.press("KP_0")
    render_view(window)


def render_view(window: Window) -> None:
    """Rendered shading: the pie menu of Z, and its item on top; once more if a busy machine missed a key."""
    for _ in range(3):
        window.hover_view()
        for key in ("z", "8"):
            window.press(key)
        window.settle()
        if window.state["shading"] == "RENDERED":
            return
        window.press("Escape")
    raise AssertionError("the pie menu of Z does not lead to rendered shading")


def look_into_menu(window: Window) -> None:
    """Object > PRT opens, and offers all operators."""
    window.click_text("Object", window.state["header"], last=True)
    window.click_text("PRT", window.free_view, last=True)
    left, top, width, _ = window.free_view
    window.find("Copy Info", (left, top, width, window.display.size[1] - top))  # a long menu hangs out of the view
    window.screenshot("window_1_menu")
    for _ in range(2):
        window.press("Escape")


def search(window: Window, name: str) -> None:
    """F3, an operator's name, and Enter."""
    window.press_at_rest(F3)
    window.write(name)
    window.find(name, window.state["view"], last=True)
    window.screenshot("window_1_search")
    window.press("Return")


def turn_by_slider(window: Window) -> None:
    """Pull the field of the rotation about Z, two rows below the one that is called Rotation."""
    left, _, width, _ = window.panels
    _, y = centre(window.find("Rotation"))
    window.drag(left + int(width * 0.6), y + round(2 * window.state["row"]), 350)


def picture_of_view(window: Window, name: str) -> Path:
    """The middle of the 3D View at rest; the whole screen is kept."""
    left, top, width, height = window.state["view"]
    view = window.scratch / f"{name}.png"
    window.hover_view()
    window.settle()
    window.crop((left + width // 4, top + height // 4, width // 2, height // 2), view)
    window.screenshot(name)
    return view


def portraits(window: Window) -> None:
    """The pictures of the pages: the window, and its panels after a bake, a check and a report."""
    window.click_text("Check Bakes")
    window.find("fresh when last checked")
    window.hover_view()
    window.settle()
    window.screenshot("window_8_reopened")
    unfold(window, "Preview")
    window.crop(drawn_panels(window), HERE / "panel.png")
    window.click_text("Preview")
    unfold(window, "Report")
    window.click_text("Report", last=True)
    window.wait(lambda now: now["reported"], "the report")
    window.hover_view()
    window.settle()
    window.crop(drawn_panels(window), HERE / "panel_report.png")


def unfold(window: Window, panel: str) -> None:
    """Click on a panel's name, and let it slide open: the last of these words, as others may speak of them before."""
    window.click_text(panel, last=True)
    window.hover_view()
    window.settle()


def drawn_panels(window: Window) -> Box:
    """The sidebar from its top to its last words."""
    left, top, width, _ = window.state["sidebar"]
    bottom = max(y + height for line in window.read(window.panels) for _, y, _, height in line.boxes)
    return left, top, width, round(bottom + window.state["row"] / 2 - top)


def no_traceback(window: Window) -> None:
    """Fail if Blender has printed one."""
    said = window.log.read_text()
    assert "Traceback" not in said, said


if __name__ == "__main__":
    try:
        main()
    except AssertionError as failure:
        sys.exit(f"The application does not accept it: {failure}")
