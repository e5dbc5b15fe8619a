# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes that resume from a folder of pieces, and shards that merge, have the bits of a bake in one go."""

import gc
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from prt_addon.core.bake import bake as engine
from prt_addon.core.bake import piece_file
from prt_addon.core.bake import trace as casting
from prt_addon.core.bake.run import Run
from prt_addon.core.bake.shards import PieceFolder, Shard
from prt_addon.core.errors import Cancelled, ShardError
from prt_addon.core.files import write_arrays
from prt_addon.core.problem import BakeProblem, BakeSettings, Island, Occluders
from prt_addon.core.transport.raycast import RayScene
from prt_addon.core.workers import Workers
from tests.core.baking import Noting
from tests.core.bouncing import corner, patterned

MODES = ["SHADOWED", "INTERREFLECTED"]
SETTINGS = BakeSettings("INTERREFLECTED", samples=32, seed=2)


@pytest.fixture(autouse=True)
def small_pieces(monkeypatch):
    """Many per object, and some that end inside of one."""
    monkeypatch.setattr(casting, "RAYS_IN_A_PIECE", 32 * 29)


def problem_of(settings=SETTINGS, fingerprint="the scene"):
    """Three surfaces, and one that is baked by itself."""
    groups, occluders = corner(9)
    alone, own = corner(6)
    part = len(alone[0])
    triangles = own.triangles[: len(own.triangles) // 3]
    own = Occluders(own.vertices[:part], triangles, triangles.astype(np.int64))
    islands = Island(groups, patterned(occluders)), Island(alone[:1], own)
    return BakeProblem(islands, settings, fingerprint)


def bake(settings=SETTINGS, **run):
    return engine.bake(problem_of(settings), Run(**run)).transport


def folder_of(tmp_path, settings=SETTINGS, shard=None, fingerprint="the scene"):
    return PieceFolder(tmp_path, problem_of(settings, fingerprint).trace_key, shard)


def bake_shards(tmp_path, count, settings=SETTINGS, indices=None):
    for index in range(count) if indices is None else indices:
        shard = Shard(index, count)
        engine.trace_shard(problem_of(settings), shard, Run(pieces=folder_of(tmp_path, settings, shard)))


def assert_same(results, expected):
    for one, other in zip(results, expected, strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.fixture
def no_rays(monkeypatch):
    """Casting one is an error from when this is called. (A few are, to look for receivers inside of others: none here.)"""

    def forbid():
        def refuse(*_):
            raise AssertionError("a ray was cast")

        monkeypatch.setattr(RayScene, "visible", refuse)
        monkeypatch.setattr(casting, "trace", refuse)

    return forbid


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("count", [1, 2, 5])
def test_shards_merge_to_the_bits_of_one_bake(tmp_path, mode, count, no_rays):
    """In any order; the merge casts no rays."""
    settings = replace(SETTINGS, mode=mode)
    expected = bake(settings)
    bake_shards(tmp_path, count, settings, reversed(range(count)))
    pieces = folder_of(tmp_path, settings)
    pieces.check_complete()
    no_rays()
    monitor = Noting()
    assert_same(bake(settings, workers=Workers(monitor=monitor), pieces=pieces), expected)
    assert monitor.done.rays == problem_of(settings).work.rays


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("after", [0, 1, 7])
def test_a_stopped_bake_resumes_to_the_same_bits(tmp_path, mode, after, no_rays):
    """Wherever it was stopped, and in pieces of another size; a third time needs no rays at all."""
    settings = replace(SETTINGS, mode=mode)
    expected = bake(settings)
    pieces = folder_of(tmp_path, settings)
    calls = 0

    class Stop(Noting):
        def advance(self, work):
            nonlocal calls
            calls += 1
            if calls > after:
                raise Cancelled("enough")

    with pytest.raises(Cancelled):
        bake(settings, workers=Workers(monitor=Stop()), pieces=pieces)
    saved = set(tmp_path.iterdir())
    assert len(saved) == after
    casting.RAYS_IN_A_PIECE = 32 * 41  # the fixture puts it back
    assert_same(bake(settings, pieces=pieces), expected)
    assert saved < set(tmp_path.iterdir())
    no_rays()
    assert_same(bake(settings, pieces=pieces), expected)


def test_other_questions_share_a_folder_and_broken_files_are_traced_again(tmp_path):
    """Checkpoints of several scenes do not get into each other's way."""
    expected = bake(SETTINGS)
    bake(SETTINGS, pieces=folder_of(tmp_path))
    files = sorted(tmp_path.iterdir())
    other = replace(SETTINGS, seed=9)
    assert_same(bake(other, pieces=folder_of(tmp_path, other)), bake(other))
    assert len(list(tmp_path.iterdir())) == 2 * len(files)
    files[0].write_bytes(files[0].read_bytes()[:-100])
    content = bytearray(files[1].read_bytes())
    content[len(content) // 2] ^= 1
    files[1].write_bytes(content)
    files[2].write_bytes(b"")
    (tmp_path / "notes.npz").write_text("not ours")
    np.savez(tmp_path / "theirs.npz", header=np.arange(3))
    np.savez(tmp_path / "number.npz", header=3)
    assert_same(bake(SETTINGS, pieces=folder_of(tmp_path)), expected)


def test_a_shard_that_was_killed_is_done_again(tmp_path):
    """What it wrote of it stays and is used; what lies about under another name is not."""
    bake_shards(tmp_path, 3)
    whole = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    for path in sorted(tmp_path.glob("shard-1-*"))[1:]:
        path.rename(path.with_suffix(".tmp"))
    with pytest.raises(ShardError, match="missing or unfinished: 1"):
        folder_of(tmp_path).check_complete()
    bake_shards(tmp_path, 3, indices=[1, 1])
    folder_of(tmp_path).check_complete()
    assert {path.name for path in tmp_path.glob("*.npz")} == whole.keys()


def test_missing_shards_are_named(tmp_path):
    bake_shards(tmp_path, 6, indices=[0, 2, 3])
    with pytest.raises(ShardError, match=r"missing or unfinished: 1, 4, 5\. .*count=6"):
        folder_of(tmp_path).check_complete()


def test_an_empty_folder_is_said(tmp_path):
    with pytest.raises(ShardError, match="no shards"):
        folder_of(tmp_path).check_complete()
    with pytest.raises(ShardError, match="no shards"):
        folder_of(tmp_path / "not there").check_complete()


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"samples": 64}, "samples 64 instead of 32"),
        ({"seed": 3}, "seed 3 instead of 2"),
        ({"mode": "SHADOWED"}, "mode SHADOWED instead of INTERREFLECTED"),
    ],
)
def test_shards_of_other_settings_are_refused(tmp_path, change, said):
    bake_shards(tmp_path, 2, indices=[0])
    bake_shards(tmp_path, 2, replace(SETTINGS, **change), indices=[1])
    with pytest.raises(ShardError, match=said):
        folder_of(tmp_path).check_complete()


def test_shards_of_another_scene_are_refused(tmp_path):
    bake_shards(tmp_path, 2)
    with pytest.raises(ShardError, match="another scene"):
        folder_of(tmp_path, fingerprint="edited").check_complete()


def test_doubled_shards_are_refused(tmp_path):
    """Of another count, or a copy of a file."""
    bake_shards(tmp_path, 2)
    path = min(tmp_path.iterdir())
    copy = path.with_name("copy.npz")
    copy.write_bytes(path.read_bytes())
    with pytest.raises(ShardError, match="same receivers"):
        folder_of(tmp_path).check_complete()
    copy.unlink()
    bake_shards(tmp_path, 3, indices=[0])
    with pytest.raises(ShardError, match="in 2 and 3 shards"):
        folder_of(tmp_path).check_complete()


def test_damaged_shards_are_refused(tmp_path):
    """By their checksums, before anything is merged."""
    bake_shards(tmp_path, 2)
    path = max(tmp_path.iterdir())
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)
    with pytest.raises(ShardError, match="damaged"):
        folder_of(tmp_path).check_complete()


def test_checkpoints_are_no_shards(tmp_path):
    bake(SETTINGS, pieces=folder_of(tmp_path))
    with pytest.raises(ShardError, match="of no shard"):
        folder_of(tmp_path).check_complete()


def test_shards_are_equal_shares(tmp_path):
    """Every receiver once, also of fewer than there are shards; a shard without any writes nothing."""
    for count in (1, 7, 1000):
        spans = [Shard(index, count).span(279) for index in range(count)]
        assert [n for span in spans for n in range(279)[span]] == list(range(279))
        assert max(span.stop - span.start for span in spans) <= 279 // count + 1
    bake_shards(tmp_path, 1000, indices=[0, 3])
    assert [path.name.split("-")[1] for path in tmp_path.iterdir()] == ["3"]


@pytest.mark.parametrize(("index", "count"), [(3, 3), (-1, 3), (0, 0)])
def test_there_are_no_other_shards(index, count):
    with pytest.raises(ShardError, match="numbered 0 to"):
        Shard(index, count)


def test_a_folder_that_cannot_be_written_is_an_error(tmp_path):
    """Rays that nothing keeps are not cast for nothing."""
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(OSError):
        bake_shards(tmp_path / "file", 1)


@pytest.mark.filterwarnings(
    "ignore::pytest.PytestUnraisableExceptionWarning"
)  # NumPy's zip file tries again when it dies
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="a device that is always full")
def test_a_full_disk_is_named_and_leaves_no_litter(tmp_path, monkeypatch):
    """Every write fails as the last one on a full disk does."""
    monkeypatch.setattr(piece_file, "write_arrays", lambda _, arrays: write_arrays(Path("/dev/full"), arrays))
    with pytest.raises(OSError, match="No space left") as raised:
        bake_shards(tmp_path, 1)
    assert raised.value.filename.endswith(".npz") and not list(tmp_path.iterdir())
    del raised
    gc.collect()


def test_shards_of_several_versions_are_told(tmp_path):
    """They merge: their last bits may differ, and that is said. Those of before versions were noted say nothing."""
    bake_shards(tmp_path, 3)
    assert folder_of(tmp_path).check_complete() == []

    def made_with(path, version):
        with np.load(path) as stored:
            arrays = {name: stored[name] for name in stored.files}
        header = json.loads(arrays["header"].item())
        assert header.pop("numpy") == np.__version__
        arrays["header"] = np.array(json.dumps(header | ({"numpy": version} if version else {})))
        np.savez(path, **arrays)

    first, second, *_ = sorted(tmp_path.iterdir())
    made_with(first, None)
    assert folder_of(tmp_path).check_complete() == []
    made_with(second, "1.0")
    [sentence] = folder_of(tmp_path).check_complete()
    assert f"(1.0, {np.__version__})" in sentence and "last bits" in sentence
