# SPDX-License-Identifier: GPL-3.0-or-later
"""A test that fails leaves its pictures, and one that passes leaves none."""

import subprocess
import sys

import numpy as np
import pytest
from PIL import Image

pytestmark = pytest.mark.once

TESTS = """
import headless  # before bpy
import numpy as np, pytest, stage

@pytest.mark.parametrize("good", [True, False])
def test_frames(tmp_path, good):
    for name, grey in (("truth", 0.5), ("shown", 0.4)):
        image = stage.picture(name, np.full((8, 16, 3), grey))
        image.filepath_raw, image.file_format = str(tmp_path / f"{name}.exr"), "OPEN_EXR"
        image.save()
    assert good
"""


def test_frames_of_failed_tests_are_kept(tmp_path):
    """Reference, output and four times their difference."""
    import headless

    (tmp_path / "test_it.py").write_text(TESTS)
    folders = [headless.CHECKOUT / name for name in ("tests", "tools")]
    run = subprocess.run(
        [
            *(sys.executable, "-m", "pytest", "-p", "failed_pictures", f"--failed-pictures={tmp_path / 'failed'}"),
            *(f"--rootdir={tmp_path}", "-opythonpath=" + " ".join(map(str, folders)), "test_it.py"),
        ],
        cwd=tmp_path,
        env={"PYTHONPATH": str(folders[0]), "PATH": ""},
        capture_output=True,
        text=True,
    )
    assert "1 failed, 1 passed" in run.stdout, run.stdout + run.stderr
    [folder] = (tmp_path / "failed").iterdir()
    assert "False" in folder.name and str(folder / "shown.png") in run.stdout
    middle = {path.stem: np.asarray(Image.open(path))[4, 8, 0] / 255 for path in folder.iterdir()}
    expected = {"truth": 0.5, "shown": 0.4, "shown_less_truth": 0.4}
    assert middle == pytest.approx({name: grey ** (1 / 2.2) for name, grey in expected.items()}, abs=0.004)
