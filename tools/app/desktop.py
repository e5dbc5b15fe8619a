# SPDX-License-Identifier: GPL-3.0-or-later
"""Plays a person at a screen: Blender's window under Xvfb is seen, clicked and typed at.

No button's place is written down here. `find("Bake PRT")` reads the screen by OCR, as eyes would, so a layout may change
without a change here; what a click came to is read from the state that watch.py writes from inside Blender.
"""

from __future__ import annotations

import csv
import json
import os
import re
import subprocess
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

Box = tuple[int, int, int, int]  # left, top, width, height in pixels, y down
LETTERS = 60  # pixels that a row of Blender's interface, 20 at scale 1, is enlarged to: OCR wants large letters
WHITE = "70%,95%"  # levels of Blender's letters over a picture
DEADLINE = 600.0  # seconds to wait for what must come
_PULLS = 10  # steps in which the mouse is dragged
PATIENCE = 20  # looks at the screen, a second apart, before what is not there is missed


@dataclass(frozen=True)
class Line:
    """A line of text on the screen: its words and their boxes."""

    words: list[str]
    boxes: list[Box]

    @property
    def text(self) -> str:
        """Its words in a row."""
        return " ".join(self.words)

    def occurrences(self, wanted: list[str]) -> list[Box]:
        """The boxes of some words in a row, in small letters."""
        words, count = [plain(word) for word in self.words], len(wanted)
        starts = [start for start in range(len(words) - count + 1) if words[start : start + count] == wanted]
        return [bounding_box(self.boxes[start : start + count]) for start in starts]


class Display:
    """A screen without a monitor; ends with the `with`."""

    def __init__(self, width: int, height: int) -> None:
        self.size = (width, height)

    def __enter__(self) -> Display:
        reading, writing = os.pipe()  # Xvfb chooses a number that is free, and says which
        screen = ["-screen", "0", "{}x{}x24".format(*self.size), "-nolisten", "tcp", "-noreset"]
        command = ["Xvfb", "-displayfd", str(writing), *screen]
        self._server = subprocess.Popen(command, stderr=subprocess.DEVNULL, pass_fds=[writing])
        os.close(writing)
        with os.fdopen(reading) as number:
            os.environ["DISPLAY"] = f":{number.readline().strip()}"
        return self

    def __exit__(self, *_: object) -> None:
        self._server.terminate()
        self._server.wait()


class Window:
    """Blender's window, as large as the display, on a file and with a profile; ends with the `with`."""

    def __init__(self, display: Display, blend: Path, profile: Path, pictures: Path, *scripts: Path) -> None:
        self.display, self.blend, self.profile, self.pictures = display, blend, profile, pictures
        self.scripts = (Path(__file__).with_name("watch.py"), *scripts)  # that run inside
        self.scratch = Path("/tmp")
        self.log = pictures / "window.log"
        self._told = pictures / "state.json"

    def __enter__(self) -> Window:
        self._told.unlink(missing_ok=True)
        width, height = map(str, self.display.size)
        command: list[str | Path] = ["blender", "--window-geometry", "0", "0", width, height, self.blend]
        command += [part for script in self.scripts for part in ("--python", script)]
        environment = os.environ | {"BLENDER_USER_RESOURCES": str(self.profile)}
        with self.log.open("w") as log:
            self._blender = subprocess.Popen(
                [*command, "--", self._told], env=environment, stdout=log, stderr=subprocess.STDOUT
            )
        wait_until(lambda: self._told.exists() or self._blender.poll() is not None, "Blender's window")
        assert self._blender.poll() is None, f"Blender did not start: {self.log.read_text()}"
        window = shell("xdotool", "search", "--onlyvisible", "--class", "blender").split()[-1]
        shell("xdotool", "windowfocus", window)  # no window manager does it
        self.hover_view()
        return self

    def __exit__(self, kind: type | None, *_: object) -> None:
        if kind:
            self.screenshot("failure")
        self._blender.kill()
        self._blender.wait()

    def close(self) -> None:
        """Quit as a user does, and wait for the end."""
        self.press_at_rest("ctrl+q")
        self._blender.wait(DEADLINE)

    @property
    def state(self) -> dict[str, Any]:
        """What watch.py has written; at most half a second old."""
        return json.loads(self._told.read_text())

    def wait_for_progress(self, share: float) -> None:
        """Wait until more than a share of a bake is done."""
        self.wait(lambda now: (now["progress"] or 0.0) > share, "progress to move")

    def wait(self, condition: Callable[[dict[str, Any]], bool], what: str) -> dict[str, Any]:
        """Wait until the state is as wanted, and return it."""
        wait_until(lambda: condition(self.state), what)
        return self.state

    def hover_view(self) -> None:
        """Put the mouse over the 3D View: Blender's keys go to what lies under it."""
        left, top, width, height = self.state["view"]
        shell("xdotool", "mousemove", left + width // 4, top + height * 3 // 4)
        time.sleep(0.3)

    def press(self, key: str) -> None:
        """A key or a chord, such as `ctrl+z`."""
        shell("xdotool", "key", "--delay", 150, key)
        time.sleep(0.5)

    def write(self, text: str) -> None:
        """Type letter by letter, into what has the focus."""
        shell("xdotool", "type", "--delay", 150, text)
        time.sleep(1.0)

    def press_at_rest(self, key: str) -> None:
        """The same over the 3D View, once Blender has done what came before: a busy one misses chords."""
        self.hover_view()
        self.settle()
        self.press(key)

    def click(self, x: int, y: int) -> None:
        """Go there, let Blender notice, and click."""
        shell("xdotool", "mousemove", x, y)
        time.sleep(0.4)
        shell("xdotool", "click", 1)
        time.sleep(0.4)

    def click_text(self, text: str, within: Box | None = None, last: bool = False) -> None:
        """Click on words, as `find` finds them."""
        self.click(*centre(self.find(text, within, last=last)))

    def click_tab(self, name: str) -> None:
        """Click on a tab of the sidebar: its name is written top down along the right edge."""
        left, top, width, height = self._tabs
        along, _, length, _ = self.find(name, (left, top, width, height), turned=True)
        self.click(left + width // 2, top + along + length // 2)

    @property
    def panels(self) -> Box:
        """The sidebar, less its tabs."""
        left, top, width, height = self.state["sidebar"]
        return left, top, width - self._tabs[2], height

    @property
    def free_view(self) -> Box:
        """The 3D View, less the sidebar."""
        left, top, _, height = self.state["view"]
        return left, top, self.state["sidebar"][0] - left, height

    @property
    def status_bar(self) -> Box:
        """The bottom of the window."""
        width, height = self.display.size
        strip = round(1.3 * self.state["row"])
        return 0, height - strip, width // 2, strip

    @property
    def _tabs(self) -> Box:
        left, top, width, height = self.state["sidebar"]
        strip = round(1.3 * self.state["row"])
        return left + width - strip, top, strip, min(height, 24 * strip)  # OCR finds little in much emptiness

    def drag(self, x: int, y: int, right: int) -> None:
        """Press there, pull to the right by as many pixels, and let go."""
        shell("xdotool", "mousemove", x, y)
        time.sleep(0.3)
        shell("xdotool", "mousedown", 1)
        for _ in range(_PULLS):
            shell("xdotool", "mousemove_relative", "--", right // _PULLS, 0)
            time.sleep(0.1)
        shell("xdotool", "mouseup", 1)
        time.sleep(0.5)

    def find(self, text: str, within: Box | None = None, turned: bool = False, last: bool = False) -> Box:
        """The box of words that stand in one line, in the panels unless others are given; waits for them a while.

        Where they stand more than once, the first in reading order, or the last.
        """
        wanted = text.lower().split()
        for _ in range(PATIENCE):
            lines = self.read(within or self.panels, turned)
            found = [box for line in lines for box in line.occurrences(wanted)]
            if found:
                return (max if last else min)(found, key=lambda box: (box[1], box[0]))
            time.sleep(1.0)
        raise AssertionError(f"{text!r} is not to be seen among {[line.text for line in lines]}")

    def read(self, box: Box, turned: bool = False, levels: str = "30%,70%") -> list[Line]:
        """The lines of text in a box; `turned` reads text that runs top down, its x counted from the box's top.

        What is darker than the first level is taken for paper, what is lighter than the second for ink.
        """
        seen, enlarged = self.scratch / "seen.ppm", self.scratch / "enlarged.ppm"
        left, top, _, _ = box
        self.crop(box, seen)
        enlargement = max(1, round(LETTERS / self.state["row"]))
        look = f"-colorspace Gray -filter Lanczos -resize {enlargement}00% -level {levels} -negate".split()
        shell("convert", seen, *(["-rotate", "-90"] if turned else []), *look, enlarged)
        table = shell("tesseract", enlarged, "-", "--psm", "11", "-c", "tessedit_create_tsv=1")
        lines: dict[tuple[str, ...], Line] = {}
        for row in csv.DictReader(table.splitlines(), delimiter="\t", quoting=csv.QUOTE_NONE):
            if row["text"] is None or not row["text"].strip():
                continue
            x, y, w, h = (int(row[key]) // enlargement for key in ("left", "top", "width", "height"))
            line = lines.setdefault((row["block_num"], row["par_num"], row["line_num"]), Line([], []))
            line.words.append(row["text"])
            line.boxes.append((x, y, w, h) if turned else (left + x, top + y, w, h))
        return list(lines.values())

    def settle(self) -> None:
        """Wait until nothing moves on the screen and the 3D View no longer says, in its corner, that it compiles."""
        left, top, width, _ = self.state["view"]
        corner = left, top, width // 3, round(7 * self.state["row"])
        before, after = self.scratch / "before.ppm", self.scratch / "after.ppm"
        everything = 0, 0, *self.display.size

        def settled() -> bool:
            self.crop(everything, before)
            time.sleep(2.0)
            self.crop(everything, after)
            if time.time() - self.state["time"] > 1.0 or difference(before, after) > 1e-4:
                return False
            return not any("ompil" in line.text for line in self.read(corner, levels=WHITE))

        wait_until(settled, "the window to come to rest")

    def crop(self, box: Box, path: Path) -> None:
        """A part of the screen."""
        left, top, width, height = box
        shell("import", "-window", "root", "-crop", f"{width}x{height}+{left}+{top}", "+repage", path)

    def screenshot(self, name: str) -> Path:
        """Keep what is on the screen."""
        time.sleep(1.0)
        path = self.pictures / f"{name}.png"
        shell("import", "-window", "root", path)
        return path

    def film(self, name: str, frames: int = 16, pause: float = 0.5) -> list[float]:
        """Keep what is on the screen from now on: a sheet of small pictures, row by row.

        Args:
            name: of the sheet.
            frames: how many pictures.
            pause: seconds between them, at least.

        Returns:
            When each was taken, in seconds from now.
        """
        begun, times, shots = time.monotonic(), list[float](), list[Path]()
        for number in range(frames):
            time.sleep(max(0.0, begun + number * pause - time.monotonic()))
            times.append(time.monotonic() - begun)
            shots.append(self.scratch / f"film_{number}.ppm")
            shell("import", "-window", "root", "-resize", "33%", shots[-1])
        shell("montage", "+label", *shots, "-tile", "4x", "-geometry", "+2+2", self.pictures / f"{name}.png")
        return times


def difference(one: Path, other: Path) -> float:
    """RMS difference of two pictures, 0..1."""
    done = subprocess.run(["compare", "-metric", "RMSE", one, other, "null:"], capture_output=True, text=True)
    found = re.search(r"\((.+)\)", done.stderr)
    assert done.returncode < 2 and found, done.stderr
    return float(found[1])


def plain(word: str) -> str:
    """A word without what OCR makes of icons and frames around it."""
    return re.sub(r"^\W+|\W+$", "", word.lower())


def centre(box: Box) -> tuple[int, int]:
    """Where to click on a box."""
    left, top, width, height = box
    return left + width // 2, top + height // 2


def bounding_box(boxes: list[Box]) -> Box:
    """The smallest box around boxes."""
    left, top = min(b[0] for b in boxes), min(b[1] for b in boxes)
    return left, top, max(b[0] + b[2] for b in boxes) - left, max(b[1] + b[3] for b in boxes) - top


def shell(*command: object) -> str:
    """Run a program and return what it prints; whatever it says of a failure is raised."""
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    if done.returncode:
        raise AssertionError(f"{' '.join(map(str, command))}: {done.stderr.strip()}")
    return done.stdout


def wait_until(condition: Callable[[], bool], what: str) -> None:
    """Raises AssertionError if it does not come true in time, of which a software renderer on a busy machine needs much."""
    end = time.monotonic() + DEADLINE
    while not condition():
        if time.monotonic() > end:
            raise AssertionError(f"waited {DEADLINE:.0f} s in vain for {what}")
        time.sleep(0.1)
