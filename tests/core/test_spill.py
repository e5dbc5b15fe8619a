# SPDX-License-Identifier: GPL-3.0-or-later
"""Arrays past a budget lie in files that nobody else sees."""

import tempfile
from pathlib import Path

import numpy as np
import pytest

from prt_addon.core.errors import NoRoom
from prt_addon.core.spill import Spill, in_file, memory_of


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
