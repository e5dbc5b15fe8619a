# SPDX-License-Identifier: GPL-3.0-or-later
"""Files are there as wholes or not at all; arrays past a budget lie in files that no other program sees."""

import os
import signal
import stat
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import pytest

from prt_addon.core.errors import NoRoom
from prt_addon.core.files import Spill, in_file, memory_of, write_arrays, written


def test_what_fits_stays_in_memory_and_the_rest_goes_to_disk():
    """In the order given; a smaller one may still fit after a larger did not."""
    spill = Spill(1000)
    arrays = [np.arange(n, dtype=np.uint64) * 3 for n in (100, 50, 25, 0)]
    kept = [spill.keep(array) for array in arrays]
    assert [in_file(array) for array in kept] == [False, True, False, False]
    assert memory_of(*kept) == 1000
    for array, same in zip(arrays, kept, strict=True):
        np.testing.assert_array_equal(array, same)
        assert same.dtype == array.dtype


def test_what_lies_in_a_file_already_is_not_copied():
    """As the pieces of a checkpoint."""
    spill = Spill(0)
    first = spill.keep(np.ones((3, 2), dtype=np.uint16))
    assert spill.keep(first) is first
    assert first.shape == (3, 2)


def test_no_file_is_left(tmp_path, monkeypatch):
    """Neither while the array is in use, where the system allows that, nor after."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    kept = Spill(0).keep(np.arange(10_000))
    assert kept.sum() == 49_995_000
    del kept
    assert not list(Path(tmp_path).iterdir())


def test_no_room_says_what_to_do(tmp_path, monkeypatch):
    """Here the folder is gone; a full disk comes out the same way."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "gone"))
    with pytest.raises(NoRoom, match="TMPDIR"):
        Spill(0).keep(np.arange(10))


def left(folder):
    return sorted(path.name for path in folder.iterdir())


def test_files_appear_together(tmp_path):
    """Not before all are complete; an error leaves what was there."""
    one, two = tmp_path / "sub" / "one.txt", tmp_path / "sub" / "two.txt"
    with written(one, two) as (first, second):
        first.write_text("1")
        second.write_text("2")
        assert not one.exists() and not two.exists()
    assert (one.read_text(), two.read_text()) == ("1", "2")
    with pytest.raises(ZeroDivisionError), written(one, two) as (first, second):
        first.write_text("3")
        1 / 0  # noqa: B018
    assert (one.read_text(), two.read_text()) == ("1", "2") and left(one.parent) == ["one.txt", "two.txt"]


@pytest.mark.skipif(os.name == "nt", reason="the rights of POSIX")
def test_others_may_read_them(tmp_path):
    """As any file that a program makes, by the user's umask: another user merges shards."""
    before = os.umask(0o022)
    try:
        with written(tmp_path / "shared") as (path,):
            path.write_text("1")
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "shared").stat().st_mode) == 0o644


KILLED = """
import os, sys, time
sys.path.insert(0, sys.argv[1])
from pathlib import Path
from prt_addon.core.files import written
with written(Path(sys.argv[2])) as (path,):
    with path.open("w") as file:
        file.write("half")
        file.flush()
        print("ready", flush=True)
        time.sleep(60)
"""


@pytest.mark.skipif(os.name == "nt", reason="processes are killed by signals")
def test_a_killed_process_ruins_nothing(tmp_path):
    """The file is what it was, and the next write removes what was left; what a living process writes stays."""
    path = tmp_path / "kept.txt"
    path.write_text("whole")
    command = [sys.executable, "-c", KILLED, Path(__file__).resolve().parents[2], path]
    dead, alive = (subprocess.Popen(command, stdout=subprocess.PIPE, text=True) for _ in range(2))
    assert dead.stdout.readline() == alive.stdout.readline() == "ready\n"
    dead.send_signal(signal.SIGKILL)
    dead.wait()
    assert path.read_text() == "whole" and len(left(tmp_path)) == 3
    try:
        with written(tmp_path / "other.txt") as (other,):
            other.write_text("1")
        assert len(left(tmp_path)) == 3 and f"~{alive.pid}." in " ".join(left(tmp_path))
    finally:
        alive.kill()
        for process in (dead, alive):
            process.communicate()


def test_old_leftovers_of_other_machines_go(tmp_path):
    young, old = (tmp_path / f".x~elsewhere~{number}.tmp" for number in (1, 2))
    for path in (young, old):
        path.touch()
    os.utime(old, (time.time() - 1e6,) * 2)
    with written(tmp_path / "new") as (path,):
        path.touch()
    assert left(tmp_path) == [young.name, "new"]


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="a disk that is always full")
def test_a_full_disk_complains_once(tmp_path, capfd):
    """With the name of the file; numpy.savez adds "Exception ignored" when the archive goes."""
    with pytest.raises(OSError, match="No space left"):
        write_arrays(Path("/dev/full"), {"zeros": np.zeros(1 << 20)})
    import gc

    gc.collect()
    assert "ignored" not in capfd.readouterr().err
    (tmp_path / "file").touch()
    with pytest.raises(OSError) as raised, written(tmp_path / "file" / "below"):
        pass
    assert raised.value.filename.endswith(("file", "below"))


def test_arrays_are_read_as_numpy_reads_them(tmp_path):
    rng = np.random.default_rng(0)
    arrays = {"one": rng.random((5, 3)), "two": np.array("text"), "three": np.arange(0)}
    write_arrays(tmp_path / "a.npz", arrays)
    with np.load(tmp_path / "a.npz") as stored:
        assert stored.files == list(arrays)
        for name, array in arrays.items():
            np.testing.assert_array_equal(stored[name], array)
